"""The sketch for Fluent, on our declarations, rebounds made-up particles as Python does.

Nothing here says that it runs in Fluent.
"""

import ctypes
import subprocess
from pathlib import Path

import numpy as np
import pytest
import toolchain
from sampler.formats.image import write_binary_table
from spin_tables import with_spin_law

import sampler

HERE = Path(__file__).resolve().parent
FLUENT = toolchain.INCLUDE.parent / "fluent"
SOURCES = [FLUENT / "rebound_bc.c", HERE / "fluent_driver.c"]
STAND_IN = [f"-I{FLUENT}", "-DREBOUND_STAND_IN"]
ACTIVE, ABORT = 0, -1
INERT, DROPLET = 1, 2
SEED, DIAMETER = 7, 40e-6


def particle_type(real):
    """The made-up particle of sampler/fluent/udf.h."""
    fields = [(name, 3 * real) for name in ("position", "velocity", "velocity_before")]
    fields += [(name, real) for name in ("diameter", "density", "time_step")]
    fields += [("user", 6 * real), ("omega", 3 * real)]
    return type(
        "Particle",
        (ctypes.Structure,),
        {"_fields_": [*fields, ("id", ctypes.c_longlong), ("type", ctypes.c_int)]},
    )


class Sketch:
    """The compiled sketch, with its table open."""

    def __init__(self, folder, table, flags=(), real=ctypes.c_double, compiler="gcc"):
        library = folder / "sketch.so"
        table = f'-DREBOUND_TABLE="{table}"'
        arguments = [*STAND_IN, table, *flags, "-fPIC", "-shared", *SOURCES]
        toolchain.compile_with(compiler, [*arguments, toolchain.ONE_COPY, "-lm"], library)
        self.library = ctypes.CDLL(str(library))
        self.library.meet.argtypes = [ctypes.c_void_p, *3 * [ctypes.c_double], ctypes.c_int]
        self.library.fly.argtypes = [ctypes.c_void_p, ctypes.c_int, ctypes.c_double]
        self.library.particle_size.restype = ctypes.c_size_t
        self.type = particle_type(real)
        assert self.library.particle_size() == ctypes.sizeof(self.type)
        self.library.rebound_open(b"libudf")

    def particle(self, identity, velocity, kind=INERT):
        made = self.type(id=identity, type=kind, diameter=DIAMETER)
        made.velocity[:] = made.velocity_before[:] = velocity
        made.user[:] = 6 * [5.0]  # what a scalar held before must not matter
        self.library.fly(ctypes.byref(made), 1, 0.0)
        self.fly(made, 1.0, 0.0)
        return made

    def fly(self, particle, time, viscosity):
        particle.time_step = time
        self.library.fly(ctypes.byref(particle), 0, viscosity)

    def meet(self, particle, outward, dim=3):
        return self.library.meet(ctypes.byref(particle), *outward, dim)


@pytest.fixture(scope="module", params=["gcc", pytest.param("clang", marks=pytest.mark.study)])
def sketch(request, shipped_file, tmp_path_factory):
    return Sketch(tmp_path_factory.mktemp("sketch"), shipped_file, compiler=request.param)


def python_rebound(table, velocity, outward, identity, hit, omega=(0.0, 0.0, 0.0), roughness=None):
    """Rebound of one particle from Python, as the sketch should make it."""
    before = {"omega": omega} if table.contents.has_spin else {}
    keys = {"seed": SEED, "index": [identity], "hit": hit, "roughness": roughness}
    v, omega = table.rebound(velocity, -np.asarray(outward), 0.5 * DIAMETER, **keys, **before)
    return v[0], omega[0]


def spin(particle):
    """Angular velocity that the sketch keeps in the scalars of a particle."""
    return particle.user[3:]


def bounce(sketch, table):
    """Send particles between two walls; how many impacts they count as clamped, as extrapolated."""
    counted = np.zeros(2)
    for identity in [0, 1, 77, 2**40 + 3]:
        velocity, omega = np.array([150.0, -80.0, 20.0]), np.zeros(3)
        particle = sketch.particle(identity, velocity)
        for hit in range(14):
            outward = [0.0, -1.0 if hit % 2 == 0 else 1.0, 0.0]
            expected, omega = python_rebound(table, velocity, outward, identity, hit, omega)
            assert sketch.meet(particle, outward) == ACTIVE
            np.testing.assert_array_equal(particle.velocity, expected)
            np.testing.assert_array_equal(particle.velocity_before, expected)
            np.testing.assert_array_equal(spin(particle), omega)
            assert particle.user[0] == hit + 1
            velocity = expected
        counted += particle.user[1:3]
    return list(counted)


