"""``tablegen simulate --particle``: grains of a mesh."""

import numpy as np
from command_line import DONE, SIMULATE, flags
from mesh_fixtures import POPULATION, grain, rebounds, surface, two_cubes

from tablegen.config.mesh import read_mesh


def simulated(run, folder, mesh):
    path = folder / "mesh.stl"
    mesh.export(path)
    changes = {"--shape": None, "--particle": path, "--output": folder / "r.npz"}
    ended = run("simulate", *flags(SIMULATE, changes), "--quiet")
    assert (ended.status, ended.out) == (DONE, "")
    people = POPULATION.of_mesh(read_mesh(path))
    with np.load(folder / "r.npz") as file:
        assert set(file["shape"]) == {5}
        np.testing.assert_array_equal(file["state"], rebounds(people, 300, seed=1).state)
    return ended.err


def test_a_mesh_is_simulated(run, tmp_path):
    assert simulated(run, tmp_path, surface(grain(60))) == ""
    assert "mesh.stl is not convex; its convex hull, of 1.5 times its volume" in simulated(
        run, tmp_path, two_cubes()
    )


def test_a_mesh_and_a_shape_are_refused_and_so_is_neither(refused, tmp_path):
    output = {"--output": tmp_path / "r.npz"}
    for changes in ({"--particle": "grain.stl"}, {"--shape": None}):
        assert "'--shape' or '--particle'" in refused(
            "simulate", *flags(SIMULATE, changes | output)
        )
