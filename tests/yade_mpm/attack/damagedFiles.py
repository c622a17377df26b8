# SPDX-License-Identifier: GPL-2.0-or-later
"""Damaged and hand-made checkpoints, meshes and results, given to their readers; the same for a seed.

    python tests/yade_mpm/attack/damagedFiles.py --count 2000

A file that is taken although its content was changed and its sum was not made again is silent nonsense.
"""

import contextlib
import functools
import io
import os
import random

import blows

MESHES = {  # name of a file -> how meshio writes it
    "a.msh": dict(file_format="gmsh22", binary=False),
    "b.msh": dict(file_format="gmsh22", binary=True),
    "c.msh": dict(file_format="gmsh", binary=False),
    "d.msh": dict(file_format="gmsh", binary=True),
    "e.vtk": dict(binary=True),
    "f.vtu": {},
    "g.inp": {},
    "h.med": {},
    "i.xdmf": dict(data_format="XML"),
    "j.bdf": {},
    "k.mesh": {},
}
STEPS = 2  # that a scene which was taken has to run


def elastic(mpm):
    return mpm.LinearElastic(density=1.0, lame=(100.0, 50.0))


@functools.cache
def checkpoint():
    """Content of a checkpoint with both kinds of domains, a contact and a history."""
    import yade_mpm as mpm

    scene = mpm.Scene((0, 0), (2, 2), 0.5, threads=1)
    near = scene.add("boxes", mpm.box((0, 0), (1, 0.5)), elastic(mpm), mpm.UGIMP(perCell=4, cut=True))
    scene.add("mesh", mpm.box((1, 0), (2, 1)), elastic(mpm), mpm.APDI(size=0.25, matched=near), group="b")
    contact = mpm.Contact(friction=0.3)
    engines = [mpm.ParticleToGrid(), mpm.GridSolver(), contact, mpm.GridToParticle(), mpm.DomainUpdater()]
    scene.engines = [*engines, mpm.History(iterPeriod=1)]
    scene.run(steps=3, progress=False)
    return contentOf(scene.save, "whole.h5")


@functools.cache
def results():
    """Content of a file of a Recorder, and of the journal that one leaves which is killed."""
    import yade_mpm as mpm

    scene = mpm.Scene((0, 0), (2, 2), 0.5, threads=1)
    scene.add("mesh", mpm.box((1, 0), (2, 1)), elastic(mpm), mpm.APDI(size=0.25))
    recorder = mpm.Recorder("whole.vtkhdf", iterPeriod=1)
    scene.engines = [*scene.engines, recorder, mpm.History(iterPeriod=1)]
    scene.run(steps=3, progress=False)
    return contentOf(lambda file: None, "whole.vtkhdf")


@functools.cache
def mesh(name):
    """Content of a mesh file of 4 x 4 quadrilaterals."""
    import meshio
    import numpy as np

    x, y = np.meshgrid(np.arange(5.0) / 2, np.arange(5.0) / 2)
    first = np.arange(4)[:, None] * 5 + np.arange(4)
    cells = np.stack([first, first + 1, first + 6, first + 5], axis=-1).reshape(-1, 4)
    points = np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], axis=1)
    return contentOf(
        lambda file: meshio.write(file, meshio.Mesh(points, [("quad", cells)]), **MESHES[name]), name
    )


def contentOf(write, file):
    write(file)
    with open(file, "rb") as f:
        return f.read()


def kept(rng, content):
    return content


def flipped(rng, content):
    content = bytearray(content)
    for _ in range(rng.choice([1, 1, 1, 2, 8, 64])):
        content[rng.randrange(len(content))] ^= 1 << rng.randrange(8)
    return bytes(content)


def cut(rng, content):
    return content[: rng.randrange(len(content))]


def overwritten(rng, content):
    at, count = rng.randrange(len(content)), rng.choice([1, 4, 8, 64, 512])
    with_ = rng.choice([b"\0" * count, b"\xff" * count, rng.randbytes(count)])
    return (content[:at] + with_ + content[at + count :])[: len(content)]


def moved(rng, content):
    """A piece of it is missing, or there twice."""
    at, count = rng.randrange(len(content)), rng.randrange(1, 300)
    piece = content[at : at + count]
    return content[:at] + rng.choice([b"", piece + piece]) + content[at + count :]


