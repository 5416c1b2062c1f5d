"""Rough walls: the law of the tilt by quadrature, and what every rebound must keep."""

import math
from itertools import pairwise

import numpy as np
import pytest
from impacts import impacts
from sampler.compilation.jit import no_refcount_kernel
from sampler.drawing import frames
from sampler.drawing.frames import rebound
from sampler.drawing.philox import philox_block
from sampler.drawing.roughness import (
    MAX_ROUGHNESS,
    MAX_TRIALS,
    TILT_BLOCK,
    bounce_seed,
    draw_tilt,
    facet_normal,
    proposed_score,
    rough_bounces,
    rough_rebound,
    tilt_from_words,
)
from scipy.integrate import quad
from scipy.stats import kstest

import sampler

# called from Python here
bounce_seed = no_refcount_kernel(bounce_seed)
facet_normal = no_refcount_kernel(facet_normal)

N = 40_000
#: Kolmogorov's bound: P(D > bound) < 2 exp(-2 n bound^2) = 1e-6 for each comparison.
KS_BOUND = math.sqrt(math.log(2.0 / 1e-6) / (2.0 * N))

AT_REST = (0.0, 0.0, 0.0)
UP = (0.0, 1.0, 0.0)

#: Angles in degrees and roughness in rad: from deep shadow to hardly any.
LAWS = [(0.0, 0.1), (0.5, 0.1), (3.0, 0.05), (10.0, 0.2), (30.0, 0.5), (45.0, 0.02), (90.0, 0.3)]


def _density(alpha1, roughness, weighted=True):
    """Density of the tilt up to a factor, and the ends between which it is positive."""

    def p(g):
        weight = math.sin(alpha1 + g) if weighted else 1.0
        return math.exp(-0.5 * (g / roughness) ** 2) * weight

    low = max(-alpha1, -0.5 * math.pi, -12.0 * roughness)
    return p, low, min(0.5 * math.pi, math.pi - alpha1, 12.0 * roughness)


def _distribution(alpha1, roughness, weighted=True):
    """Distribution function of the tilt by quadrature, for arrays."""
    p, low, high = _density(alpha1, roughness, weighted)
    knots = np.linspace(low, high, 401)
    parts = [quad(p, a, b, epsabs=0.0, epsrel=1e-10)[0] for a, b in pairwise(knots)]
    cumulative = np.concatenate(([0.0], np.cumsum(parts)))
    return lambda g: np.interp(g, knots, cumulative / cumulative[-1])


@no_refcount_kernel
def _tilts(alpha1, roughness, seed, tilts):
    found = True
    for k in range(tilts.size):
        accepted, tilts[k] = draw_tilt(alpha1, roughness, seed, k, 0)
        found = found and accepted
    return found


def _drawn_tilts(alpha_deg, roughness, seed=1):
    tilts = np.empty(N)
    assert _tilts(math.radians(alpha_deg), roughness, seed, tilts)
    return tilts


@pytest.mark.parametrize(("alpha_deg", "roughness"), LAWS)
def test_law_of_the_tilt_by_quadrature(alpha_deg, roughness):
    tilts = _drawn_tilts(alpha_deg, roughness)
    alpha1 = math.radians(alpha_deg)
    # The table of the distribution function is off by up to some 1e-5.
    assert kstest(tilts, _distribution(alpha1, roughness)).statistic < KS_BOUND
    # No facet recedes, none hangs over.
    assert (alpha1 + tilts > 0.0).all()
    assert (np.abs(tilts) < 0.5 * np.pi).all()
    # Refused: tilts wider by a tenth.
    assert kstest(1.1 * tilts, _distribution(alpha1, roughness)).statistic > KS_BOUND


@pytest.mark.parametrize(("alpha_deg", "roughness"), [law for law in LAWS if law[0] < 40.0])
def test_unweighted_law_is_refused(alpha_deg, roughness):
    """Facets drawn without regard to what the particle sees of them; receding ones left out."""
    tilts = _drawn_tilts(alpha_deg, roughness)
    plain = _distribution(math.radians(alpha_deg), roughness, weighted=False)
    assert kstest(tilts, plain).statistic > 3.0 * KS_BOUND


