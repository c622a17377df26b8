# SPDX-License-Identifier: GPL-2.0-or-later
"""The results are the same bits for any number of threads."""

import sys

import pytest
import yade_mpm as mpm
from processes import runPython
from setups import chain, softSoil
from yade_mpm import box
from yade_mpm.scene import loop, pace

THREADS = (1, 2, 3, 8, 16)


def hybrid(scheme="MUSL"):
    """Two blocks of uGIMP soil that collapse onto a matched mesh with hanging vertices; one of them flies
    off."""
    scene = mpm.Scene((0, 0), (8, 8), 0.25, scheme=scheme)
    soil = softSoil(cohesion=1.0)
    near = scene.add("near", box((2, 2), (6, 5)), soil, mpm.UGIMP(perCell=3), fbar=True)
    scene.add("floor", box((0, 0), (8, 2)), soil, mpm.APDI(size=0.25, matched=near), fbar=True)
    flying = scene.add(
        "flying", box((3, 5), (5, 6)), mpm.NeoHookean(density=1.0, lame=(2e3, 1e3)), mpm.UGIMP(perCell=3)
    )
    flying.velocity, near.velocity = (0.0, 6.0), (1.0, -1.0)
    scene.engines = chain(
        gravity=(0, -9.81),
        damping=0.05,
        roller=("left", "right"),
        fixed="bottom",
        drive=mpm.Drive(near.below(2.5), velocity=(0.5, None)),
    )
    return scene


def shaken(scheme="MUSL"):
    """Blocks of uGIMP soil above an elastic mesh; `take` shakes the box so that they fly across the grid and
    back."""
    scene = mpm.Scene((0, 0), (8, 8), 0.25, scheme=scheme)
    rubber = mpm.NeoHookean(density=1.0, lame=(4e3, 2e3))
    soil = softSoil(cohesion=5.0)
    first = scene.add("flying", box((1, 3), (2, 4)), soil, mpm.UGIMP(perCell=2))
    second = scene.add("other", box((5, 4), (6.5, 5)), soil, mpm.UGIMP(perCell=2))
    scene.add("floor", box((0, 0), (8, 1.5)), rubber, mpm.APDI(size=0.25, matched=first))
    first.velocity, second.velocity = (3.0, -2.0), (-2.0, 1.0)
    scene.engines = chain(gravity=(0, -9.81), roller=("left", "right", "top"), fixed="bottom")
    return scene


def solid(scheme="MUSL"):
    """The same in 3D, smaller: the mesh keeps its shape functions there."""
    scene = mpm.Scene((0, 0, 0), (3, 3, 6), 0.5, scheme=scheme)
    soil = softSoil(cohesion=1.0)
    scene.add("floor", box((0, 0, 0), (3, 3, 2)), soil, mpm.APDI(size=0.25), fbar=True)
    block = scene.add("block", box((0.5, 0.5, 3), (2.5, 2.5, 4.5)), soil, mpm.UGIMP(perCell=2))
    block.velocity = (0.5, 0.5, -6.0)
    scene.engines = chain(gravity=(0, 0, -9.81), fixed=("left", "right", "front", "back", "bottom"))
    return scene


