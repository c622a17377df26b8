# SPDX-License-Identifier: GPL-2.0-or-later
"""scripts/propped_wall.py beside calculations by hand: a smooth wall on free earth, Rankine's pressures, and
the settlement behind walls in sand.

Clough & O'Rourke 1990: at most 0.3 % of the depth of the dig at the wall, in a straight line to none at twice
that depth. Prints rows of a table and draws a picture.

    scripts/run propped_wall_by_hand --cell 0.5
"""

import os

import matplotlib.pyplot as plt
import numpy as np
import propped_wall as wall
from yade_mpm import app, plot

DIG, PROP_AT, KA, KP = 4.0, 1.0, 1 / 3, 3.0  # m; -
DEPTHS = np.arange(0.5, wall.LENGTH)  # m, middles of strips of a metre
AWAY = np.arange(0, 8, 2.0)  # m behind the wall
MOST = 0.003  # settlement at the wall over the depth of the dig


def rankine(depth):
    """Pressure behind the wall and in front of it, kPa."""
    return KA * wall.GAMMA * depth, KP * wall.GAMMA * np.maximum(depth - DIG, 0)


def moments(depth):
    """Of a wall on free earth, kN m/m, with the pressure in front of it that moments about the prop need."""
    prop = wall.byHand(DIG, KA, PROP_AT)[0]
    share = (KA * wall.GAMMA * wall.LENGTH**2 / 2 - prop) / (KP * wall.GAMMA * (wall.LENGTH - DIG) ** 2 / 2)
    front = share * KP * wall.GAMMA * np.maximum(depth - DIG, 0) ** 3 / 6
    return prop * np.maximum(depth - PROP_AT, 0) - KA * wall.GAMMA * depth**3 / 6 + front


def settlement(away):
    """At most, mm."""
    return 1e3 * MOST * DIG * np.maximum(1 - away / (2 * DIG), 0)


def pressureAt(face, depth):
    """Mean over a metre, kPa."""
    near = np.abs(wall.TOP - depth - face.centre[:, 1]) < 0.5
    return face.pressure[near] @ face.area[near] / face.area[near].sum()


def settled(soil, away):
    """Of the surface behind the wall, mm."""
    x, y = soil.reference.T
    row = np.flatnonzero((y > y.max() - 1e-6) & (x < wall.LEFT))
    row = row[np.argsort(x[row])]
    return -1e3 * np.interp(wall.LEFT - away, x[row], soil.displacement[row, 1])


def rows(scene, forces, pressure):
    """What is compared: name -> found, by hand."""
    worst = np.abs(forces.M).argmax()
    fine = np.linspace(0, wall.LENGTH, 1000)
    yield "prop (kN/m)", -scene.stages[-1]["values"]["prop.force"], wall.byHand()[0]
    yield "largest moment (kN m/m)", np.abs(forces.M[worst]), wall.byHand()[1]
    yield "its depth (m)", wall.TOP - forces.s[worst], fine[moments(fine).argmax()]
    for side, name, hand in zip(("left", "right"), ("behind", "in front"), rankine(DEPTHS)):
        face = pressure.side(side)
        for depth, byHand in zip(DEPTHS, hand):
            if byHand > 0:
                yield f"pressure {name}, {depth} m deep (kPa)", pressureAt(face, depth), byHand
    for away in AWAY:
        yield f"settlement {away} m behind the wall (mm)", settled(scene["soil"], away), settlement(away)


def draw(scene, forces, pressure, file):
    """Moments, pressures and the settlement with what is calculated by hand, dashed."""
    figure, (left, middle, right) = plt.subplots(1, 3, figsize=(9.6, 3.6), layout="constrained")
    depth, soil = np.linspace(0, wall.LENGTH, 200), scene["soil"]
    left.plot(-forces.M, wall.TOP - forces.s, "C0")
    left.plot(moments(depth), depth, "C0--")
    for side, hand, colour, name in zip(
        ("left", "right"), rankine(depth), ("C0", "C1"), ("behind", "in front")
    ):
        face = pressure.side(side)
        middle.plot(face.pressure, wall.TOP - face.centre[:, 1], colour, label=name)
        middle.plot(hand, depth, colour + "--")
    away = np.linspace(0, wall.LEFT, 100)
    right.plot(away, settled(soil, away), "C0")
    right.plot(away, settlement(away), "C0--")
    for axes, label in (left, "moment (kN m/m)"), (middle, "pressure (kPa)"):
        axes.set(xlabel=label, ylabel="depth (m)", ylim=(wall.LENGTH, 0))
    middle.set_xlim(0, 80)
    middle.legend(frameon=False)
    right.set(xlabel="behind the wall (m)", ylabel="settlement (mm)")
    right.invert_yaxis()
    plot.save(figure, file)


def main():
    a = wall.PARAMETERS.parse()
    scene, found = wall.main()
    for name, computed, byHand in rows(scene, *found):
        print(f"| {name} | {computed:.1f} | {byHand:.1f} |")
    draw(scene, *found, os.path.join(a.out, "propped_wall_by_hand.png"))


if __name__ == "__main__":
    app.run(main)