def wordsChanged(rng, content):
    """A number in a text is another one."""
    words = content.split(b" ")
    words[rng.randrange(len(words))] = rng.choice(
        [b"-1", b"0", b"99999999999", b"nan", b"1e999", b"", b"x", b"2147483648", b"18446744073709551615"]
    )
    return b" ".join(words)


DAMAGES = (flipped, cut, overwritten, moved, wordsChanged)


def tablesChanged(rng, content):
    """Numbers of an array are others; the sum is made again."""
    import h5py
    import numpy as np
    from yade_mpm.io.checkpoint import SEAL, sealOf

    image = io.BytesIO(content)
    with h5py.File(image, "r+") as h5:
        names = []
        h5["bodies"].visititems(lambda name, x: names.append(name) if isinstance(x, h5py.Dataset) else None)
        for _ in range(rng.choice([1, 1, 3])):
            one = h5["bodies"][rng.choice(names)]
            if not one.size:
                continue
            at = np.unravel_index(rng.randrange(one.size), one.shape)
            floats = [float("nan"), float("inf"), 0.0, -1.0, 1e300, 1e-300, 7.0]
            whole = [-1, 0, 1, 7, 2**31 - 1, -(2**31), rng.randrange(-(2**31), 2**31)]
            one[at] = rng.choice(whole if one.dtype.kind == "i" else floats)
    changed = image.getvalue()[SEAL:]
    return sealOf(changed) + changed


def stepsOf(scene):
    """What was taken can be stepped, or the run is refused, or fails in words."""
    scene.threads = 1
    scene.run(steps=STEPS, progress=False)


def attackCheckpoint(rng):
    import yade_mpm as mpm

    content = checkpoint()
    damage = rng.choice((*DAMAGES, tablesChanged, tablesChanged))
    damaged = damage(rng, content)
    with open("damaged.h5", "wb") as f:
        f.write(damaged)
    label = f"checkpoint {damage.__name__}"
    scene = mpm.load("damaged.h5")
    if damage in DAMAGES and damaged != content:
        return label, "silent", "a damaged file was taken"
    stepsOf(scene)
    return label, "accepted", ""


def attackMesh(rng):
    import yade_mpm as mpm

    name, damage = rng.choice(list(MESHES)), rng.choice(DAMAGES)
    damaged = damage(rng, mesh(name))
    with open(name, "wb") as f:
        f.write(damaged)
    scene = mpm.Scene((-4, -4), (6, 6), 1.0)
    scene.add("mesh", name, elastic(mpm), mpm.APDI())
    stepsOf(scene)
    return f"mesh {name} {damage.__name__}", "accepted", ""


def journal(rng):
    """Content of a journal, with a right sum, that was made by hand."""
    import numpy as np
    from yade_mpm.io import pagedFile

    pages = np.array([rng.choice([0, 1, 2, 2**40, -1, 2**62]) for _ in range(2)], np.int64)
    size = rng.choice([0, 10**4, 10**15, -1, -(2**63)])
    return pagedFile._journal(pages, size, rng.randbytes(rng.choice([0, 1, 2]) * pagedFile.PAGE))


def attackJournal(rng):
    """A journal made by hand beside a whole file of results, which are read. (Bytes of such a file that are
    others reach HDF5, which does not survive all of them: SECURITY.md.)"""
    import yade_mpm as mpm

    with open("results.vtkhdf", "wb") as f:
        f.write(results())
    damage = rng.choice((flipped, cut, kept))
    with open("results.vtkhdf.journal", "wb") as f:
        f.write(damage(rng, journal(rng)))
    with contextlib.suppress(ValueError):
        mpm.Recorder.recover("results.vtkhdf")
        return f"journal {damage.__name__}", "accepted", ""
    file = mpm.read("results.vtkhdf")
    frames = [dict(frame) for frame in file]
    assert len(frames) == 4 and [file.units, file.history(), file.historyUnits()]
    return f"journal {damage.__name__}", "accepted", ""


KINDS = (attackCheckpoint, attackCheckpoint, attackMesh, attackJournal)


def attack(number, seed, kinds):
    """One case: (label, what came of it, text)."""
    rng = random.Random(f"{seed} {number}")
    kind = rng.choice(kinds)
    try:
        return kind(rng)
    except (Exception, SystemExit) as error:
        tokens = "checkpoint,mesh,read,recover,body ',Scene,History,dt =,particle"
        return kind.__name__, *blows.answer(error, [*tokens.split(","), *os.listdir()])


if __name__ == "__main__":
    blows.main(__file__, __doc__, blows.ofKinds(attack, KINDS))
