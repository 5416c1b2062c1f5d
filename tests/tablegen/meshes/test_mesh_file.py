"""Particles from mesh files: files, the frame of the particle, configurations and the command."""

import math
import pickle

import numpy as np
import pytest
import tomli_w
import trimesh
from mesh_fixtures import KNOWN, box, grain, known_body, posed, rebounds, surface, two_cubes
from refusals import refused

import sampler
import tablegen
from sampler.files import data_directory
from tablegen.config.config import load_config, parse_config
from tablegen.meshes.mesh_file import SUFFIXES, read_mesh
from tablegen.meshes.particle import MOST_VERTICES, mesh_particle
from tablegen.model.shapes import FIRST_MESH

PAIR_TEXT = (data_directory() / "corundum-steel.toml").read_text(encoding="utf-8")


def obj_text(scale):
    """An OBJ file of a box, at any scale that text can hold."""
    mesh = surface(box(0.8, 0.6))
    lines = [f"v {' '.join(repr(float(x * scale)) for x in row)}" for row in mesh.vertices]
    return "\n".join([*lines, *(f"f {a + 1} {b + 1} {c + 1}" for a, b, c in mesh.faces), ""])


def written(folder, name, content):
    """Write a text, bytes or a mesh to a file, and return its path."""
    path = folder / name
    if isinstance(content, trimesh.Trimesh):
        content.export(path)
    elif isinstance(content, bytes):
        path.write_bytes(content)
    elif content is not None:
        path.write_text(content)
    return path


class TestFiles:
    @pytest.mark.parametrize("suffix", SUFFIXES)
    def test_every_format_gives_the_same_particle(self, tmp_path, suffix):
        points = grain(60).astype(np.float32).astype(np.float64)
        read = read_mesh(written(tmp_path, f"grain{suffix}", surface(points)))
        assert read.name == f"grain{suffix}"
        assert read.is_convex
        particle, expected = mesh_particle(read.vertices), mesh_particle(points)
        assert len(particle.vertices) == 60
        np.testing.assert_allclose(particle.moments, expected.moments, rtol=1e-6)
        np.testing.assert_allclose(particle.half_sizes, expected.half_sizes, rtol=1e-6)

    def test_suffix_in_capitals_ascii_and_materials(self, tmp_path):
        text = trimesh.exchange.stl.export_stl_ascii(surface(box(0.5, 0.25)))
        read = read_mesh(written(tmp_path, "BOX.STL", text))
        assert sorted(read.vertices) == sorted(map(tuple, box(0.5, 0.25).tolist()))
        text = "mtllib none.mtl\nusemtl stone\n" + obj_text(1.0)
        assert len(read_mesh(written(tmp_path, "box.obj", text)).vertices) == 8

    def test_hull_of_a_mesh_that_is_not_convex(self, tmp_path):
        read = read_mesh(written(tmp_path, "two.stl", two_cubes().apply_scale(1e-29)))
        assert len(read.vertices) == 8
        assert not read.is_convex
        assert read.solidity == pytest.approx(2.0 / 3.0, rel=1e-6)
        particle = mesh_particle(read.vertices)
        np.testing.assert_allclose(particle.half_sizes, [1.0, 1.0 / 3.0, 1.0 / 3.0], rtol=1e-6)

    def test_only_the_hull_counts(self, tmp_path):
        mesh = surface(box(0.8, 0.6))
        mesh = trimesh.Trimesh(mesh.vertices, mesh.faces[1:], process=False)
        read = read_mesh(written(tmp_path, "box.stl", mesh))
        assert len(read.vertices) == 8
        assert read.solidity is None
        assert read.is_open
        assert read.doubts()[0].startswith("box.stl is open; its convex hull is simulated")
        mesh.faces = np.vstack([mesh.faces, surface(box(0.8, 0.6)).faces[0, ::-1]])
        read = read_mesh(written(tmp_path, "turned.ply", mesh))
        assert not read.is_open
        assert "do not agree on the outside" in read.doubts()[0]

    @pytest.mark.parametrize("suffix", SUFFIXES)
    @pytest.mark.parametrize(
        "stray", [[], [[8, 8, 8]], [[0, 0, 8]]], ids=("alone", "point", "line")
    )
    def test_a_vertex_of_no_surface_is_no_corner(self, tmp_path, suffix, stray):
        """A vertex without a face, or with faces that have no area, lies far from a box."""
        mesh = surface(box(0.8, 0.6))
        points = np.vstack([mesh.vertices, [0.0, 0.0, 3.0]])
        faces = np.array([*mesh.faces.tolist(), *stray])
        mesh = trimesh.Trimesh(points, faces, process=False)
        read = read_mesh(written(tmp_path, f"box{suffix}", mesh))
        assert len(read.vertices) == 8
        assert read.is_convex

    def test_indices_of_an_obj_count_from_their_face(self, tmp_path):
        mesh = surface(box(0.8, 0.6))
        lines = []
        for first, face in enumerate(mesh.faces):
            lines += ["v " + " ".join(map(str, row)) for row in mesh.vertices[face]]
            lines += ["f -3 -2 -1" if first % 2 else "f -3/1 -2//2 \\\n -1  # Å"]
        read = read_mesh(written(tmp_path, "box.obj", "\n".join(lines)))
        assert len(read.vertices) == 8
        assert read.is_convex


