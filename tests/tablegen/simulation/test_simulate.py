"""Direct simulation: keys and threads, populations, and what is refused."""

import time

import numpy as np
import pytest
from interruption import interrupted
from scipy.stats import binom, kstest, truncnorm

import tablegen
from sampler.errors import InputError
from tablegen.config.config import load_config
from tablegen.model.audit import AUDIT_SIZE
from tablegen.model.shape_codes import SHAPE_CODES, SHAPE_NAMES
from tablegen.simulation.batches import BATCH
from tablegen.simulation.simulate import check_impact_angle, make_condition, simulate_condition

_CONFIG = load_config("corundum-steel")
PAIR, POPULATION = _CONFIG.pair, _CONFIG.population
CONDITION = make_condition(np.radians(40.0), 200.0)

#: False-alarm rate of each statistical test below.
FALSE_ALARM = 1e-6


def run(count, seed=7, population=POPULATION, condition=CONDITION, **options):
    return simulate_condition(PAIR, population, condition, count, seed=seed, **options)


def assert_same(one, other, count=None):
    """Both simulations agree to the last bit, in their first ``count`` particles."""
    for field in ("state", "collisions", "shape", "aspect", "energy", "work"):
        a, b = getattr(one, field), getattr(other, field)
        np.testing.assert_array_equal(a[:count], b[:count], err_msg=field)


@pytest.mark.parametrize("threads", [2, 5, None])
def test_result_does_not_depend_on_the_number_of_threads(threads):
    count = 3 * BATCH + 11
    assert_same(run(count, threads=1), run(count, threads=threads))


@pytest.mark.parametrize("size", [1, 37, 100_000])
def test_result_does_not_depend_on_the_batch(size, monkeypatch):
    expected = run(1000)
    monkeypatch.setattr("tablegen.simulation.batches.BATCH", size)
    assert_same(expected, run(1000))


@pytest.mark.processor
def test_particle_does_not_depend_on_the_count():
    assert_same(run(20), run(BATCH + 20), count=20)
    assert_same(run(1), run(20), count=1)


def test_audit_of_batches_is_the_largest_of_all(monkeypatch):
    assert run(600).audit.shape == (0,)
    expected = run(600, audited=True).audit
    assert expected.shape == (AUDIT_SIZE,)
    assert 0.0 < expected.max() < 1e-9
    monkeypatch.setattr("tablegen.simulation.batches.BATCH", 50)
    np.testing.assert_array_equal(run(600, audited=True, threads=3).audit, expected)


def correlation_of_runs(one, other):
    """Correlation of v of the same particle in two runs."""
    return np.corrcoef(one.state[:, 1], other.state[:, 1])[0, 1]


@pytest.mark.parametrize(
    ("seed", "stream"), [(8, 0), (7, 1), (7 + 2**32, 0), (7, 2**32 - 1), (2**64 - 1, 0)]
)
def test_another_seed_or_stream_gives_independent_particles(seed, stream):
    count = 20_000
    one, other = run(count), run(count, seed=seed, stream=stream)
    assert not np.any(one.state[:, 0] == other.state[:, 0])
    # the correlation of independent runs is normal with error count^-1/2; 4.9 errors: 1e-6
    assert abs(correlation_of_runs(one, other)) < 4.9 / np.sqrt(count)


def test_shared_particles_would_be_seen():
    # one particle in ten is the same in both runs, as streams that overlap would have it
    count = 20_000
    one, other = run(count), run(count, stream=1)
    other.state[::10] = one.state[::10]
    assert abs(correlation_of_runs(one, other)) > 4.9 / np.sqrt(count)


def test_fields_have_the_documented_form():
    made = run(100)
    assert made.state.shape == (100, 6)
    assert made.state.dtype == np.float64
    assert made.collisions.shape == made.shape.shape == (100,)
    assert made.collisions.dtype == made.shape.dtype == np.int64
    assert made.aspect.shape == made.energy.shape == made.work.shape == (100, 2)
    assert made.collisions.min() >= 1


