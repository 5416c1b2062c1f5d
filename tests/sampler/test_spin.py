"""Draws and rebounds of particles that arrive spinning: every way to them gives the same bits."""

from dataclasses import replace

import numpy as np
import pytest
from reference_draw import key_words, reference_grain, reference_spin_draw
from refusals import refused
from scipy.stats import ks_2samp
from small_tables import works
from spin_tables import energies, less_spheres, with_spin_law
from synthetic_table import make_contents

import sampler
from sampler import InputError, errors
from sampler.formats.bounds import FOLD

# some of the conditions are outside of the law, on purpose
pytestmark = pytest.mark.filterwarnings("ignore::sampler.OutsideTableWarning")

CONTENTS, WITH_WORKS = with_spin_law(make_contents()), with_spin_law(works())
#: A shape that nobody in the population has, and a mesh.
UNUSED = with_spin_law(make_contents(), codes=(0, 3, 6))
UNUSED["spin/shape_weights"][:] = 0.25, 0.0, 0.75
LESS_SPHERES, ROUND_WORKS = less_spheres(CONTENTS), less_spheres(WITH_WORKS)
N = 300
INDEX, HITS = np.arange(N) % 40, np.arange(N) // 40
KEYS = {"seed": 5, "index": INDEX, "hit": HITS}


@pytest.fixture
def table():
    return sampler.Table(CONTENTS)


#: Signs of a state in the mirror of the impact plane.
MIRROR = np.array([1.0, 1.0, -1.0, -1.0, -1.0, 1.0])
MIRRORED = 20_000


def mirror_distance(table, spin, other):
    """Largest Kolmogorov-Smirnov distance of draws and the mirror image of others."""
    index = np.arange(2 * MIRRORED)
    given = np.where(index[:, None] < MIRRORED, spin, other)
    states = table.sample(0.5, 100.0, spin=given, seed=11, index=index, hit=1)
    return ks_2samp(states[:MIRRORED], states[MIRRORED:] * MIRROR).statistic.max()


def conditions(seed=1):
    rng = np.random.default_rng(seed)
    spin = rng.normal(0.0, 0.9, (N, 3))
    spin[::5] = 0.0
    return rng.uniform(0.02, np.pi / 2, N), rng.uniform(20.0, 290.0, N), spin


def lab(seed=2):
    rng = np.random.default_rng(seed)
    normal, velocity = rng.standard_normal((2, N, 3))
    velocity *= -60.0 * np.sign(np.einsum("nk,nk->n", velocity, normal))[:, None]
    return velocity, normal, rng.normal(0.0, 5e6, (N, 3))


