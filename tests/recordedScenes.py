# SPDX-License-Identifier: GPL-2.0-or-later
"""Scenes with a Recorder, and readers of its files."""
# SPDX-License-Identifier: GPL-2.0-or-later

import h5py
import numpy as np
import yade_mpm as mpm
from setups import chain, soft
from yade_mpm import box

GRAVITY = {2: (0, -9.81), 3: (0, 0, -9.81)}


def engines(*more, dim=2):
    return [*chain(gravity=GRAVITY[dim], fixed=("bottom",)), *more]


def makeScene(dim=2, onDistortion="stop", perCell=2):
    """An elastic APDI block below a c-phi uGIMP block."""
    flat = (0, 0) if dim == 2 else (0, 0, 0)
    wide = (2, 1) if dim == 2 else (2, 1, 1)
    scene = mpm.Scene(flat, (2, 2) if dim == 2 else (2, 1, 2), 0.5)
    elastic = soft(2)
    soil = mpm.MohrCoulombDruckerPrager(
        density=1.5, lame=(1e3, 1e3), cohesion=5, frictionAngle=0.5, dilatancyAngle=0.1
    )
    scene.add("low", box(flat, wide), elastic, mpm.APDI(size=0.5, onDistortion=onDistortion))
    high = ((0.5, 1), (1.5, 1.5)) if dim == 2 else ((0.5, 0, 1), (1.5, 1, 1.5))
    scene.add("high", box(*high), soil, mpm.UGIMP(perCell=perCell))
    scene.dt = 1e-3
    return scene


def snapshot(scene):
    """What a frame should hold, straight from the bodies."""
    corners = [body.deformedCorners() for body in scene.bodies]
    return dict(
        time=scene.time,
        steps=scene.steps,
        corners=np.concatenate([np.pad(c, ((0, 0), (0, 0), (0, 3 - scene.dim))) for c in corners]),
        stress=np.concatenate([b.stress.reshape(-1, 9) for b in scene.bodies]),
        velocity=np.concatenate([np.pad(b.velocity, ((0, 0), (0, 3 - scene.dim))) for b in scene.bodies]),
        id=np.concatenate([b.id for b in scene.bodies]),
        body=np.concatenate([np.full(b.count, k) for k, b in enumerate(scene.bodies)]),
    )


def runAndWatch(scene, file, steps=30, every=10):
    """Runs with a recorder; returns what every frame should hold."""
    frames = [snapshot(scene)]
    watch = mpm.PyRunner(lambda s: frames.append(snapshot(s)), iterPeriod=every)
    scene.engines = engines(mpm.Recorder(file, iterPeriod=every), watch, dim=scene.dim)
    scene.run(steps=steps, progress=False)
    return frames


def readWithH5py(file):
    """List of dicts like `snapshot`, by the offsets of the format."""
    frames = []
    with h5py.File(file) as h5:
        root, steps = h5["VTKHDF"], h5["VTKHDF/Steps"]
        for k in range(steps.attrs["NSteps"]):
            part = steps["PartOffsets"][k]
            cells = root["NumberOfCells"][part]
            points = root["Points"][steps["PointOffsets"][k] :][: root["NumberOfPoints"][part]]
            ids = root["Connectivity"][steps["ConnectivityIdOffsets"][k] :][
                : root["NumberOfConnectivityIds"][part]
            ]
            offsets = root["Offsets"][steps["CellOffsets"][k] + part :][: cells + 1]
            frame = {
                name: root["CellData"][name][at[k] : at[k] + cells]
                for name, at in steps["CellDataOffsets"].items()
            }
            corners = np.array([points[ids[a:b]] for a, b in zip(offsets, offsets[1:])])
            frames.append(dict(frame, corners=corners, time=steps["Values"][k], steps=steps["step"][k]))
    return frames


def assertSameFrames(found, expected):
    assert len(found) == len(expected)
    for f, e in zip(found, expected):
        for name, value in e.items():
            assert np.array_equal(f[name], value, equal_nan=np.asarray(value).dtype.kind == "f"), name
