"""The function for Fluent, compiled with a stand-in for its header: one hit equals Python's."""

import shutil
from pathlib import Path

import numpy as np
import pytest
import toolchain
from known_vectors import VECTORS

import sampler

HERE = Path(__file__).resolve().parent
SOURCE = toolchain.INCLUDE / "fluent_udf.c"
HALF_SIZE = 0.63 * 50e-6
#: Azimuth of the particle about the axis, and the direction there.
TURN = np.radians(60.0)
OUTWARDS = np.array([0.0, np.cos(TURN), np.sin(TURN)])


@pytest.fixture(scope="module")
def programs(tmp_path_factory):
    """Build the program of each number of dimensions."""
    folder = tmp_path_factory.mktemp("fluent")
    flags = [f"-I{HERE}", "-Wno-unused-parameter", *toolchain.QUICK]
    flags += ["-Wno-unused-variable"]  # rp_axi_swirl in three dimensions
    return {
        dimensions: toolchain.build(
            "gcc",
            [HERE / "fluent_hit.c"],
            folder / f"hit{dimensions}",
            [f"-DRP_3D={int(dimensions == 3)}", *flags],
        )
        for dimensions in (2, 3)
    }


@pytest.fixture
def run(programs, tmp_path, monkeypatch):
    """Return status, velocity and user scalars of a particle after a hit, and the printed lines."""
    # a small table, under the name that the function opens
    shutil.copy(VECTORS / "spin.rbt", tmp_path / "corundum-steel.rbt")
    monkeypatch.chdir(tmp_path)

    def hit(dimensions, swirl, position, velocity, normal, wall=None):
        moving = np.zeros(3) if wall is None else wall
        numbers = np.concatenate([position, velocity, normal, moving])
        words = [dimensions, int(swirl), int(wall is not None), *map(repr, numbers.tolist())]
        printed = toolchain.run(programs[dimensions], *map(str, words)).splitlines()
        return np.array(printed[-1].split(), float), printed[:-1]

    return hit


def expected(velocity, normal, wall=(0.0, 0.0, 0.0)):
    """Return velocity and user scalars after the first hit of particle 3, by Python."""
    keys = {"seed": 7, "index": 3, "hit": 0, "wall_velocity": wall}
    after = sampler.load(VECTORS / "spin.h5").rebound(velocity, normal, HALF_SIZE, **keys)
    return np.array([1.0, *after.velocity, 1.0, *after.omega, after.inertia])


def test_three_dimensions(run):
    velocity, outwards = np.array([90.0, -60.0, 30.0]), np.array([0.0, -1.0, 0.0])
    result, _ = run(3, False, np.zeros(3), velocity, outwards)
    np.testing.assert_allclose(result, expected(velocity, -outwards), rtol=1e-9)


def test_plane_and_axisymmetric_cases_keep_two_components(run):
    velocity, outwards = np.array([90.0, -60.0, 0.0]), np.array([0.6, -0.8, 0.0])
    result, _ = run(2, False, np.zeros(3), velocity, outwards)
    after = expected(velocity, -outwards)
    after[3] = 0.0
    np.testing.assert_allclose(result, after, rtol=1e-9)


def test_axisymmetric_swirl_turns_the_normal_with_the_particle(run):
    """A pipe's wall at 60 degrees of azimuth; the face lies in the half-plane z = 0."""
    velocity = 80.0 * OUTWARDS + [60.0, 0.0, 0.0] + 20.0 * np.cross([1.0, 0.0, 0.0], OUTWARDS)
    result, _ = run(2, True, 0.1 * OUTWARDS, velocity, [0.0, 1.0, 0.0])
    np.testing.assert_allclose(result, expected(velocity, -OUTWARDS), rtol=1e-9)
    assert result[1:4] @ OUTWARDS < 0.0


@pytest.mark.parametrize("dimensions", [2, 3])
def test_the_velocity_of_a_moving_wall_is_passed(run, dimensions):
    velocity, outwards = np.array([90.0, 60.0, 0.0]), np.array([0.0, 1.0, 0.0])
    wall = np.array([20.0, -8.0, 0.0])
    result, _ = run(dimensions, False, np.zeros(3), velocity, outwards, wall)
    after = expected(velocity, -outwards, wall)
    if dimensions == 2:
        after[3] = 0.0
    np.testing.assert_allclose(result, after, rtol=1e-9)


def test_a_particle_that_leaves_the_wall_goes_on(run):
    velocity = np.array([90.0, 60.0, 30.0])
    result, _ = run(3, False, np.zeros(3), velocity, np.array([0.0, -1.0, 0.0]))
    np.testing.assert_array_equal(result, [1.0, *velocity, 0.0, 0.0, 0.0, 0.0, 0.0])


def test_a_missing_table_is_reported(run, tmp_path):
    (tmp_path / "corundum-steel.rbt").unlink()
    result, printed = run(3, False, np.zeros(3), [9.0, -9.0, 0.0], [0.0, -1.0, 0.0])
    assert result[0] == 0.0
    assert len(printed) == 1
    assert printed[0].startswith(
        "rebound_wall: corundum-steel.rbt: the file does not exist, or may not be read"
    )
    assert printed[0].endswith("; all particles that meet a wall are aborted")