class TestSample:
    def test_a_fresh_grain_is_the_own_one_at_hit_0_only(self, table):
        alpha1, speed, spin = conditions()
        states = table.sample(alpha1, speed, spin=spin, **KEYS)
        fresh = table.sample(alpha1, speed, spin=spin, grain="fresh", **KEYS)
        np.testing.assert_array_equal(states[HITS == 0], fresh[HITS == 0])
        assert (states != fresh)[HITS > 0].any()

    def test_own_grain_is_the_one_given(self, table):
        alpha1, speed, spin = conditions()
        grains = table.grains(5, INDEX)
        np.testing.assert_array_equal(
            table.sample(alpha1, speed, spin=spin, grain=grains, **KEYS),
            table.sample(alpha1, speed, spin=spin, **KEYS),
        )
        # a grain, and no spin: a spin of zeros
        np.testing.assert_array_equal(
            table.sample(alpha1, speed, grain=grains, **KEYS),
            table.sample(alpha1, speed, spin=(0.0, 0.0, 0.0), **KEYS),
        )

    @pytest.mark.parametrize("contents", [CONTENTS, LESS_SPHERES])
    def test_mirror_image(self, contents):
        """Equal bits away from the fold, sigma_x = 0, next to which chance chooses the side."""
        table = sampler.Table(contents)
        alpha1, speed, spin = conditions()
        states = table.sample(alpha1, speed, spin=spin, **KEYS)
        mirrored = table.sample(alpha1, speed, spin=spin * MIRROR[3:], **KEYS)
        apart = np.abs(spin[:, 0]) > FOLD * (1.0 + np.sum(spin**2, axis=1)) ** 0.25
        np.testing.assert_array_equal(mirrored[apart], (states * MIRROR)[apart])

    def test_mirror_images_in_law(self):
        """On the fold and within it; a law of one side alone fails, as one just beyond it."""
        table = sampler.load("corundum-steel-compact")
        spins = [(0.0, 1.5, 0.2), (0.0, 3.5, -1.0), (0.0, 0.0, 0.8), (0.04, 1.5, 0.2)]
        distances = [mirror_distance(table, spin, np.array(spin) * MIRROR[3:]) for spin in spins]
        # false-alarm rate 1e-4 of all: Kolmogorov's bound for 24 distances
        bound = np.sqrt(np.log(2.0 * 24 / 1e-4) / MIRRORED)
        assert max(distances) < bound
        assert mirror_distance(table, (0.3, 1.5, 0.2), (0.3, -1.5, 0.2)) > bound

    def test_without_spin_nothing_changes(self, table):
        alpha1, speed, _ = conditions()
        plain = sampler.Table(make_contents(least_inertia=CONTENTS.least_inertia))
        np.testing.assert_array_equal(
            table.sample(alpha1, speed, **KEYS), plain.sample(alpha1, speed, **KEYS)
        )

    def test_moments_are_those_of_draws(self, table):
        spin, index = (0.3, 0.1, -0.8), np.arange(20_000)
        states = table.sample(0.5, 100.0, spin=spin, seed=3, index=index, hit=0)
        mean, std = table.mean(0.5, 100.0, spin=spin), table.std(0.5, 100.0, spin=spin)
        # 4.5 standard errors: false-alarm rate 4e-5
        assert np.all(np.abs(states.mean(axis=0) - mean) < 4.5 * std / np.sqrt(len(index)))
        median = table.quantile(0.5, "v", 0.5, 100.0, spin=[spin, (0.0, 0.0, 0.0)])
        assert abs((states[:, 1] < median[0]).mean() - 0.5) < 4.5 * 0.5 / np.sqrt(len(index))
        assert median.shape == (2,)


class TestSpecification:
    """Against plain Python, from the stored file."""

    @pytest.mark.parametrize("contents", [CONTENTS, UNUSED])
    def test_grains(self, contents):
        table = sampler.Table(contents)
        for index in (0, 1, 2**40, 2**64 - 1, *range(100, 160)):
            expected = reference_grain(contents, 2**63 + 9, index)
            found = table.grains(2**63 + 9, index)
            np.testing.assert_allclose(found, expected, rtol=0, atol=1e-13)

    @pytest.mark.parametrize("contents", [CONTENTS, WITH_WORKS, LESS_SPHERES, ROUND_WORKS, UNUSED])
    def test_states(self, contents):
        """Single precision: to 3e-4, but where a share is next to a border; one in a hundred."""
        alpha1, speed, spin = conditions(seed=4)
        spin[3::10] *= 8.0  # some beyond the law
        states = sampler.Table(contents).sample(alpha1, speed, spin=spin, **KEYS)
        errors = np.empty(N)
        for k in range(N):
            words = key_words(5, int(INDEX[k]), int(HITS[k]))
            grain = reference_grain(contents, 5, int(INDEX[k]))
            given = (contents, alpha1[k], speed[k], spin[k], grain, words)
            errors[k] = np.abs(reference_spin_draw(*given) - states[k]).max()
        factor = np.sqrt(1.0 + 2.0 / 3.0 * (spin**2).sum(axis=1))
        assert (errors > 3e-4 * factor).sum() <= 0.01 * N
        assert np.median(errors) < 1e-4


