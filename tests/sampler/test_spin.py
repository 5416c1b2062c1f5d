"""Draws and rebounds of particles that arrive spinning: every way to them gives the same bits."""

from dataclasses import replace

import numpy as np
import pytest
from reference_draw import (
    key_words,
    reference_grain,
    reference_inertia,
    reference_kappa,
    reference_spin_draw,
)
from refusals import refused
from scipy.stats import ks_2samp
from small_tables import works
from spin_tables import LAWS, energy, moments, with_spin_law
from synthetic_table import make_contents

import sampler
from sampler import InputError, errors
from sampler.formats.bounds import FOLD, SPIN_CORE, TILT_CORE

# some of the conditions are outside of the law, on purpose
pytestmark = pytest.mark.filterwarnings("ignore::sampler.OutsideTableWarning")

CONTENTS, WITH_WORKS = with_spin_law(make_contents()), with_spin_law(works())
#: Ellipsoids without spin count from a sphere.
BY_SPHERE = with_spin_law(works(), laws=LAWS)
#: A shape that nobody in the population has, and a mesh.
UNUSED = with_spin_law(make_contents(), codes=(0, 3, 64))
UNUSED["spin/shape_weights"][:] = 0.25, 0.0, 0.75
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


def inertias(contents):
    """Inertias that the own grains can have, some at an end, and some that are not known."""
    least, most = moments(contents, sampler.Table(contents).grains(5, INDEX))
    kappa = np.random.default_rng(1).uniform(0.0, 1.0, least.size)
    kappa[::7], kappa[1::7] = 0.0, 1.0
    inertia = [reference_inertia(*one) for one in zip(kappa, least, most, strict=True)]
    return np.array(inertia) * (np.arange(least.size) % 4 > 0)


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

    def test_an_own_grain_without_spin_arrives_at_rest(self, table):
        """As in a rebound; by default, and with fresh grains, the law is that of first impacts."""
        alpha1, speed, _ = conditions()
        resting = table.sample(alpha1, speed, spin=(0.0, 0.0, 0.0), **KEYS)
        np.testing.assert_array_equal(table.sample(alpha1, speed, grain="own", **KEYS), resting)
        first = table.sample(alpha1, speed, **KEYS)
        np.testing.assert_array_equal(table.sample(alpha1, speed, grain="fresh", **KEYS), first)
        assert (first != resting).any()

    def test_mirror_image(self, table):
        """Equal bits away from the fold, sigma_x = 0, next to which chance chooses the side."""
        alpha1, speed, spin = conditions()
        spin[::3] *= 1e-3
        after, before = np.empty((2, N)), inertias(CONTENTS)
        states = table.sample(
            alpha1, speed, spin=spin, inertia=before, inertia_after=after[0], **KEYS
        )
        mirrored = table.sample(
            alpha1,
            speed,
            spin=spin * MIRROR[3:],
            inertia=before,
            inertia_after=after[1],
            **KEYS,
        )
        size = np.linalg.norm(spin, axis=1) + 1e-300
        sigma_x = np.abs(spin[:, 0]) * (SPIN_CORE / size + (1.0 + size**2) ** -0.25)
        apart = sigma_x / np.sqrt(sigma_x + TILT_CORE) > FOLD
        np.testing.assert_array_equal(mirrored[apart], (states * MIRROR)[apart])
        np.testing.assert_array_equal(after[0][apart], after[1][apart])
        assert apart[::3].any()

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
            grain = table.grains(2**63 + 9, index)
            np.testing.assert_allclose(grain, expected, rtol=0, atol=1e-13)

    @pytest.mark.parametrize("contents", [CONTENTS, WITH_WORKS, BY_SPHERE, UNUSED])
    def test_states(self, contents):
        """Single precision: to 3e-4, but where a share is next to a border; one in a hundred."""
        alpha1, speed, spin = conditions(seed=4)
        spin[3::10] *= 8.0  # some beyond the law
        spin[6::10] *= 1e-3
        inertia, after = np.random.default_rng(1).uniform(0.02, 0.6, N), np.empty(N)
        inertia[::4] = 0.0
        given = {"spin": spin, "inertia": inertia, "inertia_after": after}
        states = sampler.Table(contents).sample(alpha1, speed, **given, **KEYS)
        errors = np.empty(N)
        for k in range(N):
            words = key_words(5, int(INDEX[k]), int(HITS[k]))
            grain = reference_grain(contents, 5, int(INDEX[k]))
            given = (contents, alpha1[k], speed[k], spin[k], inertia[k], grain, words)
            errors[k] = np.abs(reference_spin_draw(*given) - [*states[k], after[k]]).max()
        assert (errors > 1e-3).sum() <= 0.01 * N
        assert np.median(errors) < 1e-4

    def test_laws_of_contact_are_those_of_ellipsoids_without_spin_alone(self):
        alpha1, speed, spin = conditions(seed=4)
        plain, by_sphere = (
            sampler.Table(one).sample(alpha1, speed, spin=spin, **KEYS)
            for one in (WITH_WORKS, BY_SPHERE)
        )
        ellipsoid = sampler.Table(BY_SPHERE).grains(5, INDEX)[:, 0] == 0
        counts = ellipsoid & ~spin.any(axis=1)
        np.testing.assert_array_equal((plain != by_sphere).any(axis=1), counts)
        assert counts.sum() > 10


