# SPDX-License-Identifier: GPL-2.0-or-later
"""Ground of one material whose particle types are chosen on the command line."""

from ..base.kinds import REGION, SCENE, TEXT, takes
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