class TestWorks:
    def test_they_take_at_most_what_is_left(self):
        """Random outcomes ask for more than there is."""
        table, (alpha1, speed, spin) = sampler.Table(WITH_WORKS), conditions()
        states = table.sample(alpha1, speed, spin=spin, **KEYS)
        grains = table.grains(5, INDEX)
        after, before = energies(WITH_WORKS, states[:, :6], spin, grains)
        total = after + states[:, 6:].sum(axis=1)
        assert (states[:, 6:] >= 0.0).all()
        assert (total <= before * (1.0 + 1e-12)).all()
        assert (total > before * (1.0 - 1e-9)).any()
        assert (total < 0.9 * before).any()


class TestRebound:
    @pytest.mark.parametrize(
        ("contents", "spins", "grain"),
        [(WITH_WORKS, 1.0, "own"), (WITH_WORKS, 0.0, "own"), (works(), None, "fresh")],
    )
    def test_is_the_draw_in_the_frame_of_the_wall(self, contents, spins, grain):
        """A wall along the axes of the draw; speeds and works to rounding."""
        table, (alpha1, speed, spin) = sampler.Table(contents), conditions()
        spin = None if spins is None else spins * spin
        speed, lost = speed[:, None], np.full((N, 2), -1.0)
        velocity = speed * np.stack([np.cos(alpha1), -np.sin(alpha1), 0.0 * alpha1], axis=1)
        given = {"omega": None if spin is None else spin * speed / 2e-5, "grain": grain} | KEYS
        after = table.rebound(velocity, (0, 1, 0), 2e-5, works=lost, **given)
        found = after.velocity / speed, after.omega * 2e-5 / speed, lost / (0.5 * speed**2)
        states = table.sample(alpha1, speed[:, 0], spin=spin, **KEYS)
        # a condition that is rounded otherwise may fall into another leaf, or to another expert
        close = np.isclose(np.hstack(found), states, rtol=0, atol=1e-4)
        assert close.all(axis=1).mean() > 0.98
        without = table.rebound(velocity, (0, 1, 0), 2e-5, **given)
        np.testing.assert_array_equal(np.hstack(after), np.hstack(without))
        assert (lost >= 0.0).all()
        assert (lost.max(axis=0) > 0.0).all()

    @pytest.mark.parametrize("roughness", [None, 0.3])
    def test_no_omega_is_a_spin_of_zeros_of_the_own_grain(self, table, roughness):
        velocity, normal, _ = lab()
        given = velocity, normal, 1e-5
        zeros = table.rebound(*given, omega=np.zeros(3), roughness=roughness, **KEYS)
        found = table.rebound(*given, roughness=roughness, **KEYS)
        np.testing.assert_array_equal(np.hstack(found), np.hstack(zeros))

    def test_fresh_and_no_omega_is_a_first_impact(self, table):
        velocity, normal, _ = lab()
        plain = sampler.Table(make_contents(least_inertia=CONTENTS.least_inertia))
        expected = plain.rebound(velocity, normal, 1e-5, grain="fresh", **KEYS)
        found = table.rebound(velocity, normal, 1e-5, grain="fresh", **KEYS)
        np.testing.assert_array_equal(np.hstack(found), np.hstack(expected))
        # on a rough wall, where all facets of a hit meet one grain, it is one of that grain
        how = {"grain": "fresh", "roughness": 0.4, **KEYS}
        rough = table.rebound(velocity, normal, 1e-5, **how)
        at_rest = table.rebound(velocity, normal, 1e-5, omega=np.zeros(3), **how)
        np.testing.assert_array_equal(np.hstack(rough), np.hstack(at_rest))


