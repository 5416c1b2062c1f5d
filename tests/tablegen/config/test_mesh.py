"""Particles from mesh files: what the files hold, and the frame of the particle."""

import math
import sys
from types import SimpleNamespace

import numpy as np
import pytest
import trimesh
from mesh_fixtures import KNOWN, box, grain, icosphere, known_body, posed, surface, two_cubes

from sampler.errors import InputError
from tablegen.config.mesh import SUFFIXES, load_mesh, mesh_particle, read_mesh


class TestFiles:
    @pytest.mark.parametrize("suffix", SUFFIXES)
    def test_every_format_gives_the_same_particle(self, tmp_path, suffix):
        points = grain(60).astype(np.float32).astype(np.float64)
        path = tmp_path / f"grain{suffix}"
        surface(points).export(path)
        made, expected = load_mesh(path), mesh_particle(points)
        assert len(made.vertices) == 60
        np.testing.assert_allclose(made.moments, expected.moments, rtol=1e-6)
        np.testing.assert_allclose(made.half_sizes, expected.half_sizes, rtol=1e-6)
        assert made.unit == pytest.approx(expected.unit, rel=1e-6)

    def test_suffix_in_capitals_and_ascii(self, tmp_path):
        path = tmp_path / "BOX.STL"
        path.write_text(trimesh.exchange.stl.export_stl_ascii(surface(box(0.5, 0.25))))
        assert sorted(read_mesh(path).vertices) == sorted(map(tuple, box(0.5, 0.25).tolist()))

    def test_convex_mesh(self, tmp_path):
        surface(grain(60)).export(tmp_path / "grain.ply")
        read = read_mesh(tmp_path / "grain.ply")
        assert read.name == "grain.ply"
        assert read.is_convex
        assert read.solidity == pytest.approx(1.0, abs=1e-5)

    @pytest.mark.parametrize("scale", [1e-29, 1e-6, 1.0, 1e3, 1e29])
    def test_hull_of_a_mesh_that_is_not_convex(self, tmp_path, scale):
        two_cubes().apply_scale(scale).export(tmp_path / "two.stl")
        read = read_mesh(tmp_path / "two.stl")
        assert len(read.vertices) == 8
        assert not read.is_convex
        assert read.solidity == pytest.approx(2.0 / 3.0, rel=1e-6)
        made = load_mesh(tmp_path / "two.stl")
        np.testing.assert_allclose(made.half_sizes, [1.0, 1.0 / 3.0, 1.0 / 3.0], rtol=1e-6)
        assert made.unit == pytest.approx(1.5 * scale, rel=1e-6)


class TestOtherFiles:
    """Nothing is opened beside the mesh itself, and nothing is said of what it names."""

    @pytest.mark.parametrize("lines", ["mtllib stone.mtl\nusemtl stone\n", "mtllib stone.mtl\n"])
    def test_materials_of_obj(self, tmp_path, opened_files, capfd, caplog, lines):
        (tmp_path / "stone.mtl").write_text("newmtl stone\nKd 1 0 0\nmap_Kd stone.png\n")
        (tmp_path / "stone.png").write_bytes(b"no image")
        path = written(tmp_path, "a.obj", lines + obj_text(1.0))
        self.check(path, opened_files, capfd, caplog)

    def test_texture_of_ply(self, tmp_path, opened_files, capfd, caplog):
        (tmp_path / "stone.png").write_bytes(b"no image")
        plain = trimesh.exchange.ply.export_ply(surface(box(0.8, 0.6)), encoding="ascii")
        named = plain.replace(
            b"element vertex", b"comment TextureFile stone.png\nelement vertex", 1
        )
        path = written(tmp_path, "a.ply", named)
        self.check(path, opened_files, capfd, caplog)

    @staticmethod
    def check(path, opened_files, capfd, caplog):
        opened_files.names = names = []
        assert len(read_mesh(path).vertices) == 8
        opened_files.names = None
        assert {name for name in names if str(path.parent) in name} == {str(path)}
        assert capfd.readouterr() == ("", "")
        assert caplog.text == ""


def obj_text(scale):
    """An OBJ file of a box, at any scale that text can hold."""
    mesh = surface(box(0.8, 0.6))
    lines = [f"v {' '.join(repr(float(x * scale)) for x in row)}" for row in mesh.vertices]
    return "\n".join([*lines, *(f"f {a + 1} {b + 1} {c + 1}" for a, b, c in mesh.faces), ""])