def test_mean_tilt_grows_towards_grazing():
    """For small roughness: its square over tan(alpha), up to that of a Rayleigh law."""
    roughness = 0.03
    angles = (90.0, 60.0, 30.0, 15.0, 5.0, 2.0, 0.5, 0.0)
    means = [_drawn_tilts(a, roughness).mean() for a in angles]
    assert (np.diff(means) > 0.0).all()
    error = roughness / math.sqrt(N)
    for angle, mean in zip(angles[1:4], means[1:4], strict=True):
        assert mean == pytest.approx(roughness**2 / math.tan(math.radians(angle)), abs=5 * error)
    assert means[-1] == pytest.approx(roughness * math.sqrt(0.5 * math.pi), abs=5 * error)


def test_tilts_at_normal_impact_are_symmetric():
    tilts = _drawn_tilts(90.0, 0.2)
    p = _distribution(math.pi / 2, 0.2)
    assert kstest(-tilts, p).statistic < KS_BOUND
    assert kstest(tilts + 0.01, p).statistic > KS_BOUND


def test_branches_of_a_proposal_with_scripted_numbers():
    # the part z phi(z), z > c: its size is Rayleigh's
    assert proposed_score(0.0, 0.5, 0.3, 0.5) == math.sqrt(-2.0 * math.log(0.3))
    assert proposed_score(1.0, 0.999, 0.3, 0.5) == math.sqrt(1.0 - 2.0 * math.log(0.3))
    # the part c phi(z): z > c stays, |z| < c changes its sign with probability (1 - z/c) / 2
    assert proposed_score(1.0, 0.0, 0.99, 0.0) > 1.0
    z = proposed_score(1.0, 0.0, 0.5, 1.0 - 1e-9)
    assert 0.0 < z < 1.0
    turn = 0.5 * (1.0 - z)
    assert proposed_score(1.0, 0.0, 0.5, turn - 1e-9) == -z
    assert proposed_score(1.0, 0.0, 0.5, turn + 1e-9) == z


@pytest.mark.parametrize("word", [0, 2**32 - 1])
@pytest.mark.parametrize(("alpha_deg", "roughness"), [*LAWS, (90.0, 1e-12), (1e-9, 0.5)])
def test_ends_of_the_random_words(alpha_deg, roughness, word):
    """All combinations of the smallest and the largest word: nothing but finite tilts."""
    alpha1 = math.radians(alpha_deg)
    for bits in range(16):
        words = [np.uint32(word if bits >> k & 1 else 2**32 - 1 - word) for k in range(4)]
        accepted, tilt = tilt_from_words(alpha1, roughness, *words)
        assert math.isfinite(tilt)
        assert not accepted or 0.0 < alpha1 + tilt < math.pi


def test_few_trials_are_needed():
    """The bound of the rejection is close; so an error after so many trials is never seen."""
    for alpha_deg in (0.0, 1.0, 30.0, 90.0):
        rng = np.random.default_rng(1)
        words = rng.integers(0, 2**32, (4000, 4), dtype=np.uint32)
        alpha1 = math.radians(alpha_deg)
        share = np.mean([tilt_from_words(alpha1, MAX_ROUGHNESS, *row)[0] for row in words])
        # 0.88 from quadrature; one standard error is 0.005
        assert share > 0.85
    assert 0.15**MAX_TRIALS < 1e-50


def test_trials_have_blocks_of_their_own():
    """The first tilt comes from block 3 of the keys: draw and azimuth have blocks 0 to 2."""
    words = [np.uint32(w) for w in no_refcount_kernel(philox_block)(5, 6, 7, TILT_BLOCK)]
    accepted, tilt = tilt_from_words(0.6, 0.1, *words)
    assert accepted
    assert draw_tilt(0.6, 0.1, 5, 6, 7) == (True, tilt)
    assert bounce_seed(5, 0) == 5
    assert len({int(bounce_seed(5, k)) for k in range(64)}) == 64


def test_facet_is_tilted_in_the_plane_of_incidence():
    rng = np.random.default_rng(2)
    for _ in range(50):
        e_y, velocity = rng.standard_normal(3), rng.standard_normal(3)
        e_y /= np.linalg.norm(e_y)
        velocity *= -np.sign(velocity @ e_y)
        tilt = rng.uniform(-0.5, 0.5)
        normal = np.array(facet_normal(tuple(velocity), tuple(e_y), tilt, 0, 0, 0))
        assert np.linalg.norm(normal) == pytest.approx(1.0, abs=1e-14)
        assert abs(np.cross(velocity, e_y) @ normal) < 1e-13 * np.linalg.norm(velocity)
        # The facet meets the path at alpha + tilt.
        speed = np.linalg.norm(velocity)
        alpha1 = math.asin(-velocity @ e_y / speed)
        assert -velocity @ normal / speed == pytest.approx(math.sin(alpha1 + tilt), abs=1e-13)