class TestInertia:
    def test_of_rebounds_lies_within_the_moments_of_the_grain(self, table):
        alpha1, speed, spin = conditions()
        after = np.empty(N)
        table.sample(alpha1, speed, spin=spin, inertia_after=after, **KEYS)
        least, most = moments(CONTENTS, table.grains(5, INDEX))
        assert ((after >= least) & (after <= most)).all()
        for end in (least, most):  # large outcomes
            assert np.isclose(after, end, rtol=1e-9, atol=0).any()
        table.sample(alpha1, speed, inertia_after=after, **KEYS)
        assert not after.any()

    def test_one_that_is_not_known_is_drawn_by_the_keys(self, table):
        """From the quantiles of the shape, with word 11; of any spin, and only then."""
        alpha1, speed, spin = conditions()
        grains, drawn = table.grains(5, INDEX), np.empty(N)
        for k in range(N):
            ends = [float(end[k]) for end in moments(CONTENTS, grains)]
            row = list(CONTENTS["spin/shape_codes"]).index(grains[k, 0])
            u = (key_words(5, int(INDEX[k]), int(HITS[k]))[11] + 0.5) / 2**32
            quantiles = CONTENTS["spin/kappa_quantiles"][row]
            kappa = np.interp(u, np.linspace(0.0, 1.0, 33), quantiles)
            drawn[k] = reference_inertia(kappa, *ends)
            assert abs(reference_kappa(drawn[k], *ends) - kappa) < 1e-9
        states = table.sample(alpha1, speed, spin=spin, **KEYS)
        given = table.sample(alpha1, speed, spin=spin, inertia=drawn, **KEYS)
        # a feature that is rounded otherwise may choose another expert
        assert np.isclose(given, states, rtol=0, atol=1e-4).all(axis=1).mean() > 0.99
        other = table.sample(alpha1, speed, spin=spin, inertia=0.9 * drawn + 0.03, **KEYS)
        np.testing.assert_array_equal(other[::5], states[::5])  # without a spin
        assert not np.isclose(other, states, rtol=0, atol=1e-4).all(axis=1)[1:5].any()

    def test_beyond_the_moments_the_nearest_is_drawn_and_flagged(self, table):
        """But for rounding to single precision."""
        grain = np.array([1.0, 0.8, 0.8])
        least, most = (float(end[0]) for end in moments(CONTENTS, grain[None]))
        given = {"spin": (0.1, 0.2, 0.3), "grain": grain, "seed": 1, "index": 0, "hit": 0}

        def states(inertia):
            return table.sample(0.5, 100.0, inertia=inertia, **given)

        for end, beyond in ((least, 0.5), (most, 2.0)):
            np.testing.assert_array_equal(states(end * beyond), states(end))
        assert table.counts["spin"] == 2
        states(np.array([least, most], np.float32).astype(float)[1])
        states(float(np.float32(least)))
        assert table.counts["spin"] == 2
        strict = sampler.Table(CONTENTS, outside="raise")
        line = refused("inertia", strict.sample, 0.5, 100.0, inertia=0.9, **given)
        assert "inertia: got 0.9 at row 0" in line

    def test_of_a_sphere(self):
        """All moments are equal."""
        table = sampler.Table(with_spin_law(make_contents(), codes=(4,)))
        alpha1, speed, spin = conditions()
        after, keys = np.empty(N), KEYS | {"grain": (4.0, 1.0, 1.0)}
        known = table.sample(alpha1, speed, spin=spin, inertia=0.4, inertia_after=after, **keys)
        np.testing.assert_array_equal(after, 0.4)
        np.testing.assert_array_equal(table.sample(alpha1, speed, spin=spin, **keys), known)
        assert table.counts["spin"] == 0


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
        given |= {"inertia": None if spin is None else inertias(contents)}
        after = table.rebound(velocity, (0, 1, 0), 2e-5, works=lost, **given)
        inertia = np.empty(N)
        spinning = {"spin": spin, "inertia": given["inertia"], "inertia_after": inertia}
        states = table.sample(alpha1, speed[:, 0], **spinning, **KEYS)
        # a condition that is rounded otherwise may fall into another leaf, or to another expert
        works_after = lost / (0.5 * speed**2)
        parts = after.velocity / speed, after.omega * 2e-5 / speed, works_after, after.inertia
        rebounds = np.column_stack(parts)
        close = np.isclose(rebounds, np.column_stack([states, inertia]), rtol=0, atol=1e-4)
        assert close.all(axis=1).mean() > 0.98
        without = table.rebound(velocity, (0, 1, 0), 2e-5, **given)
        np.testing.assert_array_equal(np.column_stack(after), np.column_stack(without))
        assert (lost >= 0.0).all()
        assert (lost.max(axis=0) > 0.0).all()

    @pytest.mark.parametrize("roughness", [None, 0.3])
    def test_no_omega_is_a_spin_of_zeros_of_the_own_grain(self, table, roughness):
        velocity, normal, _ = lab()
        given = velocity, normal, 1e-5
        zeros = table.rebound(*given, omega=np.zeros(3), roughness=roughness, **KEYS)
        at_rest = table.rebound(*given, roughness=roughness, **KEYS)
        np.testing.assert_array_equal(np.column_stack(at_rest), np.column_stack(zeros))

    def test_fresh_and_no_omega_is_a_first_impact(self, table):
        velocity, normal, _ = lab()
        plain = sampler.Table(make_contents(least_inertia=CONTENTS.least_inertia))
        expected = plain.rebound(velocity, normal, 1e-5, grain="fresh", **KEYS)
        first = table.rebound(velocity, normal, 1e-5, grain="fresh", **KEYS)
        np.testing.assert_array_equal(np.column_stack(first), np.column_stack(expected))
        assert not first.inertia.any()
        # on a rough wall, where all facets of a hit meet one grain, it is one of that grain
        facets = {"grain": "fresh", "roughness": 0.4, **KEYS}
        rough = table.rebound(velocity, normal, 1e-5, **facets)
        at_rest = table.rebound(velocity, normal, 1e-5, omega=np.zeros(3), **facets)
        np.testing.assert_array_equal(np.column_stack(rough), np.column_stack(at_rest))