def least_share_p_value(shapes, names):
    """Smallest two-sided binomial p-value of equal shares, times the number of shapes."""
    values = []
    for name in names:
        found = np.sum(shapes == SHAPE_CODES[name])
        law = binom(len(shapes), 1.0 / len(names))
        values.append(2.0 * min(law.cdf(found), law.sf(found - 1)))
    return len(names) * min(values)


MIXED = ("ellipsoid", "prism", "truncated-prism", "tetrahedron")


def test_mixture_has_equal_shares():
    shapes = run(100_000).shape
    assert set(shapes) == {SHAPE_CODES[name] for name in MIXED}
    assert least_share_p_value(shapes, MIXED) > FALSE_ALARM


def test_unequal_shares_are_rejected():
    # 26 : 24 : 25 : 25 per cent
    weights = {"ellipsoid": 0.26, "prism": 0.24, "truncated-prism": 0.25, "tetrahedron": 0.25}
    shapes = type(POPULATION.shapes).model_validate(weights)
    population = POPULATION.model_copy(update={"shapes": shapes})
    assert least_share_p_value(run(100_000, population=population).shape, MIXED) < FALSE_ALARM


@pytest.mark.parametrize("name", SHAPE_NAMES)
def test_a_population_of_one_shape_holds_that_shape(name):
    made = run(50, population=POPULATION.restricted_to(name))
    np.testing.assert_array_equal(made.shape, SHAPE_CODES[name])


def aspect_p_value(aspect):
    """Smaller p-value of the two ratios against the truncated normal law, times two."""
    # normal(0.8, 0.2) cut to [0.5, 1]
    law = truncnorm(-1.5, 1.0, loc=0.8, scale=0.2)
    return 2.0 * min(kstest(ratio, law.cdf).pvalue for ratio in aspect.T)


def test_aspect_ratios_follow_the_truncated_normal_law():
    aspect = run(100_000).aspect
    assert aspect.min() >= 0.5
    assert aspect.max() <= 1.0
    assert aspect_p_value(aspect) > FALSE_ALARM
    # b/a and c/b are independent, and so is the shape from both: 4.9 errors, 1e-6 each
    made = run(100_000)
    columns = np.column_stack([made.aspect, made.shape])
    off = np.corrcoef(columns.T)[np.triu_indices(3, 1)]
    assert np.abs(off).max() < 4.9 / np.sqrt(100_000)


def test_clipped_aspect_ratios_are_rejected():
    # normal(0.8, 0.2) drawn without redrawing: what is outside [0.5, 1] moves to its ends
    raw = np.random.default_rng(91).normal(0.8, 0.2, (100_000, 2))
    assert aspect_p_value(np.clip(raw, 0.5, 1.0)) < FALSE_ALARM


def test_aspect_ratios_of_a_slightly_other_mean_are_rejected():
    law = truncnorm(-1.55, 0.95, loc=0.81, scale=0.2)
    raw = law.rvs((100_000, 2), random_state=np.random.default_rng(92))
    assert aspect_p_value(raw) < FALSE_ALARM


def test_fixed_aspect_is_kept_exactly():
    made = run(200, population=POPULATION.with_aspect(0.7, 0.55))
    np.testing.assert_array_equal(made.aspect, np.tile([0.7, 0.55], (200, 1)))


def test_fixed_aspect_reaches_the_mechanics():
    slim, round_ = (run(5000, population=POPULATION.with_aspect(x, x)) for x in (0.5, 1.0))
    assert np.abs(slim.state.mean(axis=0) - round_.state.mean(axis=0)).max() > 0.05


#: What is no number, and what of it a message repeats.
NO_NUMBERS = [
    (None, "None"),
    (True, "True"),
    ("abc", "'abc'"),
    ("0.5", "'0.5'"),
    (0.5j, "0.5j"),
    (np.array([0.5, 0.6]), "array([0.5, 0.6])"),
    (np.array(0.5), "array(0.5)"),
    ([0.5], "[0.5]"),
    (10**400, "a number beyond"),
]

