# SPDX-License-Identifier: GPL-2.0-or-later
"""All public entries, which introspection finds, and arguments for them that are most likely wrong."""

import importlib
import inspect

import numpy as np

MODULES = ("diagnostics", "engine", "io.files", "plot", "rigid", "geotech", "app", "study")


class Setter:
    """Sets an attribute."""

    isSetter = True

    def __init__(self, thing, name):
        self.thing, self.name = thing, name

    def __call__(self, value):
        setattr(self.thing, self.name, value)


def signatureOf(thing):
    try:
        return [p for p in inspect.signature(thing).parameters.values() if p.kind not in (p.VAR_POSITIONAL,)]
    except (TypeError, ValueError):
        return []


def entriesOf(fixtures):
    """List of (label, function(fixtures) -> Entry): all that users can call or set."""
    found = []

    def isOurs(thing):
        return str(getattr(thing, "__module__", "")).startswith("yade_mpm")

    spaces = {"mpm": fixtures.mpm}
    spaces.update({n: importlib.import_module(f"yade_mpm.{n}") for n in MODULES})
    for space, module in spaces.items():
        for name, thing in sorted(vars(module).items()):
            if not name.startswith("_") and callable(thing) and isOurs(thing):
                found.append((f"{space}.{name}()", lambda f, t=thing, n=name: (t, [n])))
    for label, make in fixtures.objects().items():
        one = make()
        for name in sorted(n for n in dir(one) if not n.startswith("_")):
            try:
                value = getattr(one, name)
            except Exception:
                value = None
            kinds = [k.__name__ for k in type(one).__mro__]
            if callable(value) and isOurs(value):
                found.append(
                    (
                        f"{label}.{name}()",
                        lambda f, m=label, n=name, k=kinds: (getattr(f.objects()[m](), n), [n, *k]),
                    )
                )
            found.append(
                (
                    f"{label}.{name} =",
                    lambda f, m=label, n=name, k=kinds: (Setter(f.objects()[m](), n), [n, *k]),
                )
            )
    return found


def argumentsFor(rng, fixtures, thing):
    """Arguments, at least one of which is most likely wrong."""
    parameters = signatureOf(thing)
    if not parameters:
        return [fixtures.junk(rng) for _ in range(rng.choice([0, 1, 1, 2]))], {}
    given = {}
    for p in parameters:
        if p.kind is p.VAR_KEYWORD:
            continue
        if p.default is not p.empty and rng.random() < 0.6:
            continue
        try:
            given[p.name] = fixtures.valid(p.name, rng) if rng.random() < 0.6 else fixtures.junk(rng)
        except KeyError:
            given[p.name] = fixtures.junk(rng)
    if given and rng.random() < 0.9:
        given[rng.choice(list(given))] = fixtures.junk(rng)
    if getattr(thing, "isSetter", False):
        return [fixtures.junk(rng)], {}
    core = getattr(thing, "_make", None)
    if any(p.kind is p.VAR_KEYWORD for p in parameters) and core and rng.random() < 0.8:
        known = [p["name"] for p in core(thing._coreName).parameters()]
        for name in {"density", "lame"} & set(known):
            given.setdefault(name, fixtures.valid(name, rng))
        if known:
            given[rng.choice(known)] = fixtures.junk(rng)
    if rng.random() < 0.03:
        given[rng.choice(["hallo", "lowr", "x"])] = fixtures.junk(rng)
    if given and rng.random() < 0.03:
        given.pop(rng.choice(list(given)))
    return [], given


def use(fixtures, made):
    """Puts what was made to work, and steps the scene; returns the scene."""
    mpm, scene = fixtures.mpm, fixtures.scene
    place = mpm.box((0, 0), (1, 1))
    if isinstance(made, mpm.Grading):
        made = mpm.Scene((0, 0), (4, 4), 0.5, threads=1, grading=made)
    if isinstance(made, mpm.Scene):
        scene = made
        if not scene.bodies:
            scene.threads = 1
            scene.add("third", place, fixtures.material, mpm.UGIMP())
    elif isinstance(made, mpm.engine.Engine):
        scene.engines = [*scene.engines, made]
    elif isinstance(made, mpm.engine.Prescribed):
        kind = "drive" if isinstance(made, mpm.Drive) else "hold"
        solver = mpm.GridSolver(**{kind: made})
        scene.engines = [mpm.ParticleToGrid(), solver, mpm.GridToParticle(), mpm.DomainUpdater()]
    elif isinstance(made, mpm.Material):
        scene.add("third", place, made, mpm.UGIMP())
    elif isinstance(made, mpm.ParticleType):
        scene.add("third", place, fixtures.material, made)
    elif isinstance(made, (mpm.Region, mpm.Mesh)):
        kind = mpm.UGIMP() if isinstance(made, mpm.Region) else mpm.APDI()
        scene.add("third", made, fixtures.material, kind)
    scene.run(steps=2, progress=False)
    return scene


def nonsense(scene):
    """What a run that went well has left and cannot be; empty: nothing."""
    for body in scene.bodies:
        for name in ("mass", "volume", "position", "velocity", "stress"):
            if not np.isfinite(getattr(body, name)).all():
                return f"{name} of '{body.name}' is not finite"
        if (body.mass <= 0).any() or (body.volume <= 0).any():
            return f"mass or volume of '{body.name}' is not positive"
    return ""