@pytest.fixture(scope="module")
def shipped():
    return sampler.load("corundum-steel")


def _rough(table, velocity, normal, roughness, keys=(1, 0, 0), wall=AT_REST):
    out = np.empty(6)
    velocity, normal = tuple(map(float, velocity)), tuple(map(float, normal))
    status, bounces = rough_bounces(
        table.arrays, velocity, normal, 1e-5, wall, roughness, *keys, out
    )
    return status, bounces, out


def test_a_single_bounce_is_the_smooth_rebound_from_the_facet(shipped):
    """The same draw as without roughness, at the facet's angle and in its frame."""
    velocity = (100.0, -100.0, 30.0)
    compared = 0
    for index in range(50):
        status, bounces, out = _rough(shipped, velocity, UP, 0.1, (3, index, 2))
        assert status == sampler.OK
        if bounces == 1:
            angle = math.atan2(100.0, math.hypot(100.0, 30.0))
            tilt = draw_tilt(angle, 0.1, 3, index, 2)[1]
            facet = facet_normal(velocity, UP, tilt, 3, index, 2)
            smooth = np.empty(6)
            rebound(shipped.arrays, velocity, facet, 1e-5, AT_REST, 3, index, 2, smooth)
            np.testing.assert_array_equal(out, smooth)
            compared += 1
    assert compared > 40


def test_further_bounces_have_numbers_of_their_own(shipped):
    """A second bounce follows the first from the mean wall, with the next seed."""
    velocity = (150.0, -150.0, 0.0)
    seen = 0
    for index in range(300):
        _, bounces, out = _rough(shipped, velocity, UP, 0.5, (3, index, 0))
        if bounces == 2:
            seen += 1
            before = velocity
            for k in range(2):
                key = np.uint64(bounce_seed(3, k))
                angle = frames.impact_angle(before, UP)[0]
                tilt = draw_tilt(angle, 0.5, key, index, 0)[1]
                facet = facet_normal(before, UP, tilt, key, index, 0)
                step = np.empty(6)
                rebound(shipped.arrays, before, facet, 1e-5, AT_REST, key, index, 0, step)
                before = tuple(step[:3])
                assert (step[1] > 0.0) == (k == 1)
            np.testing.assert_array_equal(out, step)
    assert seen > 5


@pytest.mark.parametrize("roughness", [0.01, 0.1, 0.5])
def test_every_particle_leaves_and_none_gains_speed(shipped, roughness):
    velocity, normal = impacts(20_000)
    # A tenth of them graze the mean wall.
    unit = normal / np.linalg.norm(normal, axis=1, keepdims=True)
    fall = np.einsum("nk,nk->n", velocity, unit)[:, None]
    velocity[:2000] -= 0.999 * (fall * unit)[:2000]
    v, omega = shipped.rebound(
        velocity, normal, 1e-5, seed=4, index=range(len(velocity)), roughness=roughness
    )
    assert np.isfinite(v).all()
    assert np.isfinite(omega).all()
    assert (np.einsum("nk,nk->n", v, normal) > 0.0).all()
    assert (np.linalg.norm(v, axis=1) <= np.linalg.norm(velocity, axis=1)).all()


def test_cascades_end_soon(shipped):
    """On the roughest wall, at normal impact, one in five is sent back into it; fewer at others."""
    counts = np.bincount(
        [_rough(shipped, (1.0, -100.0, 0.0), UP, 0.5, (9, k, 0))[1] for k in range(3000)]
    )
    assert counts[1] > 0.5 * counts.sum()
    assert len(counts) < 20
    assert 0.15 * counts.sum() < counts[2:].sum() < 0.3 * counts.sum()


def test_normal_impact_scatters_alike_in_all_directions(shipped):
    """False-alarm rate 1e-6 for each of two; tilts all along x are refused."""
    n = 4000
    velocity = np.tile([0.0, -150.0, 0.0], (n, 1))
    v, _ = shipped.rebound(velocity, UP, 1e-5, seed=2, index=range(len(velocity)), roughness=0.3)
    angle = np.arctan2(v[:, 2], v[:, 0])
    for harmonic in (1, 2):
        assert n * np.abs(np.exp(1j * harmonic * angle).mean()) ** 2 < math.log(1e6)
    # A path a little off the normal has a plane, and tilts in it only.
    velocity[:, 0] = 1e-6
    v, _ = shipped.rebound(velocity, UP, 1e-5, seed=2, index=range(len(velocity)), roughness=0.3)
    angle = np.arctan2(v[:, 2], v[:, 0])
    assert n * np.abs(np.exp(2j * angle).mean()) ** 2 > math.log(1e6)