def wild_contents(seed, contents=CONTENTS):
    """Contents with quantiles that no particle has, at the bounds of what is accepted."""
    rng, datasets = np.random.default_rng(seed), dict(contents.datasets)
    shape = datasets["spin/quantiles"].shape
    knots = np.sort(rng.standard_normal(shape) * 10.0 ** rng.uniform(-3, 5, (*shape[:2], 1)))
    knots[:, 1] = np.sort(10.0 ** rng.uniform(-9, 3, (shape[0], shape[2])))
    knots[::2, 1, 0] = 0.0
    nodes = datasets["marginals/quantiles"].astype(np.float64)
    nodes[..., [2, 4, 5], :] *= 10.0 ** rng.uniform(0, 6)
    changed = {"spin/quantiles": knots.astype(np.float32), "marginals/quantiles": nodes}
    return replace(contents, datasets=datasets | changed, least_inertia=0.05)


#: Draws of a test of energy; `pytest -m study` makes 10**7 in all.
MANY = 20_000


def extreme(n, seed):
    """Angles, speeds, spins of all sizes, and fractions of the way between two moments."""
    rng = np.random.default_rng(seed)
    spin = rng.standard_normal((n, 3)) * 10.0 ** rng.uniform(-6.0, 1.0, (n, 1)) * 2.0
    spin[::9], spin[1::9, :2], spin[2::9] = 0.0, 0.0, 1e-170 * spin[2::9]
    spin *= np.minimum(1.0, 10.0 / np.maximum(np.linalg.norm(spin, axis=1), 1e-300))[:, None]
    kappa = rng.uniform(0.0, 1.0, n)
    kappa[::5], kappa[1::5] = 0.0, 1.0
    alpha1 = np.minimum(10.0 ** rng.uniform(-4, 0.3, n), np.pi / 2)
    return alpha1, 10.0 ** rng.uniform(-3, 5, n), spin, kappa


