# SPDX-License-Identifier: GPL-2.0-or-later
"""What is measured of scripts/yade_boulders.py: momentum, energy, craters."""

import numpy as np
from yade import O
from yade_boulders_pictures import groundOf
from yade_mpm import diagnostics

GRAVITY = 9.81  # m/s2
AT_REST = 0.2  # m/s: they rock in their craters for long


class Balance:
    """Momentum and energy of soil and boulders together; `step` after every step, `row` now and then."""

    def __init__(self, scene, contact, ids):
        self.scene, self.contact, self.ids, self.rows = scene, contact, ids, []
        self.states = [O.bodies[i].state for i in ids]
        self.masses = np.array([s.mass for s in self.states])
        self.mass = self.masses.sum() + diagnostics.mass(scene)
        self.bottom = next(c for c in scene.constraints if c.name == "bottom")
        self.heights = self._vectors("pos")[:, 2]
        self.impulse, self.forces, self.steps = 0.0, 0.0, 0
        self.began = O.time

    def _vectors(self, name):
        return np.array([tuple(getattr(s, name)) for s in self.states])

    def step(self):
        """Adds up what gravity and the base give, and the force of the soil on the boulders."""
        self.impulse += (self.bottom.reaction[2] - self.mass * GRAVITY) * O.dt
        self.forces += self.contact.forces[:, 2].sum()
        self.steps += 1

    def row(self):
        """Time, s; energies, kJ; vertical momentum and what is missing in it, Mg m/s; mean force of the
        soil on the boulders."""
        v, z = self._vectors("vel"), self._vectors("pos")[:, 2]
        momentum = self.masses @ v[:, 2] + diagnostics.momentum(self.scene)[2]
        self.rows.append(
            {
                "time": O.time,
                "bouldersKinetic": float(0.5 * self.masses @ (v**2).sum(axis=1)),
                "bouldersPotential": float(GRAVITY * self.masses @ (z - self.heights)),
                "soilKinetic": diagnostics.kineticEnergy(self.scene),
                "soilInternalWork": diagnostics.internalWork(self.scene),
                "workOnSoil": float(self.scene._core.energies["loads"]),
                "frictionWork": float(self.contact.frictionWork),
                "soilEnergyError": diagnostics.energyError(self.scene),
                "momentum": float(momentum),
                "momentumError": float(momentum - self.impulse),
                "force": self.forces / max(1, self.steps),
                "fastest": float(np.linalg.norm(v, axis=1).max()),
            }
        )
        self.forces, self.steps = 0.0, 0
        return self.rows[-1]


def summary(a, scene, balance, bodies, centres, radii, seconds):
    """What comes out, as plain numbers."""
    rows, soil = balance.rows, scene["soil"]
    ground = groundOf(scene, a)[0] - a.depth
    penetration = a.depth - (centres[:, 2] - radii)
    late = [r["force"] for r in rows if r["time"] > a.until - 0.5]
    return {
        "arguments": vars(a),
        "particles": soil.count,
        "steps": scene.steps,
        "wallSeconds": seconds,
        "dt": O.dt,
        "microseconds": {
            "step": 1e6 * seconds / scene.steps,
            **{  # wall time of a step, and its parts
                type(e).__name__: 1e6 * e.seconds / scene.steps for e in scene.engines
            },
        },
        "seen": bodies.seen / scene.steps,
        "weight": float(GRAVITY * balance.masses.sum()),
        "meanForceAtEnd": float(np.mean(late)),
        "fastestAtEnd": rows[-1]["fastest"],
        "moving": int(sum(np.linalg.norm(s.vel) > AT_REST for s in balance.states)),
        "onSoil": int(np.sum(np.abs(np.array(balance.contact.forces)).sum(axis=1) > 0)),
        "penetrationMean": float(penetration.mean()),
        "penetrationLargest": float(penetration.max()),
        "lowestBottom": float((centres[:, 2] - radii).min()),
        "craterDepth": float(-ground.min()),
        "rimHeight": float(ground.max()),
        "craterVolume": float(-ground[ground < 0].sum() * a.cell**2),
        "largestOverlap": float(balance.contact.largestPenetration),
        "fallingEnergy": -rows[-1]["bouldersPotential"],
        "frictionWork": rows[-1]["frictionWork"],
        "soilEnergyError": rows[-1]["soilEnergyError"],
        "workOnSoil": rows[-1]["workOnSoil"],
        "momentumExchanged": float(balance.masses.sum() * GRAVITY * rows[-1]["time"]),
        "momentumError": max(abs(r["momentumError"]) for r in rows),
    }
