# SPDX-License-Identifier: GPL-2.0-or-later
"""Parameters of a scene that were changed between runs: what is kept of that."""

from ..engine.gridSolver import GridSolver

FOUND = ("facets",)  # of a BoundaryLoad: it leaves out those of bonded bodies, and nobody may set them
FLAGS = ("inertiaScale", "isDamped", "fbar", "group", "implicit")  # of bodies


def parametersOf(scene):
    """What may be changed between runs, a dict name -> value: of engines, prescribed motions, materials and
    bodies, and the time step that was given."""
    found = {"scene.dt": scene._dt}
    for number, engine in enumerate(scene.engines):
        name = engine.label or type(engine).__name__
        name = name if f"{name}.dead" not in found else f"{name} {number}"
        given = {key: value for key, value in engine.attributes().items() if key not in FOUND}
        found.update({f"{name}.{key}": value for key, value in given.items()})
        found[f"{name}.dead"] = engine.dead
        if isinstance(engine, GridSolver):
            for one in (*engine.holds, *engine.drives, *engine._faceHolds.values()):
                found[f"{one.name}.velocity"], found[f"{one.name}.ramp"] = one.velocity, one.ramp
    for body in scene.bodies:
        found.update({f"'{body.name}'.{flag}": getattr(body, flag) for flag in FLAGS})
        values = body.material.attributes().items()
        found.update({f"'{body.name}'.material.{key}": value for key, value in values})
    return {name: _plain(value) for name, value in found.items()}


def _plain(value):
    """As JSON would bring it back."""
    if isinstance(value, (tuple, list)):
        return [_plain(v) for v in value]
    isPlain = value is None or isinstance(value, (bool, int, float, str))
    return value if isPlain else repr(value)


class Changes:
    """Notes what differs from the run before; `scene.changes` is its list."""

    def __init__(self):
        self.all, self._known = [], None

    def restore(self, scene, noted):
        """Of a scene from a checkpoint."""
        self.all, self._known = list(noted), parametersOf(scene)

    def look(self, scene):
        """Called before each run and checkpoint; a scene that has not run yet has no changes."""
        now, before = parametersOf(scene), self._known
        self._known = now
        if before is None or scene.steps == 0:
            return
        for name in [*now, *(n for n in before if n not in now)]:
            old, new = before.get(name), now.get(name)
            if old != new:
                self.all.append(
                    {"step": scene.steps, "time": scene.time, "what": name, "before": old, "after": new}
                )