def test_particles_between_two_walls(sketch):
    table = sampler.load("corundum-steel")  # its own, with its own counts
    assert bounce(sketch, table) == [table.clamped, table.extrapolated]
    assert table.clamped > 0


def test_particles_keep_their_spin(shipped, tmp_path):
    table = sampler.Table(with_spin_law(shipped.contents))
    write_binary_table(tmp_path / "spinning.rbt", table.contents)
    assert bounce(Sketch(tmp_path, tmp_path / "spinning.rbt"), table) == [
        table.clamped,
        table.extrapolated,
    ]
    assert table.extrapolated > table.clamped


@pytest.mark.parametrize(
    ("flags", "roughness"),
    [
        (["-DREBOUND_ROUGHNESS=0.2"], 0.2),
        (
            ["-DREBOUND_RSM=5e-5", "-DREBOUND_RA=2e-6", "-DREBOUND_RQ=3e-6"],
            sampler.wall_tilt(2e-6, 3e-6, 5e-5, DIAMETER),
        ),
    ],
)
def test_rough_walls(shipped_file, shipped, flags, roughness, tmp_path):
    sketch = Sketch(tmp_path, shipped_file, flags)
    velocity, outward = [150.0, -40.0, 20.0], [0.0, -1.0, 0.0]
    for identity in range(20):
        particle = sketch.particle(identity, velocity)
        assert sketch.meet(particle, outward) == ACTIVE
        rough = python_rebound(shipped, velocity, outward, identity, 0, roughness=roughness)
        np.testing.assert_array_equal(particle.velocity, rough[0])
        np.testing.assert_array_equal(spin(particle), rough[1])
        smooth, _ = python_rebound(shipped, velocity, outward, identity, 0)
        assert np.abs(smooth - rough[0]).max() > 1e-3


@pytest.mark.parametrize(
    "flags",
    [["-DREBOUND_ROUGHNESS=0.6"], ["-DREBOUND_RSM=1e-6", "-DREBOUND_RA=1", "-DREBOUND_RQ=1"]],
)
def test_a_wall_too_rough_ends_every_track(shipped_file, flags, tmp_path, capfd):
    sketch = Sketch(tmp_path, shipped_file, flags)
    particle = sketch.particle(3, [100.0, -50.0, 0.0])
    assert sketch.meet(particle, [0.0, -1.0, 0.0]) == ABORT
    assert list(particle.velocity) == [100.0, -50.0, 0.0]
    ctypes.CDLL(None).fflush(None)
    assert "particle 3: roughness: allowed: 0 to 0.5 rad" in capfd.readouterr().out


def test_a_particle_that_leaves_is_let_go(sketch):
    particle = sketch.particle(3, [100.0, 50.0, 0.0])
    assert sketch.meet(particle, [0.0, -1.0, 0.0]) == ACTIVE
    assert list(particle.velocity) == [100.0, 50.0, 0.0]
    assert list(particle.user) == 6 * [0.0]


@pytest.mark.parametrize(
    ("velocity", "kind"), [([100.0, -50.0, 0.0], DROPLET), ([100.0, float("nan"), 0.0], INERT)]
)
def test_a_droplet_and_a_bad_velocity_end_the_track(sketch, velocity, kind):
    particle = sketch.particle(3, velocity, kind)
    assert sketch.meet(particle, [0.0, -1.0, 0.0]) == ABORT
    np.testing.assert_array_equal(particle.velocity, velocity)


def test_without_a_table_every_track_ends(tmp_path, capfd):
    sketch = Sketch(tmp_path, tmp_path / "missing.rbt")
    assert sketch.meet(sketch.particle(3, [100.0, -50.0, 0.0]), [0.0, -1.0, 0.0]) == ABORT
    ctypes.CDLL(None).fflush(None)
    assert "missing.rbt: file: cannot be opened" in capfd.readouterr().out
    sketch.library.rebound_close()