#: Arguments of `make_condition` or of a run, how each is repeated, and what is allowed.
REFUSED = [
    *(
        ("alpha1", np.radians(deg), f"{deg:.9g}", "1e-06 to 90 degrees")
        for deg in (0.0, -1.0, 1e-300, 9.9e-7, 90.0000001, 90.001, 91.0, np.nan, np.inf, -np.inf)
    ),
    *(
        ("speed", speed, f"{speed:g}", "1e-06 to 100000 m/s")
        for speed in (0.0, -200.0, 1e-300, 1.1e5, np.nan, np.inf, -np.inf)
    ),
    *(("spin", spin, "(", "three numbers") for spin in ((0.0, 1.0), (0.0,) * 4)),
    *(
        ("spin", (0.0, part, 0.0), f"{part:g}", "-1000 to 1000 V/a")
        for part in (np.nan, np.inf, -1e100, 1000.1)
    ),
    *(
        ("contact_resolution", value, f"{value:g}", "1e-06 to 0.1")
        for value in (0.0, -1e-3, 0.11, 9e-7, 1e-300, np.nan)
    ),
    *(
        ("tolerance", value, f"{value:g}", "1e-14 to 0.0001")
        for value in (0.0, 1e-15, 1e-3, 1e-300, np.nan)
    ),
    *(
        (field, value, given, "1")
        for field in ("alpha1", "speed", "contact_resolution", "tolerance")
        for value, given in NO_NUMBERS
    ),
    *(("spin", value, given, "three numbers") for value, given in NO_NUMBERS),
    ("spin", ["1", 0.0, 0.0], "'1'", "-1000 to 1000 V/a"),
    ("spin", [True, 0.0, 0.0], "True", "-1000 to 1000 V/a"),
    *(("count", value, f"{value}", "1 or more") for value in (0, -1)),
    *(("seed", value, f"{value}", "0 to 2**64 - 1") for value in (-1, 2**64)),
    *(("stream", value, f"{value}", "0 to 2**32 - 1") for value in (-1, 2**32)),
    *(("threads", value, f"{value}", "1 or more") for value in (0, -1)),
    *(
        (field, value, f"{value!r}", allowed)
        for field, allowed in (
            ("count", "1 or more"),
            ("seed", "0 to 2**64 - 1"),
            ("stream", "0 to 2**32 - 1"),
            ("threads", "1 or more"),
        )
        for value in (1.5, 2.0, True, "3", np.nan)
    ),
]


@pytest.mark.parametrize(("field", "value", "given", "allowed"), REFUSED)
def test_values_outside_their_range_are_refused_in_one_line(field, value, given, allowed):
    of_run = field in ("count", "seed", "stream", "threads")
    call, usual = (
        (run, {"count": 10}) if of_run else (make_condition, {"alpha1": 0.5, "speed": 200.0})
    )
    with pytest.raises(InputError) as caught:
        call(**usual | {field.removeprefix("contact_"): value})
    message = str(caught.value)
    assert "\n" not in message
    assert message.startswith(f"{field}: got {given}")
    assert f"allowed: {allowed}" in message


def test_ends_of_the_ranges_are_allowed():
    # 90 degrees from a file may come out a rounding above pi / 2
    assert make_condition(np.pi / 2 * (1.0 + 1e-16), 200.0) == make_condition(np.pi / 2, 200.0)
    assert check_impact_angle(np.radians(90.0)) == np.pi / 2
    assert check_impact_angle(np.radians(1e-6)) == np.radians(1e-6)
    assert make_condition(0.5, 1e5).speed == 1e5
    assert make_condition(np.float32(0.5), np.int64(200), np.ones(3)).spin == (1.0, 1.0, 1.0)
    made = make_condition(np.radians(1e-6), 1e-6, resolution=1e-6, tolerance=1e-14)
    assert made.resolution > 0.0
    made = make_condition(0.5, 200.0, resolution=0.1, tolerance=1e-4)
    assert (made.resolution, made.tolerance) == (0.1, 1e-4)
    assert np.all(np.isfinite(run(10, seed=2**64 - 1, stream=2**32 - 1).state))


