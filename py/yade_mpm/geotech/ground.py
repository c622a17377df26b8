# SPDX-License-Identifier: GPL-2.0-or-later
"""Ground of one material whose particle types are chosen on the command line."""

import numpy as np

from ..base.kinds import POSITIVE, REGION, SCENE, TEXT, takes
from ..geometry.regions import box
from ..particle.types import APDI, UGIMP

TYPES = ("hybrid", "ugimp", "apdi")


@takes(scene=SCENE, name=TEXT, region=REGION, types=TEXT)
def addGround(scene, name, region, zone, material, types, splitAt=None, onDistortion="stop", **more):
    """Adds ground to a scene: of uGIMP, of APDI, or uGIMP in a zone and APDI elsewhere.

    name : of the body; of the hybrid's "near NAME" and "far NAME". region, zone : all of the ground, and the
    part where it
    deforms most. types : one of TYPES. splitAt, onDistortion : as of `UGIMP` and `APDI`. more : for
    `Scene.add`.

    Boxes of uGIMP are half a cell wide. Domains of APDI are, too, where there is nothing else; beside a zone
    of uGIMP they have the size of a cell, and a ring of them is matched to the boxes.
    """
    cell = float(min(scene.cell))
    boxes = UGIMP(perCell=2, splitAt=splitAt)
    if types == "ugimp":
        scene.add(name, region, material, boxes, **more)
    elif types == "apdi":
        scene.add(name, region, material, APDI(size=cell / 2, onDistortion=onDistortion), **more)
    else:
        near = scene.add(f"near {name}", zone, material, boxes, **more)
        mesh = APDI(size=cell, matched=near, onDistortion=onDistortion)
        scene.add(f"far {name}", region - zone, material, mesh, **more)


@takes(scene=SCENE, strain=POSITIVE)
def flowRegion(scene, strain=0.01):
    """Where the soil of a scene has flowed, for `flow=` of a finer one.

        coarse.run(until=40)
        soil = fine.add("soil", ground, sand, flow=mpm.geotech.flowRegion(coarse))

    Parameters
    ----------
    strain : plastic shear strain from which on soil flows, -; default 0.01, from which on a run warns of a
        mesh.

    Returns a box with all places where such soil is and was at the start, out to the next lines of nodes of
    the scene and a cell further. Raises ValueError where no soil has flowed.
    """
    places = []
    for body in scene.bodies:
        if body.count and "plasticShearStrain" in body.fieldNames:
            flows = body.plasticShearStrain > strain
            places += [body.position[flows], body.reference[flows]]
    places = np.concatenate(places) if places else np.zeros((0, scene.dim))
    if not len(places):
        raise ValueError(
            f"flowRegion: no soil of the scene has a plastic shear strain above {strain:g}; run it further"
        )
    lower, upper = [], []
    for x, line in zip(places.T, scene.lines):
        first = np.searchsorted(line, x.min(), "right") - 2
        last = np.searchsorted(line, x.max(), "left") + 1
        lower.append(float(line[max(first, 0)]))
        upper.append(float(line[min(last, len(line) - 1)]))
    return box(lower, upper)