def wild(seed, contents=CONTENTS):
    """Table with quantiles that no particle has, at the bounds of what is accepted."""
    rng, datasets = np.random.default_rng(seed), dict(contents.datasets)
    shape = datasets["spin/quantiles"].shape
    knots = np.sort(rng.standard_normal(shape) * 10.0 ** rng.uniform(-3, 5, (*shape[:2], 1)))
    knots[:, 1] = np.sort(10.0 ** rng.uniform(-9, 3, (shape[0], shape[2])))
    knots[::2, 1, 0] = 0.0
    nodes = datasets["marginals/quantiles"].astype(np.float64)
    nodes[..., [2, 4, 5], :] *= 10.0 ** rng.uniform(0, 6)
    changed = {"spin/quantiles": knots.astype(np.float32), "marginals/quantiles": nodes}
    return sampler.Table(replace(contents, datasets=datasets | changed, least_inertia=0.05))


class TestEnergy:
    """No draw has more energy than its own grain can have before, whatever the quantiles are."""

    @pytest.mark.parametrize("contents", [CONTENTS, LESS_SPHERES])
    @pytest.mark.parametrize("seed", range(3))
    def test_of_the_spin_law(self, seed, contents):
        table = wild(seed, contents)
        alpha1, speed, spin = conditions(seed)
        spin *= 10.0 ** np.random.default_rng(seed).choice([-3, 0, 1, 3, 60], (N, 1))
        for given in (spin, np.zeros((N, 3))):
            states = table.sample(alpha1, speed, spin=given, **KEYS)
            after, before = energies(CONTENTS, states, given, table.grains(5, INDEX))
            assert (after <= before * (1.0 + 1e-12)).all()
            assert (after > 0.999 * before).any()  # the bound is met
            assert (states[:, 1] > 0.0).all()

    @pytest.mark.parametrize("seed", range(3))
    def test_of_first_impacts(self, seed):
        alpha1, speed, _ = conditions(seed)
        states = wild(seed).sample(alpha1, speed, **KEYS)
        after = (states[:, :3] ** 2).sum(axis=1) + 0.05 * (states[:, 3:] ** 2).sum(axis=1)
        assert (after <= 1.0 + 1e-12).all()
        assert (after > 1.0 - 1e-9).any()


class TestCodes:
    """Of a rebound, written beside it."""

    @pytest.mark.parametrize("outside", ["clamp", "raise"])
    def test_codes_are_of_each_row_and_none_raises(self, outside):
        table = sampler.Table(CONTENTS, outside=outside)
        velocity = np.array([[60.0, -80.0, 0.0]] * 6)
        velocity[[1, 3, 4]] = [60.0, 80.0, 0.0], [400.0, -300.0, 0.0], [30.0, -30.0, 0.0]
        grain, codes = np.array([[1, 0.8, 0.8]] * 6), np.full((6, 2), 99, np.intc)[:, 0]
        grain[5, 1] = 0.4  # not simulated
        given = {"grain": grain, "seed": 1, "index": range(6), "codes": codes}
        after = table.rebound(velocity, (0, 1, 0), [1e-5, 1e-5, 20.0, *[1e-5] * 3], **given)
        expected = [0, errors.NOT_APPROACHING, errors.HALF_SIZE]
        expected += [errors.SPEED | errors.EXTRAPOLATED, errors.SPEED | errors.EXTRAPOLATED]
        assert codes.tolist() == [*expected, errors.GRAIN_NOT_KNOWN]
        drawn = [True, False, False, *[outside == "clamp"] * 2, False]
        for values in after:
            np.testing.assert_array_equal(np.isfinite(values).all(axis=1), drawn)
            np.testing.assert_array_equal(np.isnan(values).all(axis=1), np.logical_not(drawn))
        assert table.counts["speed"] == 2 * (outside == "clamp")
        table.rebound(
            (0, -90, 0), (0, 1, 0), 1e-5, seed=1, index=0, codes=(one := np.array(9, "i4"))
        )
        assert one == 0

    def test_wrong_arrays_are_refused(self, table):
        given = (0, -100, 0), (0, 1, 0), 1e-5
        for name, array in (
            *(("codes", array) for array in (np.zeros(2, np.intc), np.zeros((), np.int64))),
            ("works", [0.0, 0.0]),
        ):
            refused(name, table.rebound, *given, seed=1, index=0, **{name: array})
        with pytest.raises(InputError, match=r"^works: .*the table made-up has no works"):
            table.rebound(*given, seed=1, index=0, works=np.zeros(2))


