"""``tablegen simulate``: its output, for shapes of a pair and for a mesh."""

from types import SimpleNamespace

import numpy as np
import pytest
from command_line import DONE, SIMULATE, flags
from mesh_fixtures import POPULATION, grain, rebounds, surface, two_cubes

from sampler.formats.channels import STATE
from sampler.formats.shape_codes import FIRST_MESH
from tablegen.config.config import load_config
from tablegen.meshes.mesh_file import read_mesh
from tablegen.simulation.simulate import make_condition, simulate_condition


@pytest.fixture
def simulated(run, tmp_path):
    def runner(**changes):
        output = tmp_path / "rebounds.npz"
        words = flags(SIMULATE, {f"--{name}": value for name, value in changes.items()})
        ended = run("simulate", *words, "--output", output, "--overwrite", "--quiet")
        assert (ended.status, ended.out) == (DONE, "")
        with np.load(output) as file:
            return SimpleNamespace(err=ended.err, files=file.files, **dict(file.items()))

    return runner


def test_fields(simulated):
    result = simulated()
    fields = ["state", "collisions", "shape", "aspect", "energy", "work", "inertia"]
    assert result.files == [*fields, "columns"]
    assert tuple(result.columns) == STATE
    for name, shape, kind in (
        ("state", (300, 6), "f8"),
        ("collisions", (300,), "i8"),
        ("shape", (300,), "i8"),
        ("aspect", (300, 2), "f8"),
        ("energy", (300, 2), "f8"),
        ("work", (300, 2), "f8"),
        ("inertia", (300,), "f8"),
    ):
        values = getattr(result, name)
        assert (values.shape, values.dtype) == (shape, np.dtype(kind))
    speed2 = (result.state[:, :3] ** 2).sum(axis=1)
    np.testing.assert_allclose(result.energy[:, 0], speed2, rtol=1e-12)
    np.testing.assert_allclose(
        result.energy.sum(axis=1) + result.work.sum(axis=1), 1.0, rtol=0.0, atol=1e-11
    )


@pytest.mark.parametrize(
    ("spin", "inertia"),
    [((0.0, 0.0, 0.0), 0.0), ((0.5, -0.25, 1.0), 0.0), ((0.5, -0.25, 1.0), 0.3)],
)
def test_is_the_simulation(simulated, spin, inertia):
    config = load_config("corundum-steel")
    condition = make_condition(np.radians(45.0), 200.0, spin, inertia=inertia)
    expected = simulate_condition(config.pair, config.population, condition, 300, seed=1)
    result = simulated(spin=spin, inertia=inertia)
    for name in ("state", "collisions", "shape", "aspect", "energy", "work", "inertia"):
        np.testing.assert_array_equal(getattr(result, name), getattr(expected, name))


def test_angular_velocities_are_means_or_those_of_the_departure(simulated):
    mean, departure = simulated().state, simulated(omega="departure").state
    assert (np.abs(mean - departure).max(axis=0) > [-1, -1, -1, 0.1, 0.1, 0.1]).all()
    np.testing.assert_array_equal(mean[:, :3], departure[:, :3])
    np.testing.assert_array_equal(simulated(omega="mean").state, mean)


def test_speed_outside_the_law_is_simulated_with_a_note(simulated):
    assert "m/s" not in simulated(speed=300).err
    assert "301 m/s" in simulated(speed=301).err


def test_a_mesh_is_simulated(simulated, tmp_path):
    path = tmp_path / "mesh.stl"
    for mesh, note in ((surface(grain(60)), ""), (two_cubes(), "its convex hull, of 1.5 times")):
        mesh.export(path)
        result = simulated(shape=None, particle=path)
        assert note in result.err
        assert ("convex hull" in note) == ("convex hull" in result.err)
        assert "particles: 100 % mesh.stl" in result.err
        assert set(result.shape) == {FIRST_MESH}
        expected = rebounds(POPULATION.with_mesh(read_mesh(path)), 300, seed=1)
        np.testing.assert_array_equal(result.state, expected.state)


def test_a_mesh_and_a_shape_are_refused_and_so_is_neither(refused, tmp_path):
    output = {"--output": tmp_path / "r.npz"}
    for changes in ({"--particle": "grain.stl"}, {"--shape": None}):
        line = refused("simulate", *flags(SIMULATE, changes | output))
        assert line.startswith("--shape: is ")
        assert line.endswith("; give either --shape or --particle")
    changes = {"--shape": None, "--particle": "grain.stl", "--aspect": ("0.8", "0.7")}
    line = refused("simulate", *flags(SIMULATE, changes | output))
    assert line.startswith("--aspect: is given with --particle")
