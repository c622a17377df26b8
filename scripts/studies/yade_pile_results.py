# SPDX-License-Identifier: GPL-2.0-or-later
"""What is measured of scripts/yade_pile.py, its files, and one table of all runs of yade-batch."""

import csv
import glob
import json
import os

import numpy as np
from sheet_pile import GRAVITY
from yade import O
from yade_mpm import geotech, plot
from yade_mpm.io import files
from yade_mpm.yade.picture import outlines
from yade_pile_options import BATCH

HAMMER_PERIOD = 2.0  # s


class Gauge:
    """Force of the soil on the pile, mean since it was last read, and where the pile is."""

    def __init__(self, contact, number):
        self.contact, self.force, self.samples, self.overlap = contact, 0.0, 0, 0.0
        self.start = O.bodies[number].state.pos[1]
        self.columns = {
            "pile.depth": lambda scene: self.start - contact.positions[0, 1],
            "pile.vy": lambda scene: contact.velocities[0, 1],
            "pile.fy": self.mean,
        }

    def sample(self):
        self.force, self.samples = self.force + self.contact.forces[0, 1], self.samples + 1
        self.overlap = max(self.overlap, self.contact.largestPenetration)

    def mean(self, scene):
        mean = self.force / self.samples
        self.force, self.samples = 0.0, 0
        return mean


def report(a, out, number, scene, history, gauge, wall):
    """Files of a run, and what its picture needs."""
    depth, raw = history["pile.depth"], history["pile.fy"]
    curves = {
        "time": history["time"],
        "depth": depth,
        "raw": raw,
        "base": history["bottom.fy"] - weight(scene),
    }
    if a.drive == "velocity":
        curves["smooth"] = geotech.movingAverage(depth, raw, a.cell)
        curves["base"] = geotech.movingAverage(depth, curves["base"], a.cell)
    files.saveTable(os.path.join(out, "resistance.csv"), curves)
    state = O.bodies[number].state
    summary = {
        "id": O.tags["id"],
        "description": O.tags["description"] if "description" in set(O.tags.keys()) else "",
        "arguments": vars(a),
        "steps": scene.steps,
        "dt": scene.dt,
        "dtCritical": scene.dtCritical,
        "wallSeconds": wall,
        "threads": scene.threads,
        "particles": scene.particleCount,
        "largestOverlap": gauge.overlap,
        "kineticRatio": float(np.nanmax(history["kineticRatio"][depth > a.cell], initial=0)),
        "pileMass": state.mass,
        "pileVelocity": state.vel[1],
        "penetration": gauge.start - state.pos[1],
    }
    if a.drive == "velocity":
        summary["resistance"] = geotech.atSteps(depth, curves["smooth"])
        summary["resistanceAtBase"] = geotech.atSteps(depth, curves["base"])
    else:
        ends = HAMMER_PERIOD * np.arange(1, a.blows + 2)
        summary["afterBlow"] = {
            f"{n}": float(d) for n, d in enumerate(np.interp(ends, curves["time"], depth))
        }
    files.saveJson(os.path.join(out, "summary.json"), summary)
    return {
        **curves,
        "summary": summary,
        "scene": scene,
        "soil": plot.Snapshot(scene, "plasticShearStrain"),
        "pile": outlines(),
    }


def weight(scene):
    return sum(b.mass.sum() for b in scene.bodies) * GRAVITY


def print_(summary):
    given = summary.get("resistance") or summary["afterBlow"]
    what = "resistance in kN/m at depth in m" if "resistance" in summary else "penetration in m after blow"
    print(
        f"{summary['steps']} steps in {summary['wallSeconds']:.1f} s; {what}: "
        + ", ".join(f"{k}: {v:.4g}" for k, v in given.items())
    )


def merge(folder=BATCH, file=BATCH + ".csv"):
    """One CSV of all runs of yade-batch: a row each, with what was given and what came out."""
    rows = []
    for name in sorted(glob.glob(os.path.join(folder, "*", "summary.json"))):
        with open(name) as summary:
            s = json.load(summary)
        given = {k: v for k, v in s["arguments"].items() if k not in ("out", "compare", "merge", "smoke")}
        found = {f"resistance at {k} m": v for k, v in s.get("resistance", {}).items()}
        found.update({f"depth after blow {k}": v for k, v in s.get("afterBlow", {}).items()})
        rows.append(
            {
                "id": s["id"],
                "description": s["description"],
                **given,
                "steps": s["steps"],
                "wallSeconds": s["wallSeconds"],
                **found,
            }
        )
    if not rows:
        raise SystemExit(f"yade_pile: there is no run in {folder}; run yade-batch first")
    columns = list(dict.fromkeys(name for row in rows for name in row))
    with files.replacing(file) as part, open(part, "w", newline="") as out:
        writer = csv.DictWriter(out, columns)
        writer.writeheader()
        writer.writerows(rows)
    print(f"{len(rows)} runs in {file}")
