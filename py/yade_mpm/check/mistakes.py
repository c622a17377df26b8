# SPDX-License-Identifier: GPL-2.0-or-later
"""What is allowed in a scene, but is more likely a mistake: units that do not fit, stresses and piles that
the model cannot take."""

import numpy as np

from ..engine.boundaryLoad import BoundaryLoad
from ..engine.contact import Contact
from ..engine.poreWater import PoreWater
from ..engine.prescribed import Drive
from ..engine.rigidContact import RigidContact
from ..engine.supports import PointForce, Spring, SurfaceLoad
from ..material.materials import MaterialPoint
from ..material.spatial import largestOf
from . import limits
from .touching import contactMistakes

LOADS = BoundaryLoad, Spring, PointForce, SurfaceLoad
UNIT_WEIGHTS = 12, 30  # kN/m3; in Mg/m3 only the heaviest metals are that dense
STEEPEST = 0.96  # rad, 55 degrees; dense angular gravel has 50
HARDEST = 1e4  # kPa; clay has up to some hundred, soft rock some thousand
ANGLES = 5, 85  # degrees; no coefficient of friction is that large
SLOWEST = 30  # m/s; compression waves in the softest soils are faster
FASTEST = 2e4  # m/s; compression waves in diamond: 1.8e4
ROUNDOFF = 1e-6  # relative, of a stress
# cells, of a rigid body with the soil; with the default stiffness p/kappa is less under 0.5 % of rho c^2
OVERLAP = 0.02
PERMEABLE = 1.0  # m/s; clean gravel has up to 0.1 or so
UNEQUAL = 0.5  # of the mass of a cell: tied sides that differ by more have other profiles
OVERDRAWN = 0.99  # of the hydrostatic pressure that water lacks: where gravity was zero, all of it


def likelyMistakes(scene, gravity):
    """Yields a text for each. gravity : of the solver, m/s2."""
    if scene._isLeftAsMade() and not _isMoved(scene):
        yield (
            "Scene: no engines were given, and the default ones have neither gravity nor walls; give "
            "e.g. mpm.Scene(..., gravity=9.81), and call scene.fix('bottom')"
        )
    if scene.scheme == "USF":
        yield (
            "Scene: scheme = 'USF' is first order in time, for vertices move before the solution and "
            "particles after it; take MUSL, or look whether half the time step changes the results"
        )
    for body in scene.bodies:
        yield from _units(body, gravity)
        yield from _strength(body)
        yield from _beyondYield(body)
        yield from _locking(body)
    if scene._geostaticGravity is not None and not np.isclose(
        scene._geostaticGravity, -gravity[-1] if gravity else 0
    ):
        yield (
            f"Scene: initialStress was made for {scene._geostaticGravity:g} m/s2 downwards, the GridSolver "
            f"has gravity = {gravity} m/s2; the ground will move"
        )
    yield from _leftOut(scene)
    yield from _water(scene)
    yield from _tied(scene)
    groups = dict.fromkeys(b.group for b in scene.bodies)
    if len(groups) > 1 and not any(isinstance(e, Contact) for e in scene.engines):
        yield (
            f"Scene: the groups {', '.join(map(repr, groups))} stick together, for there is no Contact among "
            "the engines"
        )
    for engine in (e for e in scene.engines if not e.dead):
        if isinstance(engine, Contact):
            yield from contactMistakes(scene, engine)
        if isinstance(engine, RigidContact):
            yield from _overlap(scene, engine)
            yield from _rigidWalls(scene, engine)
    for engine, friction in ((e, f) for e in scene.engines for f in e._frictions()):
        if ANGLES[0] <= friction <= ANGLES[1]:
            yield (
                f"{type(engine).__name__}: friction = {friction:g} looks like an angle in degrees; give its "
                f"tangent, {np.tan(np.radians(friction)):.3g}, if it is one"
            )