def test_plane_and_swirl(shipped_file, shipped, tmp_path):
    sketch = Sketch(tmp_path, shipped_file, ["-DRP_2D=1", "-DREBOUND_SPIN(tp)=((tp)->omega)"])
    # dim = 2: what lies in the third places is nobody's business
    particle = sketch.particle(9, [120.0, -90.0, 33.0])
    assert sketch.meet(particle, [0.0, -1.0, float("nan")], dim=2) == ACTIVE
    expected, omega = python_rebound(shipped, [120.0, -90.0, 0.0], [0.0, -1.0, 0.0], 9, 0)
    np.testing.assert_array_equal(particle.velocity, [*expected[:2], 33.0])
    np.testing.assert_array_equal(particle.omega, omega)

    ctypes.c_int.in_dll(sketch.library, "rp_axi_swirl").value = 1
    velocity, direction = np.array([100.0, 60.0, 80.0]), np.array([0.0, 0.6, 0.8])
    particle = sketch.particle(10, velocity)
    particle.position[:] = [0.3, *(0.05 * direction[1:])]
    assert sketch.meet(particle, [0.0, 1.0, float("nan")], dim=2) == ACTIVE
    expected, _ = python_rebound(shipped, velocity, direction, 10, 0)
    np.testing.assert_allclose(particle.velocity, expected, rtol=0, atol=1e-9)


def test_single_precision(shipped_file, shipped, tmp_path):
    sketch = Sketch(tmp_path, shipped_file, ["-DREBOUND_REAL=float"], real=ctypes.c_float)
    velocity = [120.0, -90.0, 0.0]
    particle = sketch.particle(4, velocity)
    assert sketch.meet(particle, [0.0, -1.0, 0.0]) == ACTIVE
    expected, omega = python_rebound(shipped, velocity, [0.0, -1.0, 0.0], 4, 0)
    np.testing.assert_allclose(particle.velocity, expected, rtol=1e-6, atol=1e-5)
    np.testing.assert_allclose(spin(particle), omega, rtol=1e-5, atol=10.0)


def test_the_gas_slows_the_spin_down(shipped_file, tmp_path):
    sketch = Sketch(tmp_path, shipped_file, ["-DREBOUND_GAS_TORQUE=1.5"])
    particle = sketch.particle(5, [120.0, -90.0, 0.0])
    particle.density = 3950.0
    particle.user[3:] = [3e6, 2e6, -1e6]
    sketch.fly(particle, 2e-3, 1.8e-5)
    kept = np.exp(-1.5 * 60.0 * 1.8e-5 * 2e-3 / (3950.0 * DIAMETER**2))
    assert kept < 0.9
    np.testing.assert_allclose(spin(particle), kept * np.array([3e6, 2e6, -1e6]), rtol=1e-12)
    assert list(particle.user[:3]) == [0.0, 0.0, 0.0]


def test_without_spin_every_impact_is_a_first_one(shipped_file, shipped, tmp_path):
    sketch = Sketch(tmp_path, shipped_file, ["-DREBOUND_KEEP_SPIN=0"])
    particle = sketch.particle(6, [120.0, -90.0, 0.0])
    particle.user[3:] = [3e6, 2e6, -1e6]
    assert sketch.meet(particle, [0.0, -1.0, 0.0]) == ACTIVE
    keys = {"seed": SEED, "index": [6]}
    v, omega = shipped.rebound([120.0, -90.0, 0.0], [0.0, 1.0, 0.0], 0.5 * DIAMETER, **keys)
    np.testing.assert_array_equal(particle.velocity, v[0])
    np.testing.assert_array_equal(spin(particle), omega[0])


def test_the_declarations_refuse_to_be_taken_for_fluents_own(tmp_path):
    command = [toolchain.require("gcc"), f"-I{toolchain.INCLUDE}", "-c", str(SOURCES[0])]
    done = subprocess.run(
        [*command, "-o", str(tmp_path / "x.o")], capture_output=True, text=True, check=False
    )
    assert done.returncode != 0
    assert "copy rebound_bc.c without it" in done.stderr


def test_first_impact_outside_the_table_is_told_once(shipped_file, tmp_path, capfd):
    # its own, which has told nothing yet
    sketch = Sketch(tmp_path, shipped_file, ["-DREBOUND_KEEP_SPIN=0"])
    for identity, speed in enumerate((150.0, 2.0, 3.0)):
        assert (
            sketch.meet(sketch.particle(identity, [0.0, -speed, 0.0]), [0.0, -1.0, 0.0]) == ACTIVE
        )
    ctypes.CDLL(None).fflush(None)
    told = capfd.readouterr().out
    assert told.count("outside the table and took its nearest condition") == 1
    assert told.count("\n") == 1
