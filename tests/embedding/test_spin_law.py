"""The spin law in C: the bits of Python, one by one and in batches, in both frames."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import toolchain
from sampler.drawing.spin_draw import spin_draw_batch
from sampler.formats.spin_buffer import law_in
from small_tables import full, plane
from spin_tables import with_spin_law

from sampler.formats.image import table_arrays, write_binary_table
from tablegen.model.random_particles import OWN_GRAIN, draw_grain

VECTORS = Path(__file__).resolve().parents[1] / "vectors"
NO_GRAINS = np.zeros((0, 3))
SEED = np.uint64(5)


class Law:
    """A table with a spin law, in Python and as a file for C."""

    def __init__(self, path, contents):
        self.path, self.arrays = path, table_arrays(contents)
        write_binary_table(path, contents)

    def states(self, alpha1, speed, spin, index, hit, fresh=False):
        """States of Python, all six variables, and what it counts."""
        states, grain_hit = np.zeros((len(hit), 6)), hit if fresh else np.array([OWN_GRAIN])
        arrays = self.arrays._replace(columns=tuple(range(6)))
        keys = SEED, index, hit
        counts = spin_draw_batch(
            arrays, alpha1, speed, spin, NO_GRAINS, grain_hit, *keys, states, 0, len(hit)
        )
        return states, counts


@pytest.fixture(scope="module")
def law(tmp_path_factory):
    """Shapes that draw their ratios, a sphere and a mesh, which do not."""
    contents = with_spin_law(full(), codes=(0, 1, 4, 7))
    return Law(tmp_path_factory.mktemp("law") / "spin.rbt", contents)


def conditions(n, seed=3):
    """Angles and speeds beyond both ends of the law, spins of all sizes, and keys."""
    rng = np.random.default_rng(seed)
    alpha1, speed = rng.uniform(0.005, 0.5 * np.pi, n), np.exp(rng.uniform(1.0, 7.0, n))
    spin = rng.standard_normal((n, 3)) * np.exp(rng.normal(0.0, 1.5, (n, 1)))
    spin[::5] = 0.0
    index = rng.integers(0, 2**64, n, dtype=np.uint64)
    return alpha1, speed, spin, index, rng.integers(0, 2**32, n, dtype=np.uint32)


def drawn(library, table, alpha1, speed, spin, index, hit):
    """Code, states and report of a batch."""
    states, report = np.full((len(hit), 6), 7.0), toolchain.Report()
    given = len(hit), alpha1, speed, spin, int(SEED), index, hit, states, report
    return library.rbt_draw_batch(table, *given), states, report


@pytest.mark.processor
@pytest.mark.parametrize("fresh", [False, True])
@pytest.mark.parametrize("n", [1, 31, 33, 2000])
def test_batches_have_the_bits_of_python(library, law, n, fresh):
    given = conditions(n)
    expected, (row, _, first, clamped, extrapolated) = law.states(*given, fresh=fresh)
    with toolchain.opened(library, law.path) as table:
        library.rbt_keep_grains(table, not fresh)
        code, states, report = drawn(library, table, *given)
    np.testing.assert_array_equal(states, expected)
    assert (code, report.row, row) == (clamped > 0, n, -1)
    assert (report.clamped, report.extrapolated) == (clamped, extrapolated)
    assert report.clamped_row == (first if clamped else n)
    assert n < 2000 or (0 < clamped < n and 0 < extrapolated < n)


@pytest.mark.processor
def test_one_by_one(library, law):
    alpha1, speed, spin, index, hit = given = conditions(200)
    expected, _ = law.states(*given)
    with toolchain.opened(library, law.path) as table:
        for k, row in enumerate(expected):
            state = np.zeros(6)
            keys = int(SEED), int(index[k]), int(hit[k])
            code = library.rbt_draw(table, alpha1[k], speed[k], spin[k], *keys, state)
            assert code in (0, 1)
            np.testing.assert_array_equal(state, row)


def test_grains_are_those_of_python_and_kept_unless_told_otherwise(library, law):
    found, expected, grains = (
        np.zeros((300, 2, 3)),
        np.zeros((300, 3)),
        law_in(law.arrays).grains,
    )
    with toolchain.opened(library, law.path) as table:
        for kept in (0, 1):
            library.rbt_keep_grains(table, kept)
            for k in range(300):
                assert library.rbt_grain(table, int(SEED), k, k % 3, found[k, kept]) == 0
    for k in range(300):
        expected[k] = draw_grain(grains, SEED, np.uint64(k), OWN_GRAIN)
        fresh = draw_grain(grains, SEED, np.uint64(k), np.uint32(k % 3))
        np.testing.assert_array_equal(found[k, 0], fresh)
    # the same bits from the same C library, whose logarithm is called
    np.testing.assert_array_equal(found[:, 1], expected)
    assert set(expected[:, 0]) == {0.0, 1.0, 4.0, 7.0}


def test_ratios_beyond_all_that_was_simulated_are_moved_to_its_ends(library, tmp_path):
    contents = with_spin_law(full(), codes=(0, 1, 3))
    beyond = np.array([[0.5, 9.0, 0.0, 1.0], [-0.7, 1.3, 0.0, 1.0]])
    contents = replace(contents, datasets={**contents.datasets, "spin/aspect": beyond})
    wide, given = Law(tmp_path / "wide.rbt", contents), conditions(300)
    grains, found = np.zeros((2, 300, 3))
    with toolchain.opened(library, wide.path) as table:
        for k in range(300):
            grains[k] = draw_grain(law_in(wide.arrays).grains, SEED, np.uint64(k), OWN_GRAIN)
            library.rbt_grain(table, int(SEED), k, 0, found[k])
        np.testing.assert_array_equal(drawn(library, table, *given)[1], wide.states(*given)[0])
    np.testing.assert_array_equal(found, grains)
    assert grains[:, 1:].min() == 0.001
    assert grains[:, 1:].max() == 1.0
    assert len(set(grains[:, 1])) > 10


def test_every_draw_leaves_the_wall_below_the_effective_speed(library, law):
    given = conditions(3000, seed=8)
    spin = given[2]
    spin[:500] *= 1e3
    with toolchain.opened(library, law.path) as table:
        _, states, _ = drawn(library, table, *given)
    effective = np.sqrt(1.0 + 2.0 / 3.0 * (spin**2).sum(axis=1))
    assert np.isfinite(states).all()
    assert (states[:, 1] > 0.0).all()
    assert (np.linalg.norm(states[:, :3], axis=1) <= effective * (1.0 + 1e-12)).all()


def test_variables_that_the_table_leaves_out_are_zero(library, law, tmp_path):
    narrow = Law(tmp_path / "plane.rbt", with_spin_law(plane(), codes=(0, 1, 4, 7)))
    given = conditions(100)
    whole, _ = law.states(*given)
    with toolchain.opened(library, narrow.path) as table:
        _, states, _ = drawn(library, table, *given)
    held = [0, 1, 5]
    np.testing.assert_array_equal(states[:, held], whole[:, held])
    assert not states[:, [2, 3, 4]].any()


@pytest.mark.parametrize("bad", [0, 1, 31, 32, 50])
@pytest.mark.parametrize(
    ("place", "value", "code"),
    [
        (("spin", 1), np.nan, -1),
        (("spin", 2), np.inf, -1),
        (("spin", 0), 1e200, -1),
        (("alpha1", None), np.nan, -1),
        (("alpha1", None), -1.0, -2),
        (("speed", None), 0.0, -3),
    ],
)
def test_a_batch_stops_before_the_first_error(library, law, bad, place, value, code):
    alpha1, speed, spin, index, hit = conditions(70)
    with toolchain.opened(library, law.path) as table:
        _, whole, _ = drawn(library, table, alpha1, speed, spin, index, hit)
        for row in (bad, 60):  # only the first is told
            if place[0] == "spin":
                spin[row, place[1]] = value
            else:
                {"alpha1": alpha1, "speed": speed}[place[0]][row] = value
        got, states, report = drawn(library, table, alpha1, speed, spin, index, hit)
        state = np.full(6, 7.0)
        keys = int(SEED), int(index[bad]), int(hit[bad])
        assert library.rbt_draw(table, alpha1[bad], speed[bad], spin[bad], *keys, state) == code
        assert (state == 7.0).all()
    assert (got, report.row) == (code, bad)
    before = speed[:bad]
    assert report.extrapolated == ((before < 50.0) | (before > 300.0)).sum()
    np.testing.assert_array_equal(states[:bad], whole[:bad])
    assert (states[bad:] == 7.0).all()


def test_a_table_without_a_spin_law_refuses_a_spin(library, law):
    alpha1, speed, spin, index, hit = conditions(40)
    grain, state = np.full(3, 7.0), np.full(6, 7.0)
    with toolchain.opened(library, VECTORS / "full.rbt") as table:
        assert library.rbt_has_spin_law(table) == 0
        code, states, report = drawn(library, table, alpha1, speed, spin, index, hit)
        assert (code, report.row) == (-9, 0)
        assert (states == 7.0).all()
        assert library.rbt_draw(table, 0.5, 100.0, np.zeros(3), 1, 2, 3, state) == -9
        assert library.rbt_draw(table, 0.5, 0.0, np.zeros(3), 1, 2, 3, state) == -3
        assert library.rbt_grain(table, 1, 2, 3, grain) == -9
        assert drawn(library, table, *(a[:0] for a in (alpha1, speed, spin, index, hit)))[0] == 0
    assert (state == 7.0).all()
    assert (grain == 7.0).all()


def test_queries(library, law):
    speeds = np.zeros(2)
    with toolchain.opened(library, law.path) as table:
        assert library.rbt_has_spin_law(table) == 1
        library.rbt_valid_speed(table, speeds)
    assert speeds.tolist() == [50.0, 300.0]


def test_a_file_of_version_1_0_gives_the_states_that_it_gave(library):
    old = VECTORS.parent / "data" / "full-1.0.rbt"
    alpha1, speed, index, hit = toolchain.random_conditions(500)
    found, speeds = [], np.zeros(2)
    for path in (old, VECTORS / "full.rbt"):
        with toolchain.opened(library, path) as table:
            found.append(drawn(library, table, alpha1, speed, None, index, hit))
            library.rbt_valid_speed(table, speeds)
            assert speeds.tolist() == [1e-300, 1e300]
            assert library.rbt_has_spin_law(table) == 0
    np.testing.assert_array_equal(found[0][1], found[1][1])
    assert [f[2].extrapolated for f in found] == [0, 0]
    assert old.read_bytes()[10:12] == b"\0\0"


def frames(velocity, normal, wall_velocity):
    """Axes x, y, z of each impact as rows, from the definition of the frame."""
    e_y = normal / np.linalg.norm(normal, axis=1)[:, None]
    relative = velocity - wall_velocity
    along = relative - (relative * e_y).sum(axis=1)[:, None] * e_y
    e_x = along / np.linalg.norm(along, axis=1)[:, None]
    return np.stack([e_x, e_y, np.cross(e_x, e_y)], axis=1)


class Impacts:
    """Oblique impacts of spinning particles at walls of all directions that move."""

    def __init__(self, n, seed=2):
        rng = np.random.default_rng(seed)
        alpha1, self.speed, spin, self.index, self.hit = conditions(n, seed)
        self.alpha1 = np.clip(alpha1, 0.01, 1.5)
        self.normal, self.wall_velocity = rng.standard_normal((2, n, 3))
        e_y = self.normal / np.linalg.norm(self.normal, axis=1)[:, None]
        along = np.cross(e_y, rng.standard_normal((n, 3)))
        along /= np.linalg.norm(along, axis=1)[:, None]
        in_plane = np.cos(self.alpha1)[:, None] * along - np.sin(self.alpha1)[:, None] * e_y
        self.velocity = self.wall_velocity + self.speed[:, None] * in_plane
        self.half_size = rng.uniform(1e-6, 1e-3, n)
        self.axes = frames(self.velocity, self.normal, self.wall_velocity)
        self.rate = self.speed / self.half_size
        self.spin, self.omega = spin, self.rate[:, None] * np.einsum("nk,nkj->nj", spin, self.axes)

    def lab(self, states):
        """Velocities and angular velocities of states in the lab frame."""
        v = self.speed[:, None] * np.einsum("nk,nkj->nj", states[:, :3], self.axes)
        turning = self.rate[:, None] * np.einsum("nk,nkj->nj", states[:, 3:], self.axes)
        return v + self.wall_velocity, turning

    def batch(self, library, table, omega, v, out):
        """Code and report of `rbt_rebound_batch`."""
        given = [self.velocity, self.normal, self.half_size, self.wall_velocity, self.index]
        pointers = [array.ctypes.data for array in (*given, self.hit, omega)]
        impacts, report = toolchain.Impacts(*pointers), toolchain.Report()
        n = len(self.hit)
        return library.rbt_rebound_batch(table, n, impacts, int(SEED), v, out, report), report


@pytest.mark.parametrize("n", [1, 33, 400])
def test_rebounds_of_spinning_particles(library, law, n):
    """Angular velocities are turned into the frame of the impact and back: an independent truth."""
    impacts = Impacts(n)
    v, omega = np.zeros((2, n, 3))
    with toolchain.opened(library, law.path) as table:
        given = impacts.alpha1, impacts.speed, impacts.spin, impacts.index, impacts.hit
        _, states, told = drawn(library, table, *given)
        code, report = impacts.batch(library, table, impacts.omega, v, omega)
        assert (code, report.row, report.clamped) == (told.clamped > 0, n, told.clamped)
        assert report.extrapolated == told.extrapolated
        for k in range(n):
            alone = np.zeros((2, 3))
            library.rbt_rebound(
                table, impacts.velocity[k], impacts.normal[k], impacts.half_size[k],
                impacts.wall_velocity[k], impacts.omega[k], int(SEED), int(impacts.index[k]),
                int(impacts.hit[k]), *alone,
            )  # fmt: skip
            np.testing.assert_array_equal(alone, [v[k], omega[k]])
        in_place = impacts.omega.copy()
        impacts.batch(library, table, in_place, np.zeros_like(v), in_place)
        np.testing.assert_array_equal(in_place, omega)
    expected = impacts.lab(states)
    # a last digit of the spin may turn the last digits of a state, in single precision
    scale = impacts.speed[:, None] * np.sqrt(1.0 + (impacts.spin**2).sum(axis=1))[:, None]
    assert (np.abs(v - expected[0]) < 2e-5 * scale).mean() > 0.99
    close = np.abs(omega - expected[1]) < 2e-5 * scale / impacts.half_size[:, None]
    assert close.mean() > 0.99


def test_an_angular_velocity_that_is_no_number_ends_a_batch(library, law):
    impacts = Impacts(50)
    impacts.omega[40, 1] = np.nan
    v, omega = np.full((2, 50, 3), 7.0)
    with toolchain.opened(library, law.path) as table:
        code, report = impacts.batch(library, table, impacts.omega, v, omega)
    assert (code, report.row) == (-1, 40)
    assert (v[40:] == 7.0).all()
    assert (v[:40] != 7.0).all()