def take(scene, steps):
    """Runs; gravity turns round every 250 steps. Returns how often somebody was found in another order."""
    solver, sorts = next(e for e in scene.engines if isinstance(e, mpm.GridSolver)), 0
    for done in range(0, steps, 250):
        before = orders(scene)
        if isinstance(scene["floor"].material, mpm.NeoHookean):  # the shaken box
            solver.gravity = ((-1) ** (done // 250) * 4.0, 5.0 if done // 500 % 2 else -5.0)
        scene.run(steps=min(250, steps - done), progress=False)
        sorts += orders(scene) != before
    return sorts


def digest(scene):
    import hashlib

    import numpy as np

    text = hashlib.sha256(
        repr([scene.dt, scene._core.energies, [c.work for c in scene.constraints]]).encode()
    )
    for body in scene.bodies:
        for field in body.fields():
            text.update(np.ascontiguousarray(getattr(body, field["name"])).tobytes())
        if body.cells is not None:
            text.update(np.ascontiguousarray(body.vertices).tobytes())
    return text.hexdigest()


def digests(name, scheme, steps):
    """Runs a scene with THREADS, and as a control with 1 thread and one velocity off by its last bit."""
    found = []
    for threads, isControl in [(n, False) for n in THREADS] + [(1, True)]:
        scene = globals()[name](scheme)
        scene.threads = threads
        if isControl:
            scene["block" if name == "solid" else "flying"].velocity[0, -1] *= 1 + 2e-16
        assert take(scene, steps) > steps // 1000, "the particles were not re-sorted"
        found.append(digest(scene))
    return found


def orders(scene):
    return [(b.id.tolist(), b._core.tables()["blockStart"]) for b in scene.bodies if b.cells is None]


@pytest.mark.parametrize(
    "name, scheme, steps",
    [
        ("hybrid", "MUSL", 200),
        ("hybrid", "USF", 40),
        ("solid", "USL", 40),
        ("solid", "MUSL", 60),
        ("shaken", "MUSL", 1000),
        pytest.param("shaken", "MUSL", 10000, marks=pytest.mark.slow),
    ],
)
def test_threads_do_not_change_a_bit(name, scheme, steps):
    # In a process of its own, where waiting threads sleep: the machine may have fewer cores than threads.
    out = runPython(__file__, name, scheme, steps, timeout=1800, OMP_WAIT_POLICY="passive")
    assert out.returncode == 0, out.stderr
    *runs, control = out.stdout.split()
    assert len(runs) == len(THREADS) and set(runs) == {runs[0]}
    assert control != runs[0], "the control: one bit at the start is seen at the end"


def test_callbacks_may_change_the_number_of_threads_and_run_another_scene():
    """Threads stay together from step to step; whoever asks for others gets others."""
    plain, plainOther = hybrid(), solid()
    plain.threads = plainOther.threads = 1
    plain.run(steps=40, progress=False), plainOther.run(steps=8, progress=False)
    scene, other = hybrid(), solid()
    numbers, seen = iter([1, 2, 2, 3, 1, 1, 3, 2]), []

    def change(s):
        other.threads = s.threads  # the same threads, within the other scene's step,
        other.run(steps=1, progress=False)
        s.threads = next(numbers)  # or others from the next step on
        seen.append(s.threads)

    scene.threads = 2
    scene.engines.append(mpm.PyRunner(change, iterPeriod=5))
    scene.run(steps=40, progress=False)
    assert len(seen) == 8 and digest(other) == digest(plainOther)
    assert digest(scene) == digest(plain)
    other.threads = 2
    other.run(steps=1, progress=False)
    assert digest(other) != digest(plainOther)  # control


def test_a_run_that_changes_its_number_of_threads_gives_the_same_bits(monkeypatch):
    """As it does beside other jobs, but at every step."""
    plain = hybrid()
    plain.threads = 1
    plain.run(steps=60, progress=False)
    for name, value in dict(FIRST=0.0, LATER=0.0, TRIAL=0.0, GAIN=2.0).items():
        monkeypatch.setattr(pace, name, value)
    monkeypatch.setattr(loop, "SLICE", 0.0)
    monkeypatch.setattr(
        mpm.Scene, "threads", property(lambda scene: scene._threads or 3, mpm.Scene.threads.fset)
    )
    scene, seen = hybrid(), []
    look = pace.Pace.look
    monkeypatch.setattr(pace.Pace, "look", lambda self: (look(self), seen.append(scene._core.threads)))
    scene.run(steps=60, progress=False)
    assert seen.count(1) > 5 and seen.count(3) > 5
    assert digest(scene) == digest(plain)


@pytest.mark.parametrize("threads", [1, 2, 3])
def test_threads_go_on_after_an_error(threads):
    scene = hybrid()
    scene.threads = threads
    scene.run(steps=10, progress=False)
    body = scene["flying"]
    kept = body.position[5].copy()
    body.position[5] = (100.0, 100.0)
    with pytest.raises(RuntimeError, match="outside the grid"):
        scene.run(steps=10, progress=False)
    body.position[5] = kept
    scene.run(steps=10, progress=False)
    assert scene.steps == 20


def test_energies_are_the_same_for_any_number_of_threads_that_numpy_has():
    """Of 40,000 particles: the library that NumPy multiplies with shares the work then, and adds in another
    order."""
    text = """import numpy as np, yade_mpm as mpm
scene = mpm.Scene((0, 0), (100, 100), 1.0)
body = scene.add("body", mpm.box((0, 0), (100, 100)), mpm.LinearElastic(density=2, lame=(1e3, 1e3)),
    mpm.UGIMP(perCell=2))
body.velocity[...] = np.random.default_rng(1).random((body.count, 2))
body.stress[...] = np.random.default_rng(2).random(body.count)[:, None, None] * np.eye(3)
print(mpm.diagnostics.kineticEnergy(scene), *mpm.diagnostics.momentum(scene),
    mpm.diagnostics.sectionForce(body, 50, thickness=96))"""
    runs = [runPython("-c", text, timeout=300, OMP_NUM_THREADS=n, OPENBLAS_NUM_THREADS=n) for n in "12"]
    assert runs[0].returncode == 0, runs[0].stderr
    assert len(runs[0].stdout.split()) == 4 and runs[0].stdout == runs[1].stdout


if __name__ == "__main__":
    print(*digests(sys.argv[1], sys.argv[2], int(sys.argv[3])), sep="\n")