class TestEnergy:
    """Energy before is energy after and works, to rounding, whatever the quantiles are."""

    @pytest.mark.parametrize("wild_ones", [False, True])
    def test_adds_up(self, wild_ones):
        check_energy(wild_contents(1, WITH_WORKS) if wild_ones else WITH_WORKS, MANY, 7)

    @pytest.mark.study(reason="10**7 draws")
    def test_adds_up_in_many_draws(self):
        check_energy(WITH_WORKS, 5 * 10**6, 8)

    @pytest.mark.parametrize("seed", range(3))
    def test_is_never_gained(self, seed):
        """Without works, and of inertias that are not known, for which the largest bounds it."""
        table = sampler.Table(wild_contents(seed))
        alpha1, speed, spin, _ = extreme(MANY, seed)
        index, after = np.arange(MANY), np.empty(MANY)
        _, most = moments(CONTENTS, table.grains(5, index))
        keys = {"seed": 5, "index": index, "hit": 1}
        states = table.sample(alpha1, speed, spin=spin, inertia_after=after, **keys)
        total = energy(states[:, :3], states[:, 3:], after)
        assert (total <= (1.0 + most * (spin**2).sum(axis=1)) * (1.0 + 1e-13)).all()
        assert (states[:, 1] > 0.0).all()

    def test_is_never_gained_in_a_cascade(self):
        """Nor with the works of all bounces; inertias go from one to the next."""
        table, (velocity, normal, omega) = sampler.Table(WITH_WORKS), lab()
        k, works = inertias(WITH_WORKS), np.empty((N, 2))
        given = {"roughness": 0.5, "isotropic": True, "omega": omega, "works": works}
        after = table.rebound(velocity, normal, 1e-6, inertia=k, **given, **KEYS)
        _, most = moments(WITH_WORKS, table.grains(5, INDEX))
        before = energy(velocity, 1e-6 * omega, np.where(k > 0.0, k, most))
        total = energy(after.velocity, 1e-6 * after.omega, after.inertia)
        total += 2.0 * works.sum(axis=1)
        assert (total <= before * (1.0 + 1e-12)).all()
        np.testing.assert_allclose(total[k > 0.0], before[k > 0.0], rtol=1e-12)

    @pytest.mark.parametrize("seed", range(3))
    def test_of_first_impacts(self, seed):
        alpha1, speed, _ = conditions(seed)
        states = sampler.Table(wild_contents(seed)).sample(alpha1, speed, **KEYS)
        after = (states[:, :3] ** 2).sum(axis=1) + 0.05 * (states[:, 3:] ** 2).sum(axis=1)
        assert (after <= 1.0 + 1e-12).all()
        assert (after > 1.0 - 1e-9).any()


def check_energy(contents, n, seed):
    table = sampler.Table(contents)
    alpha1, speed, spin, kappa = extreme(n, seed)
    index, after = np.arange(n), np.empty(n)
    least, most = moments(contents, table.grains(5, index))
    inertia = most * least / (most - kappa * (most - least))
    keys = {"seed": 5, "index": index, "hit": 1}
    states = table.sample(alpha1, speed, spin=spin, inertia=inertia, inertia_after=after, **keys)
    works = states[:, 6:]
    total = energy(states[:, :3], states[:, 3:6], after) + works.sum(axis=1)
    np.testing.assert_allclose(total, energy(np.ones((n, 1)), spin, inertia), rtol=2e-15 * 4)
    assert (works >= 0.0).all()
    assert (states[:, 1] > 0.0).all()
    assert (after >= least).all()
    assert (after <= most).all()