def _water(scene):
    """Water that nothing lets out, and water that got its pressure without gravity."""
    water = next((e for e in scene.engines if isinstance(e, PoreWater) and not e.dead), None)
    wet = [b for b in scene.bodies if b.count and b._core.hasPores and (b.saturation > 0).any()]
    if water is None or not wet:
        return
    closed = sum((b.volume * (b.saturation > 0 if b in wet else 1)).sum() for b in scene.bodies)  # to the air
    ofGrid = np.prod(scene.upper - scene.lower) * scene._thicknessAt(0.5 * (scene.lower[0] + scene.upper[0]))
    isFull = closed > (1 - ROUNDOFF) * ofGrid
    if (
        not (water.heads or water.drained)
        and (water.sealed or isFull)
        and max(b.permeability.max() for b in wet) > 0
    ):
        yield (
            "PoreWater: no drained boundary: undrained for ever; leave the surface open (sealed=False), give "
            'a face water, e.g. drained="bottom", or say permeability=0'
        )
    speed = np.sqrt(water.bulkModulus / water.density)
    if speed > FASTEST:
        yield (
            f"PoreWater: waves in its water travel at {speed:.3g} m/s, and in water at 1480; bulkModulus = "
            f"{water.bulkModulus:g} is in kPa: give 2.2e6"
        )
    for body in wet:
        if (most := body.permeability.max()) > PERMEABLE:
            yield (
                f"PoreWater: '{body.name}' has a permeability of {most:.3g} m/s, more than gravel; in "
                f"m/s {most:.3g} m/d are {most / 86400:.3g}"
            )
        if scene.steps == 0 and water.excess(body).min() < -OVERDRAWN * water.hydrostatic(body).max():
            yield (
                f"PoreWater: '{body.name}' has less than the hydrostatic pressure of its table at the start; "
                "give gravity before scene.add"
            )


def _tied(scene):
    """Tied sides with other ground at one than at the other."""
    for engine in (e for e in scene.engines if e.label.startswith("tied ") and not e.dead):
        axis = "xyz".index(engine.axis)
        lines = [line if k != axis else line[[0, 1, -2, -1]] for k, line in enumerate(scene.lines)]
        solid = [b for b in scene.bodies if b.count]
        found = sum(np.histogramdd(b.position, lines, weights=b.mass)[0] for b in solid)
        first, last = (np.take(found, side, axis) for side in (0, 2)) if solid else (np.zeros(1),) * 2
        other = np.abs(first - last) > UNEQUAL * np.maximum(first, last)
        if other.any():
            yield (
                f"tie: the ground differs in {other.sum()} of the {(first + last > 0).sum()} cells at the "
                "tied sides, which move as one: give both the same profile, e.g. a level strip each"
            )


def _overlap(scene, contact):
    """Rigid bodies that stand in the soil."""
    found = [o for o in contact._core.overlaps(scene._core) if o[2] > OVERLAP * min(scene.cell)]
    if found:
        body, soil, depth = max(found, key=lambda o: o[2])
        others = {1: "", 2: ", and another one is in the soil"}.get(
            len(found), f", and {len(found) - 1} others are in the soil"
        )
        yield (
            f"RigidContact: rigid body {body} is {depth:.3g} m deep in '{scene.bodies[soil].name}'{others}; "
            "what overlaps at the start is thrown out, the faster the smaller the time step; start where the "
            "two only touch, or leave the place of the body empty: scene.add(..., exclude=contact)"
        )


def _rigidWalls(scene, contact):
    """Soil that rigid bodies press on with other weights than its stress has."""
    for body in (b for b in scene.bodies if contact._core.bodies and type(b.type).__name__ == "BSpline"):
        yield (
            f"RigidContact: '{body.name}' is of B-splines, and soil of B-splines loses more than half of its "
            "strength where rigid bodies squeeze it, for they press with other weights than the stress; make "
            "it UGIMP or APDI"
        )
    isBeside = any(b.implicit for b in scene.bodies) or any(isinstance(e, PoreWater) for e in scene.engines)
    if contact.normalLaw == "rigid" and isBeside:
        yield (
            "RigidContact: normalLaw = 'rigid' finds its impulses before pore water and implicit bodies act, "
            "and no test has it beside them; take 'penalty', or press with a mesh and a Contact"
        )


