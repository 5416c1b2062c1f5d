"""Rough walls in C: the bits of Python, one by one and in batches, and what is refused."""

import numpy as np
import pytest
import toolchain
from sampler.formats.image import write_binary_table
from spin_tables import with_spin_law

import sampler

SEED = 5
N = 700


class Impacts:
    """Impacts at walls of all directions that move: a tenth grazing, some normal, some smooth."""

    def __init__(self, n=N):
        rng = np.random.default_rng(1)
        self.normal, self.wall_velocity = rng.standard_normal((2, n, 3))
        e_y = self.normal / np.linalg.norm(self.normal, axis=1)[:, None]
        velocity = 100.0 * rng.standard_normal((n, 3))
        velocity -= 2.0 * np.maximum((velocity * e_y).sum(axis=1), 0.0)[:, None] * e_y
        velocity[: n // 10] -= 0.99 * ((velocity * e_y).sum(axis=1)[:, None] * e_y)[: n // 10]
        velocity[n // 10 : n // 8] = -100.0 * e_y[n // 10 : n // 8]
        self.velocity = velocity + self.wall_velocity
        self.half_size = rng.uniform(1e-6, 1e-3, n)
        self.omega = 100.0 * rng.standard_normal((n, 3)) / self.half_size[:, None]
        self.roughness = rng.uniform(0.0, 0.5, n)
        self.roughness[::7] = 0.0
        self.index = rng.integers(0, 2**64, n, dtype=np.uint64)
        self.hit = rng.integers(0, 2**32, n, dtype=np.uint32)

    def python(self, table, spins, grain="own"):
        """Velocities and spins after the rebounds."""
        return table.rebound(
            self.velocity,
            self.normal,
            self.half_size,
            omega=self.omega if spins else None,
            grain=grain,
            seed=SEED,
            index=self.index,
            hit=self.hit,
            wall_velocity=self.wall_velocity,
            roughness=self.roughness,
        )

    def batch(self, library, table, spins, v, omega):
        """Code and report of `rbt_rebound_batch`."""
        arrays = (self.velocity, self.normal, self.half_size, self.wall_velocity, self.index)
        pointers = [array.ctypes.data for array in (*arrays, self.hit)]
        pointers += [self.omega.ctypes.data if spins else None, self.roughness.ctypes.data]
        given, report = toolchain.Impacts(*pointers), toolchain.Report()
        n = len(self.hit)
        return library.rbt_rebound_batch(table, n, given, SEED, v, omega, report), report

    def one(self, library, table, spins, k):
        """Code, velocity and spin of one."""
        v, omega = np.full((2, 3), 7.0)
        code = library.rbt_rough_rebound(
            table, self.velocity[k], self.normal[k], self.half_size[k], self.wall_velocity[k],
            self.roughness[k], self.omega[k] if spins else None, SEED, int(self.index[k]),
            int(self.hit[k]), v, omega,
        )  # fmt: skip
        return code, v, omega


@pytest.fixture(scope="module")
def contents(shipped):
    return with_spin_law(shipped.contents)


@pytest.fixture(scope="module")
def file(contents, tmp_path_factory):
    path = tmp_path_factory.mktemp("rough") / "rough.rbt"
    write_binary_table(path, contents)
    return path


@pytest.mark.processor
@pytest.mark.parametrize("spins", [False, True])
@pytest.mark.filterwarnings("ignore::sampler.OutsideTableWarning")
def test_batches_have_the_bits_of_python(library, contents, file, spins):
    table, impacts = sampler.Table(contents), Impacts()
    expected = impacts.python(table, spins)
    v, omega = np.zeros((2, N, 3))
    with toolchain.opened(library, file) as opened:
        code, report = impacts.batch(library, opened, spins, v, omega)
        alone = [impacts.one(library, opened, spins, k) for k in range(0, N, 3)]
    np.testing.assert_array_equal(v, expected.velocity)
    np.testing.assert_array_equal(omega, expected.omega)
    assert (code, report.row) == (1, N)
    assert (report.clamped, report.extrapolated) == (table.clamped, table.extrapolated)
    assert 0 < table.clamped < N
    for k, (code, one_v, one_omega) in zip(range(0, N, 3), alone, strict=True):
        assert code in (0, 1)
        np.testing.assert_array_equal([one_v, one_omega], [v[k], omega[k]])


@pytest.mark.filterwarnings("ignore::sampler.OutsideTableWarning")
def test_bounces_of_a_hit_have_one_grain_also_where_it_is_fresh(library, contents, file):
    impacts = Impacts()
    expected = impacts.python(sampler.Table(contents), spins=True, grain="fresh")
    v, omega = np.zeros((2, N, 3))
    with toolchain.opened(library, file) as opened:
        library.rbt_keep_grains(opened, 0)
        impacts.batch(library, opened, True, v, omega)
    np.testing.assert_array_equal(v, expected.velocity)
    np.testing.assert_array_equal(omega, expected.omega)


def test_results_may_take_the_place_of_arguments(library, file):
    impacts, before = Impacts(), Impacts()
    v, omega = np.zeros((2, N, 3))
    with toolchain.opened(library, file) as opened:
        before.batch(library, opened, True, v, omega)
        impacts.batch(library, opened, True, impacts.velocity, impacts.omega)
    np.testing.assert_array_equal(impacts.velocity, v)
    np.testing.assert_array_equal(impacts.omega, omega)


@pytest.mark.parametrize("bad", [0, 31, 33, 600])
@pytest.mark.parametrize(
    ("name", "value", "code"),
    [
        ("roughness", np.nan, -8),
        ("roughness", -1e-300, -8),
        ("roughness", 0.5000001, -8),
        ("velocity", np.nan, -1),
        ("omega", np.inf, -1),
        ("normal", 0.0, -4),
        ("half_size", 0.0, -5),
    ],
)
def test_a_batch_stops_before_the_first_error(library, file, bad, name, value, code):
    impacts, whole = Impacts(), np.zeros((2, N, 3))
    v, omega = np.full((2, N, 3), 7.0)
    with toolchain.opened(library, file) as opened:
        impacts.batch(library, opened, True, *whole)
        for row in (bad, 650):  # only the first is told
            getattr(impacts, name)[row] = value
        impacts.roughness[bad] = impacts.roughness[bad] if name == "roughness" else 0.1
        got, report = impacts.batch(library, opened, True, v, omega)
        alone, *untouched = impacts.one(library, opened, True, bad)
    assert (got, report.row, alone) == (code, bad, code)
    assert (np.array(untouched) == 7.0).all()
    np.testing.assert_array_equal(v[:bad], whole[0][:bad])
    assert (v[bad:] == 7.0).all()
    assert (omega[bad:] == 7.0).all()


def test_particles_that_do_not_approach_are_refused(library, file):
    impacts = Impacts(20)
    impacts.roughness[:] = 0.1
    impacts.velocity -= impacts.wall_velocity
    impacts.velocity *= -1.0
    impacts.velocity += impacts.wall_velocity
    impacts.velocity[7] = impacts.wall_velocity[7]
    with toolchain.opened(library, file) as opened:
        assert impacts.one(library, opened, False, 3)[0] == -2
        assert impacts.one(library, opened, False, 7)[0] == -3


def test_tilt_of_a_profile(library):
    tilt = np.full(1, 7.0)
    for lengths in ((2e-6, 3e-6, 2e-5, 1e-6), (2e-6, 3e-6, 2e-5, 1.0), (0.0, 0.0, 1.0, 1.0)):
        assert library.rbt_wall_tilt(*lengths, tilt) == 0
        assert tilt[0] == sampler.wall_tilt(*lengths)
    tilt[0] = 7.0
    for lengths, code in {
        (np.nan, 1.0, 9.0, 1.0): -1,
        (1.0, 1.0, 9.0, np.inf): -1,
        (-1.0, 1.0, 9.0, 1.0): -8,
        (1.0, -1.0, 9.0, 1.0): -8,
        (1.0, 1.0, 0.0, 1.0): -8,
        (1.0, 1.0, 9.0, 0.0): -8,
        (25.0, 1.0, 10.0, 5.0): -8,
    }.items():
        assert library.rbt_wall_tilt(*lengths, tilt) == code
    assert tilt[0] == 7.0