@pytest.mark.parametrize("squash", [(1.0, 1.0, 1.0), (1.0, 0.05, 0.05), (1.0, 1.0, 0.05)])
def test_a_hull_of_many_corners_is_thinned_within_the_tolerance(tmp_path, squash):
    sphere = trimesh.creation.icosphere(5).apply_scale(squash)  # 10242 corners
    read = read_mesh(written(tmp_path, "many.ply", sphere))
    assert read.corners == 10_242
    assert 100 < len(read.vertices) < MOST_VERTICES
    assert read.is_convex
    corners = {row.tobytes() for row in np.asarray(sphere.vertices, dtype=np.float32)}
    assert {np.asarray(row, dtype=np.float32).tobytes() for row in read.vertices} <= corners
    # how far the body reaches along directions loses no more than the tolerance, 5e-4 of 2
    directions = np.random.default_rng(1).standard_normal((2000, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    reach = [(directions @ np.asarray(v).T).max(axis=1) for v in (sphere.vertices, read.vertices)]
    lost = (reach[0] - reach[1]).max()
    assert 1e-4 < lost < 1e-3
    particle = mesh_particle(sphere.vertices)
    expected = np.sort((sum(np.square(squash)) - np.square(squash)) / 5.0)
    # the needle is 0.05 thick, of which 5e-4 on either side may be lost
    np.testing.assert_allclose(particle.moments, expected, rtol=0.02)


FLAT = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"


def ply_text(face, axes="xyz"):
    """A PLY file of a tetrahedron, whose first face is given."""
    head = ["ply", "format ascii 1.0", "element vertex 4", *(f"property float {x}" for x in axes)]
    head += ["element face 4", "property list uchar int vertex_indices", "end_header"]
    points = [" ".join(map(str, row[: len(axes)])) for row in ([0, 0, 0], *np.eye(3).tolist())]
    return "\n".join([*head, *points, face, "3 0 3 1", "3 0 2 3", "3 1 3 2", ""])


class TestRefused:
    @pytest.mark.parametrize(
        ("name", "content", "reason"),
        [
            ("none.stl", None, "there is no file "),
            ("grain.step", "ISO-10303-21;", "a file ending in"),
            ("empty.stl", "", "the mesh of a surface"),
            ("empty.ply", "", "a mesh file"),
            ("flat.obj", FLAT, "a mesh that encloses a volume"),
            ("nan.obj", FLAT.replace("v 1 1 0", "v 1 nan 1"), "coordinates"),
            ("beyond.obj", FLAT.replace("f 1 3 2", "f 1 3 9"), "vertices 0 to 3"),
            ("zero.obj", FLAT.replace("f 1 3 2", "f 1 3 0"), "vertices 0 to 3"),
            ("before.obj", FLAT.replace("f 1 3 2", "f 1 3 -9"), "vertices 0 to 3"),
            ("digits.obj", FLAT.replace("f 1 3 2", "f 1 3 0_2"), "a mesh file"),
            ("plane.obj", FLAT.replace("v 1 1 0", "v 1 1"), "a mesh file"),
            ("words.obj", FLAT.replace("v 1 1 0", "v 1 1_0 0"), "coordinates"),
            ("line.obj", FLAT.replace("v 1 1 0", "v 2 0 0").split("f")[0] + "f 1 2 4", "the mesh"),
            ("beyond.ply", ply_text("3 0 1 9"), "vertices 0 to 3"),
            ("negative.ply", ply_text("3 0 1 -1"), "vertices 0 to 3"),
            ("plane.ply", ply_text("3 0 1 2", "xy"), "a mesh file"),
            *((f"{scale}.obj", obj_text(scale), "coordinates up to") for scale in (1e-300, 1e300)),
        ],
    )
    def test_files(self, tmp_path, name, content, reason):
        path = written(tmp_path, name, content)
        line = refused("particle", read_mesh, path)
        if content is None:
            assert line == f"particle: {reason}{path}"
        else:
            assert line.startswith(f"particle: got {path}")
            assert line.partition("allowed: ")[2].startswith(reason)

    @pytest.mark.parametrize(
        "points",
        [np.zeros((3, 3)), np.full((8, 3), math.nan), 1e-31 * box(0.8, 0.6), box(0.8, 0.0)],
    )
    def test_points(self, points):
        refused("vertices", mesh_particle, points)


class TestFrame:
    @pytest.mark.parametrize(("b", "c"), [(0.8, 0.64), (1.0, 1.0), (1.0, 0.2)])
    @pytest.mark.parametrize("shape", KNOWN)
    def test_known_shapes(self, shape, b, c):
        particle = mesh_particle(posed(KNOWN[shape](b, c), scale=3e-5, shift=(1e-3, 0.0, 2e-4)))
        known = known_body(shape, b, c)
        np.testing.assert_allclose(particle.moments, known.moments, rtol=1e-10)
        np.testing.assert_allclose(particle.half_sizes, [1.0, b, c], rtol=1e-10)
        assert particle.bounding_radius == pytest.approx(known.bounding_radius, rel=1e-10)
        assert len(particle.vertices) == len(known.candidates)
        corners = np.tile([1.0, b, c], (len(particle.vertices), 1))
        np.testing.assert_allclose(np.abs(particle.vertices), corners, rtol=1e-10)

    def test_pose_and_units_do_not_matter_but_a_mirror_does(self):
        points = grain(200)
        plain = mesh_particle(points)
        moved = mesh_particle(posed(points, scale=2e-5, shift=(0.01, -0.02, 0.03)))
        mirrored = mesh_particle(points * [1.0, 1.0, -1.0])
        for particle, handedness in ((moved, 1.0), (mirrored, -1.0)):
            np.testing.assert_allclose(particle.moments, plain.moments, rtol=1e-9)
            np.testing.assert_allclose(particle.half_sizes, plain.half_sizes, rtol=1e-9)
            assert np.linalg.det(particle.axes) == pytest.approx(1.0, rel=1e-12)
            # the corners agree but for the directions of the axes
            flips = np.sign((particle.vertices * plain.vertices).sum(axis=0))
            assert flips.prod() == handedness
            np.testing.assert_allclose(particle.vertices * flips, plain.vertices, atol=1e-9)

    def test_moments_decide_the_order_of_the_axes(self):
        # spikes make a body longest along an axis about which it has not the least moment
        spiked = np.concatenate([box(0.8, 0.78), [[0.0, 0.0, 1.1], [0.0, 0.0, -1.1]]])
        particle = mesh_particle(spiked)
        assert particle.moments[0] <= particle.moments[1] <= particle.moments[2]
        assert particle.half_sizes[0] == 1.0
        assert particle.half_sizes.max() == pytest.approx(1.1, rel=1e-12)


class TestConfig:
    def test_a_hull_that_is_no_mesh_is_said(self, tmp_path, caplog):
        written(tmp_path, "two.ply", two_cubes())
        parse_config(PAIR_TEXT + '[[population.meshes]]\nfile = "two.ply"\n', "my.toml", tmp_path)
        (line,) = caplog.messages
        assert (
            line == "two.ply is not convex; its convex hull, of 1.5 times its volume, is simulated"
        )

    def test_text_stands_alone(self, tmp_path, caplog):
        path = written(tmp_path, "grain.ply", surface(grain(60)))
        text = PAIR_TEXT + '[[population.meshes]]\nfile = "grain.ply"\nweight = 2.0\n'
        config = parse_config(text, "my.toml", tmp_path)
        assert caplog.messages == []
        mesh = config.population.meshes[0]
        assert (len(mesh.vertices), mesh.file, mesh.weight) == (60, "grain.ply", 2.0)
        path.unlink()
        again = parse_config(config.text, "again")
        assert again == config == pickle.loads(pickle.dumps(config))
        assert again.text == config.text
        states = [rebounds(c.population, 500, seed=1).state for c in (config, again)]
        np.testing.assert_array_equal(*states)

    def meshes_alone(self, **shapes):
        """Return a configuration with a mesh, and some shapes, but no law of ratios."""
        tree = load_config("corundum-steel").model_dump(mode="json", exclude_none=True)
        tree["population"] = {"meshes": [{"vertices": grain(60).tolist()}], "shapes": shapes}
        return parse_config(tomli_w.dumps(tree), "my.toml")

    def test_meshes_and_spheres_need_no_ratios(self):
        config = self.meshes_alone()
        assert config.population.kernel_arguments().shape_codes.tolist() == [FIRST_MESH]
        assert set(tablegen.simulate(config, 0.7, 200.0, 20, seed=1).shape) == {FIRST_MESH}
        refused("aspect", config.population.restricted_to("prism").kernel_arguments)
        config = self.meshes_alone(sphere=1.0)
        assert config.population.kernel_arguments().shape_codes.tolist() == [4, FIRST_MESH]
        refused("my.toml: population.aspect", self.meshes_alone, prism=1.0)


def test_an_stl_far_from_the_origin_has_lost_its_form(tmp_path):
    """Far from the origin, single precision rounds the corners of a block to half a metre."""
    near, far = surface(box(0.8, 0.6)), surface(box(0.8, 0.6))
    near.apply_translation([50.0, 45.0, 0.0])
    far.apply_translation([5e5, 4.5e6, 0.0])
    read_mesh(written(tmp_path, "near.stl", near))
    with pytest.raises(sampler.InputError, match=r"a size of 2 in steps of 0\.5"):
        read_mesh(written(tmp_path, "far.stl", far))