def test_off_is_the_smooth_wall(shipped):
    velocity, normal = impacts(500)
    keys = {"seed": 2, "index": range(500)}
    smooth = shipped.rebound(velocity, normal, 1e-5, **keys)
    zero = shipped.rebound(velocity, normal, 1e-5, roughness=0.0, **keys)
    np.testing.assert_array_equal(smooth, zero)
    # and a vanishing roughness has vanishing effects
    tiny = shipped.rebound(velocity, normal, 1e-5, roughness=1e-9, **keys)
    np.testing.assert_allclose(tiny[0], smooth[0], atol=1e-3)
    rough = shipped.rebound(velocity, normal, 1e-5, roughness=0.1, **keys)
    assert np.abs(rough[0] - smooth[0]).max() > 10.0


def test_rows_have_roughness_of_their_own_and_threads_change_nothing(shipped):
    velocity, normal = impacts(500)
    roughness = np.random.default_rng(1).uniform(0.0, 0.5, 500)
    roughness[::7] = 0.0
    keys = {"seed": 2, "index": range(500), "roughness": roughness}
    alone = shipped.rebound(velocity, normal, 1e-5, threads=1, **keys)
    many = shipped.rebound(velocity, normal, 1e-5, threads=3, **keys)
    np.testing.assert_array_equal(alone, many)
    one = shipped.rebound(velocity[41], normal[41], 1e-5, seed=2, index=41, roughness=roughness[41])
    np.testing.assert_array_equal(np.array(alone)[:, 41], np.array(one))


@pytest.mark.parametrize("roughness", [-0.1, 0.51, np.nan, [0.1, 2.0]])
def test_wrong_roughness_is_refused(shipped, roughness):
    with pytest.raises(sampler.InputError, match=r"^roughness: got .* allowed: 0 to 0.5 rad$"):
        shipped.rebound([[1.0, -1.0, 0.0]] * 2, UP, 1e-5, seed=1, index=0, roughness=roughness)


def test_receding_particles_are_refused(shipped):
    for velocity in ((1.0, 1.0, 0.0), (1.0, 0.0, 0.0)):
        with pytest.raises(sampler.InputError, match=r"velocity: got .* towards the wall"):
            shipped.rebound(velocity, UP, 1e-5, seed=1, index=0, roughness=0.1)
    with pytest.raises(sampler.InputError, match="1e-150 m/s or more relative to the wall"):
        shipped.rebound(AT_REST, UP, 1e-5, seed=1, index=0, roughness=0.1)
    with pytest.raises(sampler.InputError, match="velocity: got nan"):
        shipped.rebound([np.nan, -1.0, 0.0], UP, 1e-5, seed=1, index=0, roughness=0.1)


def test_facets_outside_of_the_table_are_counted_or_refused():
    """The mean condition is inside; a facet within half a degree of the path is not."""
    velocity = np.tile([100.0, -2.0, 0.0], (2000, 1))
    table = sampler.load("corundum-steel")
    table.rebound(velocity, UP, 1e-5, seed=1, index=range(len(velocity)), roughness=0.05)
    assert 10 < table.clamped < 500
    strict = sampler.load("corundum-steel", outside="raise")
    with pytest.raises(sampler.InputError, match=r"^roughness: got a facet or a further bounce"):
        strict.rebound(velocity, UP, 1e-5, seed=1, index=range(len(velocity)), roughness=0.05)


def test_kernel_inside_compiled_code(shipped):
    out = np.empty(6)
    arguments = (shipped.arrays, (90.0, -90.0, 0.0), UP, 1e-5, AT_REST, 0.1, 1, 2, 3, out)
    assert rough_rebound(*arguments) == sampler.OK
    v, omega = shipped.rebound([90.0, -90.0, 0.0], UP, 1e-5, seed=1, index=2, hit=3, roughness=0.1)
    np.testing.assert_array_equal(out, [*v, *omega])
    assert sampler.CASCADE_NOT_ENDED < 0
    for roughness in (10.0, 0.500001, -0.1, np.nan, np.inf):
        refused = (*arguments[:5], roughness, *arguments[6:])
        assert rough_rebound(*refused) == sampler.ROUGHNESS_NOT_USABLE
    np.testing.assert_array_equal(out, [*v, *omega])
