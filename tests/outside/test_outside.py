# SPDX-License-Identifier: GPL-2.0-or-later
"""Classes that were built outside of the tree, against an installed copy, are as good as those inside."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
import yade_mpm as mpm
from yade_mpm.check import limits

HERE = Path(__file__).parent
BUILD = Path(mpm._core.__file__).parents[2]  # of build/python/yade_mpm/_core...so


def do(*command, **more):
    done = subprocess.run(command, capture_output=True, text=True, timeout=600, **more)
    assert done.returncode == 0, f"{command}\n{done.stdout}\n{done.stderr}"
    return done.stdout


@pytest.fixture(scope="module")
def outside(tmp_path_factory):
    """Installs the build and builds the plugins against that; run(code) is Python with the installed copy."""
    cache = BUILD / "CMakeCache.txt"
    if not cache.exists():
        pytest.skip(f"{mpm.__file__} is an installed copy; this needs the build folder of a checkout")
    if "MPM_SANITIZE:STRING=\n" not in cache.read_text():
        pytest.skip("sanitizers have to be loaded before Python")
    prefix, plugins = (tmp_path_factory.mktemp(name) for name in ("prefix", "plugins"))
    do("cmake", "--install", BUILD, "--prefix", prefix)
    do("cmake", "-S", HERE, "-B", plugins, "-G", "Ninja", f"-DCMAKE_PREFIX_PATH={prefix}")
    do("cmake", "--build", plugins, "--parallel", "2")
    package = next(prefix.rglob("yade_mpm/__init__.py")).parents[1]

    def run(code):
        start = f"import yade_mpm as mpm\nfolder = {str(plugins)!r}\n"
        return do(
            sys.executable, "-c", start + code, env=dict(os.environ, PYTHONPATH=str(package)), cwd=prefix
        )

    return run


def test_what_is_installed_is_what_is_loaded(outside):
    assert str(BUILD) not in outside("print(mpm.__file__)")


def test_classes_from_outside_are_listed_and_explained(outside):
    out = outside(
        """
print(mpm.loadPlugin(folder + "/liboutside.so"), mpm.loadPlugin(folder + "/liboutside.so"))
assert {"BSplineOutside", "FluidOutside"} <= set(mpm.__all__)
assert "from a plugin" in mpm.BSplineOutside.__doc__ and "bulk modulus" in mpm.FluidOutside.__doc__
print(mpm.BSplineOutside(perCell=3), mpm.FluidOutside(density=1.0, bulk=2e3))
try:
    mpm.FluidOutside(density=1.0, bulk=-1.0)
except ValueError as error:  # thrown by the plugin, caught by the package
    print(error)
"""
    )
    assert out.startswith("['FluidOutside', 'StiffeningOutside', 'BSplineOutside'] []\n")
    assert "FluidOutside: bulk = -1 is not allowed" in out


def test_a_type_from_outside_gives_the_bits_of_the_one_inside(outside):
    out = outside(
        """
mpm.loadPlugin(folder + "/liboutside.so")
def run(make):
    scene = mpm.Scene((0, 0), (8, 8), 0.5)
    fluid = mpm.FluidOutside(density=1.0, bulk=2e3)
    body = scene.add("body", mpm.box((2, 2), (5, 4)), fluid, make(perCell=3))
    body.velocity[:, 0] = 1 - 0.5 * (body.position[:, 0] - 3.5)  # moves on, and is squeezed
    solver = mpm.GridSolver(gravity=(0, -9.81))
    scene.engines = [mpm.ParticleToGrid(), solver, mpm.GridToParticle(), mpm.DomainUpdater()]
    scene.threads = 2
    scene.run(steps=50, progress=False)
    return body.position.tobytes() + body.stress.tobytes(), abs(body.stress).max()
plain, ours, other = run(mpm.BSpline), run(mpm.BSplineOutside), run(mpm.UGIMP)
assert plain == ours and ours[1] > 0.1
assert other[0] != ours[0]  # the control
print("equal")
"""
    )
    assert "equal" in out


def test_a_checkpoint_knows_a_type_from_outside(outside):
    build = """
mpm.loadPlugin(folder + "/liboutside.so")
scene = mpm.Scene((0, 0), (4, 4), 0.5)
rubber = mpm.LinearElastic(density=1.0, lame=(1e3, 1e3))
scene.add("body", mpm.box((1, 1), (2, 2)), rubber, mpm.BSplineOutside(perCell=2))
scene.engines = [mpm.ParticleToGrid(), mpm.GridSolver(), mpm.GridToParticle(), mpm.DomainUpdater()]
scene.run(steps=5, progress=False)
scene.save("outside.h5")
"""
    outside(build)
    assert "BSplineOutside" in outside(
        'mpm.loadPlugin(folder + "/liboutside.so")\nprint(mpm.load("outside.h5")["body"].type)'
    )


@pytest.mark.parametrize(
    "library, complaint",
    [
        ("libother_version.so", "its class FluidOutside was built for [yade_mpm 0.0.1, "),
        ("libtaken_name.so", "there is a class named NeoHookean already"),
        ("libnowhere.so", "cannot be loaded"),
        ("CMakeCache.txt", "cannot be loaded"),
    ],
)
def test_a_wrong_library_is_refused(outside, library, complaint):
    out = outside(
        f"""
before = dir(mpm)
try:
    mpm.loadPlugin(folder + "/{library}")
except ValueError as error:
    print(error)
assert dir(mpm) == before
"""
    )
    assert complaint in out


def test_the_step_follows_a_stiffness_that_follows_the_stress(outside):
    """Soil is pressed from 20 to 480 kPa within one estimate, by 3.2 % of its height: its waves get five
    times as fast. The step was that of 20 kPa, and the run ended without finite numbers."""
    out = outside(
        """
mpm.loadPlugin(folder + "/liboutside.so")
scene = mpm.Scene((0, 0), (1, 1), 0.25, threads=1)
soil = scene.add("soil", mpm.box((0, 0), (1, 1)), mpm.StiffeningOutside(density=2.0, kappa=0.01), mpm.UGIMP())
soil.setStress([[-20, 0, 0], [0, -20, 0], [0, 0, -20]])
top = mpm.Hold("top", velocity=(None, -0.0066), ramp=0.2)
scene.engines[1] = mpm.GridSolver(roller=("left", "right", "bottom"), hold=top, damping=0.3)
scene.run(steps=1, progress=False)
first = scene.dt
scene.run(until=4.92, progress=False)
p = -soil.stress.trace(axis1=1, axis2=2) / 3
longest = scene._core.criticalTimeStep(1e-4, 300, False)["longestStable"]
print(scene.steps, first / scene.dt, scene.dt / longest, p.mean())
"""
    )
    steps, shorter, share, pressure = map(float, out.split())
    assert steps < limits.DT_PERIOD and shorter > 3 and share < 0.8  # of the longest stable step
    assert pressure == pytest.approx(480, rel=0.1)