@pytest.fixture(scope="session")
def opened_files():
    """Paths of the files that are opened, while it has a list of `names`."""
    watch = SimpleNamespace(names=None)

    def hook(event, details):
        if watch.names is not None and event == "open":
            watch.names.append(str(details[0]))

    sys.addaudithook(hook)  # which cannot be removed
    return watch


def written(folder, name, content):
    """Path of a file with a content: text, bytes, or a mesh."""
    path = folder / name
    if isinstance(content, trimesh.Trimesh):
        content.export(path)
    elif isinstance(content, bytes):
        path.write_bytes(content)
    elif content is not None:
        path.write_text(content)
    return path


def without_a_face():
    mesh = surface(box(0.8, 0.6))
    return trimesh.Trimesh(mesh.vertices, mesh.faces[1:], process=False)


def inside_out():
    mesh = surface(box(0.8, 0.6))
    faces = mesh.faces.copy()
    faces[0] = faces[0, ::-1]
    return trimesh.Trimesh(mesh.vertices, faces, process=False)


FLAT = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
POINTS = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
POINTS += "property float z\nend_header\n0 0 0\n"


class TestRefusedFiles:
    @pytest.mark.parametrize(
        ("name", "content", "reason"),
        [
            ("none.stl", None, "none.stl, allowed: a file that exists"),
            ("grain.step", "ISO-10303-21;", "grain.step, allowed: a file ending in .stl, .obj"),
            ("empty.stl", "", "which has no faces, allowed: a closed surface"),
            ("empty.obj", "", "which has no faces, allowed: a closed surface"),
            ("empty.ply", "", "cannot be read as PLY, allowed: a mesh file"),
            ("points.ply", POINTS, "which has no faces, allowed: a closed surface"),
            ("foreign.stl", b"\x89PNG" + bytes(200), "allowed: "),
            ("cut.stl", trimesh.exchange.stl.export_stl(inside_out())[:200], "be read as STL"),
            ("three.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "which has 3 vertices, all"),
            ("flat.obj", FLAT, "which is flat, allowed: a mesh that encloses a volume"),
            ("nan.obj", FLAT.replace("v 1 1 0", "v 1 nan 1"), "vertex that is not finite, all"),
            ("open.stl", without_a_face(), "which is open, allowed: a closed surface"),
            ("small.obj", obj_text(1e-300), "with an extent of 2e-300, allowed: coordinates up to"),
            ("large.obj", obj_text(1e300), "with a coordinate of 1e+300, allowed: coordinates up"),
            ("largest.obj", obj_text(1.5e308), "with a coordinate of 1.5e+308, allowed: coordin"),
            ("inside.stl", inside_out(), "with faces turned inside out, allowed: faces that"),
        ],
    )
    def test_reason_is_given(self, tmp_path, name, content, reason):
        path = written(tmp_path, name, content)
        with pytest.raises(InputError) as caught:
            read_mesh(path)
        line = str(caught.value)
        assert line.startswith(f"particle: got {path}")
        assert reason in line
        assert "\n" not in line

    def test_a_file_that_is_too_long(self, tmp_path, monkeypatch):
        monkeypatch.setattr("tablegen.config.mesh.MOST_BYTES", 100)
        with pytest.raises(InputError, match=r"of \d+ bytes, allowed: up to 100"):
            read_mesh(written(tmp_path, "grain.stl", surface(grain(60))))

    def test_too_many_corners(self, tmp_path, monkeypatch):
        monkeypatch.setattr("tablegen.config.mesh.MOST_VERTICES", 50)
        path = written(tmp_path, "grain.ply", surface(grain(60)))
        with pytest.raises(InputError, match="hull has 60 vertices, allowed: up to 50"):
            read_mesh(path)

    @pytest.mark.parametrize(
        ("points", "reason"),
        [
            (np.zeros((3, 3)), r"got shape \(3, 3\), allowed: 4 to 10000 rows of three numbers"),
            (np.zeros((8, 2)), r"got shape \(8, 2\), allowed"),
            (np.full((8, 3), math.nan), "not finite"),
            (1e31 * box(0.8, 0.6), "a coordinate of 1e.31, allowed: coordinates up to 1e.30"),
            (1e-31 * box(0.8, 0.6), "an extent of 2e-31, allowed: .* a largest extent of 1e-30 or"),
            (box(0.8, 0.0), "that lie in a plane, allowed: points that span a volume"),
        ],
    )
    def test_points(self, points, reason):
        with pytest.raises(InputError, match=f"^vertices: .*{reason}"):
            mesh_particle(points)


class TestFrame:
    @pytest.mark.parametrize(("b", "c"), [(0.8, 0.64), (1.0, 1.0), (0.5, 0.5), (1.0, 0.2)])
    @pytest.mark.parametrize("shape", KNOWN)
    def test_known_shapes(self, shape, b, c):
        made = mesh_particle(posed(KNOWN[shape](b, c), scale=3e-5, shift=(1e-3, 0.0, 2e-4)))
        known = known_body(shape, b, c)
        np.testing.assert_allclose(made.moments, known.moments, rtol=1e-10)
        np.testing.assert_allclose(made.half_sizes, [1.0, b, c], rtol=1e-10)
        assert made.bounding_radius == pytest.approx(known.bounding_radius, rel=1e-10)
        assert len(made.vertices) == len(known.candidates)
        np.testing.assert_allclose(
            np.abs(made.vertices), np.tile([1.0, b, c], (len(made.vertices), 1)), rtol=1e-10
        )

    def test_pose_units_and_place_do_not_matter(self):
        points = grain(200)
        plain = mesh_particle(points)
        moved = mesh_particle(posed(points, scale=2e-5, shift=(0.01, -0.02, 0.03)))
        np.testing.assert_allclose(moved.moments, plain.moments, rtol=1e-9)
        np.testing.assert_allclose(moved.half_sizes, plain.half_sizes, rtol=1e-9)
        assert moved.bounding_radius == pytest.approx(plain.bounding_radius, rel=1e-9)
        assert moved.volume == pytest.approx(plain.volume, rel=1e-9)
        assert moved.unit == pytest.approx(2e-5 * plain.unit, rel=1e-9)
        # the corners agree but for half turns about the axes
        flips = np.sign((moved.vertices * plain.vertices).sum(axis=0))
        assert flips.prod() == 1.0
        np.testing.assert_allclose(moved.vertices * flips, plain.vertices, atol=1e-9)

    def test_handedness_is_kept(self):
        points = grain(20)
        plain, mirrored = mesh_particle(points), mesh_particle(points * [1.0, 1.0, -1.0])
        np.testing.assert_allclose(mirrored.moments, plain.moments, rtol=1e-12)
        for made in (plain, mirrored):
            assert np.linalg.det(made.axes) == pytest.approx(1.0, rel=1e-12)
        flips = np.sign((mirrored.vertices * plain.vertices).sum(axis=0))
        assert flips.prod() == -1.0

    def test_file_frame(self):
        points = posed(grain(100), scale=4.0, shift=(5.0, 6.0, 7.0))
        made = mesh_particle(points)
        np.testing.assert_allclose(
            made.vertices @ made.axes * made.unit + made.centre, points, rtol=1e-12
        )
        np.testing.assert_allclose(np.ptp(made.vertices, axis=0)[0], 2.0, rtol=1e-13)
        assert made.bounding_radius == pytest.approx(np.linalg.norm(made.vertices, axis=1).max())

    def test_volume_and_moments_of_a_fine_ellipsoid(self):
        made = mesh_particle(icosphere(4, (2.0, 1.6, 1.0)))
        assert made.volume == pytest.approx(4.0 / 3.0 * np.pi * 0.8 * 0.5, rel=5e-3)
        expected = 0.2 * np.array([0.64 + 0.25, 1.0 + 0.25, 1.0 + 0.64])
        np.testing.assert_allclose(made.moments, expected, rtol=5e-3)

    def test_moments_decide_the_order_of_the_axes(self):
        # spikes make a body longest along an axis about which it has not the least moment
        spiked = np.concatenate([box(0.8, 0.78), [[0.0, 0.0, 1.1], [0.0, 0.0, -1.1]]])
        made = mesh_particle(spiked)
        assert made.moments[0] <= made.moments[1] <= made.moments[2]
        assert made.half_sizes[0] == 1.0
        assert made.half_sizes.max() == pytest.approx(1.1, rel=1e-12)