def test_grazing_angles_down_to_the_smallest_give_finite_states():
    for alpha in (1e-3, 1e-6, np.radians(1e-6)):
        made = run(2000, condition=make_condition(alpha, 200.0), audited=True)
        assert np.all(np.isfinite(made.state))
        assert made.state[:, 1].min() > 0.0
        assert made.audit.max() <= 1e-9


def test_a_particle_that_never_leaves_is_an_error(monkeypatch):
    # the kernel gives the index of the particle that ran into the alarm
    monkeypatch.setattr("tablegen.simulation.batches.simulate_batch", lambda *arguments: 13)
    with pytest.raises(RuntimeError, match="particle 13 of seed 7, stream 0 is still in contact"):
        run(20)


def test_progress_bar_counts_rebounds_on_standard_error(terminal, capsys):
    run(100, progress=True)
    captured = capsys.readouterr()
    assert captured.out == ""
    assert "simulating" in captured.err
    assert "100/100" in captured.err
    run(100)
    assert capsys.readouterr().err == ""


class TestConfigured:
    """`tablegen.simulate` takes all of a configuration: laws, particles and numerics."""

    @pytest.mark.parametrize("change", [{"contact_resolution": 0.05}, {"tolerance": 1e-5}])
    def test_numerics_reach_the_model(self, change):
        config = _CONFIG.with_changes({"model": change})
        plain = tablegen.simulate(_CONFIG, 0.5, 200.0, 500, seed=3)
        made = tablegen.simulate(config, 0.5, 200.0, 500, seed=3)
        assert np.any(made.state != plain.state)
        numbers = {"resolution": 1e-3, "tolerance": 1e-10}
        name, value = change.popitem()
        numbers[name.removeprefix("contact_")] = value
        expected = run(500, seed=3, condition=make_condition(0.5, 200.0, **numbers))
        np.testing.assert_array_equal(made.state, expected.state)

    def test_laws_spin_stream_and_particles_reach_the_model(self):
        config, spheres = load_config("forder-1998"), POPULATION.restricted_to("sphere")
        made = tablegen.simulate(
            config, 0.5, 200.0, 50, seed=3, spin=(0.0, 0.0, 2.0), population=spheres, stream=4
        )
        condition = make_condition(0.5, 200.0, (0.0, 0.0, 2.0))
        expected = simulate_condition(config.pair, spheres, condition, 50, seed=3, stream=4)
        np.testing.assert_array_equal(made.state, expected.state)
        assert set(made.shape) == {SHAPE_CODES["sphere"]}


class TestInterruption:
    """Ctrl-C ends a run soon, whatever it costs."""

    @pytest.mark.parametrize("threads", [1, 2])
    def test_a_long_run(self, threads):
        run(100)  # compiles
        with interrupted(within=1.0):
            run(5_000_000, threads=threads)

    @pytest.fixture
    def sizes(self, monkeypatch):
        """Numbers of particles of each call of a kernel that takes so many seconds for each."""

        def kernel(seconds):
            seen = []

            def simulate(*arguments):
                outputs = arguments[-4:]
                for array in outputs:
                    array[:] = 0
                seen.append(len(outputs[0]))
                time.sleep(seconds * seen[-1])
                return -1

            monkeypatch.setattr("tablegen.simulation.batches.simulate_batch", simulate)
            return seen

        return kernel

    def test_slow_particles_are_simulated_few_at_a_time(self, sizes):
        seen = sizes(0.002)
        run(300, threads=1)
        assert sum(seen) == 300
        assert max(seen) <= 50  # a tenth of a second

    def test_quick_particles_are_simulated_many_at_a_time(self, sizes):
        seen = sizes(0.0)
        run(4 * BATCH, threads=1)
        assert sum(seen) == 4 * BATCH
        assert max(seen) == BATCH
