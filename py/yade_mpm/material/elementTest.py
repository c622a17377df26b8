# SPDX-License-Identifier: GPL-2.0-or-later
"""Laboratory tests on one point of a material: triaxial, oedometer and simple shear.

    curve = mpm.elementTest.triaxial(clay, pressure=100, strain=0.2, drained=False)
    curve.q.max(), curve.plot()

They run the code of a scene (MaterialPoint). Pressures and strains are positive in compression here, as in a
laboratory.
"""

import numpy as np
import scipy.optimize

from ..base.kinds import NOT_NEGATIVE
from ..base.wording import shown
from ..geometry.numbers import floats, isCount
from .materials import MaterialPoint

HELD = 1e-9  # relative to the largest stress: what a stress that is held may miss


class Curve:
    """What a test measured, one entry per step, the first at its start.

    strain : axial or shear strain, -. volume : volumetric strain, -. p : mean pressure, kPa. q : axial less
    radial pressure, kPa; in shear, the shear stress. stress : (N, 3, 3), kPa, tension positive. point : the
    MaterialPoint at the end. name : of the test.
    """

    def __init__(self, name, point):
        self.name, self.point, self._rows = name, point, []

    def note(self, strain, q):
        volume = -np.log(np.linalg.det(self.point.deformationGradient))
        self._rows.append((strain, volume, -np.trace(self.point.stress) / 3, q, self.point.stress))

    def _column(self, k):
        return np.array([row[k] for row in self._rows])

    strain = property(lambda self: self._column(0), doc="Axial or shear strain, -.")
    volume = property(lambda self: self._column(1), doc="Volumetric strain, -, compression positive.")
    p = property(lambda self: self._column(2), doc="Mean pressure, kPa.")
    q = property(lambda self: self._column(3), doc="Axial less radial pressure, or shear stress, kPa.")
    stress = property(lambda self: self._column(4), doc="Cauchy stress (N, 3, 3), kPa, tension positive.")

    def plot(self, axes=None, **style):
        """Draws q over the strain, and q over p, into two axes of matplotlib (new ones by default); returns
        them."""
        if axes is None:
            import matplotlib.pyplot as plt

            _, axes = plt.subplots(1, 2, figsize=(8, 3), layout="constrained")
        axes[0].plot(self.strain, self.q, **style)
        axes[1].plot(self.p, self.q, **style)
        axes[0].set(xlabel="strain (-)", ylabel="q (kPa)", title=self.name)
        axes[1].set(xlabel="p (kPa)", ylabel="q (kPa)")
        return axes

    def __repr__(self):
        return f"<Curve of {self.name}: {len(self._rows)} points, q up to {np.abs(self.q).max():.4g} kPa>"


def triaxial(material, pressure, strain, drained=True, steps=400, state=None):
    """A cylinder under a cell pressure, pressed along its axis.

    Parameters
    ----------
    material : Material.
    pressure : cell pressure, kPa.
    strain : axial strain at the end, -, compression positive; negative: extension. A list is a path from one
        to the next, for cycles.
    drained : bool; the radial stress stays. False: the volume stays (undrained, effective stress); default
        True.
    steps : int, of each part of the path; default 400.
    state : dict of state variables that differ from their initial value.

    Returns a Curve. Raises ValueError for a material that cannot follow, and for wrong values.
    """
    point = _point("triaxial", material, pressure, state)
    curve = Curve(f"{'drained' if drained else 'undrained'} triaxial test", point)

    def take(step):
        if drained:
            _hold(point, np.diag([0.0, 0.0, -step]), [(0, 0), (1, 1)], [-pressure, -pressure])
        else:
            point.strain(np.diag([0.5 * step, 0.5 * step, -step]))

    return _follow(curve, strain, steps, take, lambda s: s[0, 0] - s[2, 2])


def oedometer(material, strain, pressure=1.0, steps=400, state=None):
    """A sample in a ring, compressed along its axis: no lateral strain. Parameters as `triaxial`; pressure :
    isotropic pressure at the start, kPa."""
    point = _point("oedometer", material, pressure, state)
    curve = Curve("oedometer test", point)
    return _follow(
        curve,
        strain,
        steps,
        lambda step: point.strain(np.diag([0.0, 0.0, -step])),
        lambda s: s[0, 0] - s[2, 2],
    )


def simpleShear(material, pressure, strain, drained=True, steps=400, state=None):
    """A layer sheared at no lateral strain; the pressure on it stays (drained), or its volume. strain : shear
    strain. Parameters as `triaxial`."""
    point = _point("simpleShear", material, pressure, state)
    curve = Curve(f"{'drained' if drained else 'undrained'} simple shear", point)

    def take(step):
        shear = np.zeros((3, 3))
        shear[0, 2] = step
        if not drained:
            point.gradient(shear, 1.0)
            return
        _hold(point, shear, [(2, 2)], [-pressure])

    return _follow(curve, strain, steps, take, lambda s: s[0, 2])


def _point(test, material, pressure, state):
    NOT_NEGATIVE.check(test, "kPa", pressure=pressure)
    return MaterialPoint(material, -float(pressure) * np.eye(3), state)


def _follow(curve, strain, steps, take, measure):
    try:
        path, at = np.atleast_1d(floats(strain)), 0.0
    except (TypeError, ValueError):
        path = np.zeros(0)
    if not (len(path) and np.isfinite(path).all() and isCount(steps)):
        raise ValueError(
            f"{curve.name}: strain = {shown(strain)}, steps = {shown(steps)}; give numbers and a whole number"
        )
    curve.note(at, measure(curve.point.stress))
    for end in path:
        step = (end - at) / steps
        for _ in range(steps):
            take(step)
            at += step
            curve.note(at, measure(curve.point.stress))
        at = end
    return curve


def _hold(point, gradient, components, stress):
    """Applies an increment whose normal strains in some components are such that their stress is as given."""
    unknown = [component[0] for component in components]
    wanted, scale = np.array(stress), np.abs(gradient).max()
    size = max(np.abs(point.stress).max(), np.abs(wanted).max(), 1e-3)

    def increment(parts):
        all = gradient.copy()
        all[unknown, unknown] = scale * parts
        return all

    def apply(its, parts):
        """Without rotation as a logarithmic strain, so that strains add up."""
        change = increment(parts)
        return its.strain(change) if np.array_equal(change, change.T) else its.gradient(change, 1.0)

    def missed(parts):
        now = apply(point.copy(), parts)
        return (np.array([now[c] for c in components]) - wanted) / size

    found = scipy.optimize.root(missed, np.zeros(len(unknown)), tol=1e-12)
    if np.abs(missed(found.x)).max() > HELD:
        raise ValueError(
            f"element test: {type(point.material).__name__} does not reach a stress of {wanted.tolist()} kPa "
            f"(it misses {size * np.abs(missed(found.x)).max():.3g} kPa); take more steps or another pressure"
        )
    apply(point, found.x)