class TestCodes:
    """Of a rebound, written beside it."""

    def test_speeds_of_the_law_below_those_of_first_impacts_are_extrapolated_only(self):
        """Grains of a pair that was measured at 50 m/s and more meet the next wall at 20 m/s."""
        slow = CONTENTS["spin/speed_range"] * [0.2, 1.0]
        contents = replace(CONTENTS, datasets=CONTENTS.datasets | {"spin/speed_range": slow})
        velocity, codes = np.outer([20.0, 30.0, 5.0], [0.6, -0.8, 0.0]), np.zeros(3, np.intc)
        given = {"grain": [[1, 0.8, 0.8]] * 3, "seed": 1, "index": [0, 0, 0], "codes": codes}
        after = sampler.Table(contents, outside="clamp").rebound(velocity, (0, 1, 0), 1e-5, **given)
        far = errors.EXTRAPOLATED
        assert codes.tolist() == [far, far, far | errors.SPEED]
        # draws are those of their own speeds, and not of the nearest speed of first impacts
        assert not np.allclose(after[0][0] / 20.0, after[0][1] / 30.0)

    @pytest.mark.parametrize("outside", ["clamp", "raise"])
    def test_codes_are_of_each_row_and_none_raises(self, outside):
        table = sampler.Table(CONTENTS, outside=outside)
        velocity = np.array([[60.0, -80.0, 0.0]] * 6)
        velocity[[1, 3, 4]] = [60.0, 80.0, 0.0], [400.0, -300.0, 0.0], [30.0, -30.0, 0.0]
        grain, codes = np.array([[1, 0.8, 0.8]] * 6), np.full((6, 2), 99, np.intc)[:, 0]
        grain[5, 1] = 0.4  # not simulated
        given = {"grain": grain, "seed": 1, "index": range(6), "codes": codes}
        after = table.rebound(velocity, (0, 1, 0), [1e-5, 1e-5, 200.0, *[1e-5] * 3], **given)
        expected = [0, errors.NOT_APPROACHING, errors.HALF_SIZE]
        expected += [errors.SPEED | errors.EXTRAPOLATED, errors.SPEED | errors.EXTRAPOLATED]
        assert codes.tolist() == [*expected, errors.GRAIN_NOT_KNOWN]
        drawn = np.array([True, False, False, *[outside == "clamp"] * 2, False])
        kept = np.arange(6) == 1
        for values in after:
            values = values.reshape(6, -1)
            np.testing.assert_array_equal(np.isfinite(values).all(axis=1), drawn | kept)
            np.testing.assert_array_equal(np.isnan(values).all(axis=1), ~(drawn | kept))
        np.testing.assert_array_equal(after.velocity[1], velocity[1])
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
        with pytest.raises(InputError, match=r"^works: .*the table made-up does not store works"):
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

    def test_the_speed_counts_with_the_energy_of_rotation(self):
        """The law goes to 600 m/s: at 250 m/s and k = 0.3 to a spin of (4.76 / 0.3)^(1/2) = 3.9833.

        The speed that is compared with the measured ones has this energy, too.
        """
        contents = replace(CONTENTS, valid_speed=(200.0, 600.0))
        strict, keys = sampler.Table(contents, outside="raise"), {"seed": 1, "index": 0, "hit": 0}
        given = {"inertia": 0.3, "grain": (0.0, 0.8, 0.8)} | keys
        strict.sample(0.5, 250.0, spin=(0.0, 0.0, 3.983), **given)
        line = refused("speed", strict.sample, 0.5, 250.0, spin=(0.0, 0.0, 3.984), **given)
        assert "a particle that spins counts as having V (1 + k spin^2)^(1/2)" in line
        assert strict.counts["extrapolated"] == 0
        strict.sample(0.5, 150.0, spin=(0.0, 0.0, 1.611), **given)  # (0.7778 / 0.3)^(1/2) = 1.6102
        assert strict.counts["extrapolated"] == 0
        strict.sample(0.5, 150.0, spin=(0.0, 0.0, 1.609), **given)
        assert strict.counts["extrapolated"] == 1
        strict.sample(0.5, 60.0, spin=(0.0, 0.0, 1.0), **given)  # below 50 m/s is no cause


@pytest.mark.parametrize(("place", "value"), [(32, 1.1), (0, -0.1), (5, 0.999), (9, np.nan)])
def test_wrong_quantiles_of_kappa_are_refused(place, value):
    quantiles = CONTENTS["spin/kappa_quantiles"].copy()
    quantiles[1, place] = value
    with pytest.raises(InputError, match=r"^spin/kappa_quantiles: got"):
        replace(CONTENTS, datasets=CONTENTS.datasets | {"spin/kappa_quantiles": quantiles})


REFUSED_INERTIAS = [-1e-300, np.nan, np.inf, "heavy", [0.3, -0.1]]


@pytest.mark.parametrize("inertia", REFUSED_INERTIAS)
def test_refused_inertias(table, inertia):
    keys = {"seed": 1, "index": [0, 1], "hit": 0}
    spin = (0.1, 0.0, 0.0)
    refused("inertia", table.sample, 0.5, 100.0, spin=spin, inertia=inertia, **keys)
    impact = (0, -90, 0), (0, 1, 0), 1e-5
    refused("inertia", table.rebound, *impact, omega=spin, inertia=inertia, **keys)


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
    both = (table.sample, conditions), (table.rebound, impact)
    for call, given, more in (
        *((table.sample, conditions, more) for more in ({"spin": (0, 0, 0)}, {"grain": (0, 1, 1)})),
        *((table.rebound, impact, more) for more in ({"omega": (0, 0, 0)}, {"grain": (0, 1, 1)})),
        *((call, given, {"grain": "own"}) for call, given in both),
        (table.rebound, impact, {}),
    ):
        field = next(iter(more), "grain")
        with pytest.raises(InputError, match=rf"^{field}: the table made-up has no spin law; "):
            call(*given, seed=1, index=0, **more)
    with pytest.raises(InputError, match=r"^grains: the table made-up has no spin law"):
        table.grains(1, 0)