def stiffContacts(scene):
    """Yields a text for each body that a rigid one presses on so stiffly that points may gain energy; once
    the time step is known. Equation (4.11) of doc/theory/contact.md."""
    if not scene.dtCritical:  # nothing moves freely, or all bodies are implicit
        return
    share = scene.stepper.dt / scene.dtCritical
    for contact in (e for e in scene.engines if isinstance(e, RigidContact) and not e.dead):
        isGiven = contact.stiffness is not None and not np.isnan(contact.stiffness)
        isRigid = contact.normalLaw == "rigid"
        for body in scene.bodies if contact._core.bodies and not isGiven and not isRigid else ():
            perCell = getattr(body.type, "perCell", None)
            half = 0.5 / min(perCell) if perCell else 0.0  # of a box, in cells; a vertex has no size
            most = 4 * max(0.0, 1 - share**2) / (1 / (1 - half) + 4 * half)
            if contact.stiffnessFactor > most:
                yield (
                    f"RigidContact: stiffnessFactor = {contact.stiffnessFactor:g} is more than {most:.2g}, "
                    f"up to which contact with '{body.name}' is stable at {share:.2g} of the critical step; "
                    "lower stiffnessFactor or dt, else what touches may gain energy"
                )


def _isMoved(scene):
    """Whether anything else sets the bodies in motion: a velocity, a body force, a load, a stress."""
    isLoaded = any(isinstance(e, (*LOADS, RigidContact, Contact)) for e in scene.engines)
    return isLoaded or any(
        b.velocity.any() or b.stress.any() or ("bodyForce" in b.fieldNames and b.bodyForce.any())
        for b in scene.bodies
    )


def _leftOut(scene):
    """Loads and drives of its bodies that nobody has given to the scene."""
    inUse = {id(part) for part in (*scene.engines, *scene.constraints)}
    for part in (p for p in scene._loadsAndDrives if id(p) not in inUse):
        if isinstance(part, Drive):
            yield (
                f"Drive: '{part.name}' of '{part.part.body.name}' is not given to the GridSolver and moves "
                "nothing; give GridSolver(drive=...), or make it when it is needed"
            )
        else:
            yield (
                f"{type(part).__name__}: the load on '{part.body}' is not among the engines and does "
                "nothing; add it behind ParticleToGrid (USF: "
                f"DomainUpdater), with dead=True if it is for later"
            )


def _units(body, gravity):
    """A density that looks like a unit weight, a body that its own weight would crush, one stiffer than any
    solid."""
    density, (bulk, shear) = body.material.density, _present(body)
    if UNIT_WEIGHTS[0] <= density <= UNIT_WEIGHTS[1]:
        yield (
            f"body '{body.name}': density = {density:g} Mg/m3 looks like a unit weight in kN/m3; give "
            f"{density / 9.81:.3g} if it is one"
        )
    weight = density * np.linalg.norm(gravity) * np.ptp(body.corners()[..., -1]) if body.count else 0.0
    isCrushed = weight > bulk + 4 / 3 * shear
    # A scene in kg, m, s, Pa has faster waves, one without units no weight.
    if density > UNIT_WEIGHTS[1] and (isCrushed or weight and body.material.waveSpeed < SLOWEST):
        yield (
            f"body '{body.name}': density = {density:g} Mg/m3; did you mean {density / 1e3:g} (units are Mg, "
            "m, s, kPa)?"
        )
    elif isCrushed:
        yield (
            f"body '{body.name}': its own weight, {weight:.3g} kPa at the bottom, exceeds its "
            f"stiffness lambda + 2 mu = {bulk + 4 / 3 * shear:.3g} kPa; units are Mg/m3, m/s2 and kPa: is "
            "the density in kg/m3, or the stiffness in MPa?"
        )
    if body.material.waveSpeed > FASTEST:
        yield (
            f"body '{body.name}': compression waves travel at {body.material.waveSpeed:.3g} m/s, faster than "
            "in any solid; units are Mg/m3, m and kPa: is the stiffness in Pa?"
        )