class TestCounts:
    def test_spins_beyond_the_law_are_counted_and_drawn_with_its_largest(self, table):
        spins = np.array([[0.0, 0.0, 9.9], [0.0, 7.2, 7.2], [14.0, 0.0, 0.0]])
        given = {"spin": spins, "seed": 1, "index": range(3), "hit": 0}
        with pytest.warns(sampler.OutsideTableWarning, match=r"spin: .*, spin 10\.18\d* at row 1"):
            states = table.sample(0.5, 50.0, **given)
        assert table.counts["spin"] == 2
        limits = CONTENTS.datasets | {"spin/spin_range": np.array([0.0, 1e3])}
        wide = sampler.Table(replace(CONTENTS, datasets=limits))
        same = wide.sample(0.5, 50.0, **given) == states
        assert same.all(axis=1).tolist() == [True, False, False]
        assert wide.counts["spin"] == 0

    def test_effective_speeds_beyond_the_law_are_spins_beyond_it(self):
        """Of 600 m/s: at 300 m/s a spin of 4.5^(1/2)."""
        strict, keys = sampler.Table(CONTENTS, outside="raise"), {"seed": 1, "index": 0, "hit": 0}
        strict.sample(0.5, 300.0, spin=(0.0, 0.0, 2.12), **keys)
        line = refused("spin", strict.sample, 0.5, 300.0, spin=(0.0, 0.0, 2.13), **keys)
        assert "at this speed to 2.12132" in line


REFUSED = [
    *(("spin", x, "own") for x in ((0.0, np.nan, 0.0), [[0.0] * 3, [np.inf] * 3], (1e200, 0, 0))),
    *(("spin", x, "own") for x in ((1.0, 2.0), "fast")),
    *(("grain", (0, 0, 0), x) for x in ("none", (2, 0.8, 0.8), (1, 0.4, 0.8), (1, np.nan, 0.8))),
]


@pytest.mark.parametrize(("field", "spin", "grain"), REFUSED)
def test_refused(table, field, spin, grain):
    out = np.full((2, 6), -7.0)
    keys = {"seed": 1, "index": [0, 1], "hit": 0}
    refused(field, table.sample, 0.5, 100.0, spin=spin, grain=grain, out=out, **keys)
    np.testing.assert_array_equal(out, -7.0)


def test_a_spin_needs_hits(table):
    keys, spin = {"seed": 1, "index": 0}, (0, 0, 0)
    refused("hit", table.sample, 0.5, 100.0, spin=spin, **keys)
    refused("hit", table.rebound, (0, -9, 0), (0, 1, 0), 1e-5, omega=spin, **keys)
    table.sample(0.5, 100.0, spin=spin, rng=np.random.default_rng(1))


def test_a_table_without_spin_law_refuses():
    table = sampler.Table(make_contents())
    assert not table.has_spin
    conditions, impact = (0.5, 100.0), ((0, -100, 0), (0, 1, 0), 1e-5)
    for call, given, more in (
        *((table.sample, conditions, more) for more in ({"spin": (0, 0, 0)}, {"grain": (0, 1, 1)})),
        *((table.rebound, impact, more) for more in ({"omega": (0, 0, 0)}, {"grain": (0, 1, 1)})),
        (table.rebound, impact, {"grain": "own"}),
        (table.rebound, impact, {}),
    ):
        field = next(iter(more), "grain")
        with pytest.raises(
            InputError, match=rf"^{field}: is .*, but the table made-up has no spin"
        ):
            call(*given, seed=1, index=0, **more)
    with pytest.raises(InputError, match=r"^grains: this table has no spin law"):
        table.grains(1, 0)