def _present(body):
    """Largest bulk and shear modulus of a body as it stands, kPa."""
    scene = body.scene
    return scene._core.presentStiffness()[scene.bodies.index(body)]


def _strength(body):
    """An angle of friction or a cohesion that no soil has."""
    angle, cohesion = (largestOf(body, name) for name in ("frictionAngle", "cohesion"))
    if angle > STEEPEST:
        yield (
            f"body '{body.name}': frictionAngle = {angle:g} rad is {np.degrees(angle):.3g} degrees, more "
            "than soils have; for an angle in degrees give radians(...)"
        )
    if cohesion > HARDEST:
        yield (
            f"body '{body.name}': cohesion = {cohesion:g} kPa is that of hard rock; if it is in Pa, give "
            f"{cohesion / 1e3:g}"
        )


def _locking(body):
    """Particles that hardly change their volume, several in a cell, without F-bar, in a body that strains."""
    lame, mu = body.material.lameConstants
    if body.fbar or not lame >= 0.0 or not body.count or _isDriven(body):
        return
    cells = np.prod(body.scene.cellSizeAt(body.position), axis=1)
    if np.mean(body.volume / cells) > limits.LOCKING_VOLUME:
        return
    poisson = lame / (2 * (lame + mu))
    if poisson >= limits.LOCKING_POISSON * (1 - 1e-9):
        yield (
            f"body '{body.name}': its particles have no F-bar and Poisson's ratio {poisson:.4g}, so they "
            "lock: they are too stiff (a strip load settles 2 % too little at 0.45, 8 % at 0.49, 42 % at "
            "0.499), and mean stresses scatter; give fbar=True in scene.add"
        )


def _isDriven(body):
    """Whether all of a body has a prescribed motion."""
    drives = [c for c in body.scene.constraints if isinstance(c, Drive) and c.part.body is body]
    return any(drive.part.has().all() for drive in drives)


def _beyondYield(body):
    """A stress that the material cannot have: the first step changes it without any strain."""
    found = body._core.beyondYield(ROUNDOFF)
    count, worst, change = found["count"], found["worst"], found["change"]
    if not count:
        return
    up = body.scene.dim - 1
    vertical, horizontal = body.stress[worst, up, up], body.stress[worst, 0, 0]
    names = [variable[0] for variable in body.material._core.stateVariables()]
    state = {name: getattr(body, name)[worst] for name in names}
    allowed = _allowedK0(body.material, state, vertical, up) if vertical < 0 else None
    advice = (
        "give a stress inside the yield surface"
        if allowed is None
        else (
            f"where the vertical stress is {vertical:.3g} kPa it allows K0 from {allowed[0]:.4g} to "
            f"{allowed[1]:.4g}, given is {horizontal / vertical:.4g}"
        )
    )
    yield (
        f"body '{body.name}': {100 * count / body.count:.3g} % of its particles start with a stress outside "
        "the yield surface of "
        f"{type(body.material).__name__}, and the first step changes it by up to {change:.3g} kPa; {advice}"
    )


def _allowedK0(material, state, vertical, up):
    """Least and largest K0 that a material allows at a vertical stress, by bisection from K0 = 1; None if it
    does not allow that."""

    def isAllowed(K0):
        stress = vertical * np.diag([1.0 if k == up else K0 for k in range(3)])
        return np.abs(
            MaterialPoint(material, stress, state).gradient(np.zeros((3, 3)), 1.0) - stress
        ).max() <= ROUNDOFF * abs(vertical)

    if not isAllowed(1.0):
        return None
    ends = []
    for far in (0.0, 100.0):
        good, bad = 1.0, far
        for _ in range(0 if isAllowed(far) else 30):
            middle = 0.5 * (good + bad)
            good, bad = (middle, bad) if isAllowed(middle) else (good, middle)
        ends.append(far if isAllowed(far) else good)
    return ends
