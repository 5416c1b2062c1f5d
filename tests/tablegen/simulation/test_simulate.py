"""Direct simulation: keys and threads, populations, refusals and interruption."""

import threading
import time

import numpy as np
import pytest
from interruption import interrupted
from refusals import refused
from scipy.stats import binom, kstest, truncnorm

import tablegen
from sampler.errors import REBOUND_NOT_ENDED
from sampler.formats.shape_codes import SHAPE_CODES
from tablegen.config.config import load_config
from tablegen.parallel import LONGEST_SLICE
from tablegen.simulation.direct_law import Simulated, simulate_impacts
from tablegen.simulation.simulate import (
    check_impact_angle,
    make_condition,
    simulate_condition,
)

_CONFIG = load_config("corundum-steel")
PAIR, POPULATION = _CONFIG.pair, _CONFIG.population
CONDITION = make_condition(np.radians(40.0), 200.0)
SIMULATED = "tablegen.simulation.simulate.simulate_impacts"

#: False-alarm rate of each statistical test below.
FALSE_ALARM = 1e-6


def run(count, seed=7, population=POPULATION, condition=CONDITION, **options):
    return simulate_condition(PAIR, population, condition, count, seed=seed, **options)


def assert_same(one, other, count=None):
    """Both simulations agree to the last bit, in their first ``count`` particles."""
    for field in ("state", "collisions", "shape", "aspect", "energy", "work", "inertia"):
        a, b = getattr(one, field), getattr(other, field)
        np.testing.assert_array_equal(a[:count], b[:count], err_msg=field)


@pytest.mark.processor
def test_particles_do_not_depend_on_threads_slices_or_count(monkeypatch):
    count = 2 * LONGEST_SLICE + 11
    expected = run(count, threads=1)
    for threads in (2, None):
        assert_same(expected, run(count, threads=threads))
    assert_same(run(20), expected, count=20)
    for size in (1, 37):
        monkeypatch.setattr("tablegen.parallel.LONGEST_SLICE", size)
        assert_same(run(500), expected, count=500)


def correlation_of_runs(one, other):
    return np.corrcoef(one.state[:, 1], other.state[:, 1])[0, 1]


@pytest.mark.parametrize(("seed", "stream"), [(8, 0), (7, 1), (7 + 2**32, 0), (7, 2**32 - 1)])
def test_another_seed_or_stream_gives_independent_particles(seed, stream):
    count = 20_000
    one, other = run(count), run(count, seed=seed, stream=stream)
    assert not np.any(one.state[:, 0] == other.state[:, 0])
    # the correlation of independent runs is normal with error count^-1/2; 4.9 errors: 1e-6
    assert abs(correlation_of_runs(one, other)) < 4.9 / np.sqrt(count)
    # one particle in ten the same, as if streams overlapped, is seen
    other.state[::10] = one.state[::10]
    assert abs(correlation_of_runs(one, other)) > 4.9 / np.sqrt(count)


@pytest.fixture(scope="module")
def simulation():
    return run(100_000)


class TestPopulation:
    MIXED = ("ellipsoid", "prism", "truncated-prism", "tetrahedron")

    def least_share_p_value(self, shapes):
        """Smallest two-sided binomial p-value of equal shares, times the number of shapes."""
        values = []
        for name in self.MIXED:
            count = np.sum(shapes == SHAPE_CODES[name])
            law = binom(len(shapes), 1.0 / len(self.MIXED))
            values.append(2.0 * min(law.cdf(count), law.sf(count - 1)))
        return len(self.MIXED) * min(values)

    def test_mixture_has_equal_shares(self, simulation):
        assert set(simulation.shape) == {SHAPE_CODES[name] for name in self.MIXED}
        assert self.least_share_p_value(simulation.shape) > FALSE_ALARM
        # 26 : 24 : 25 : 25 per cent is rejected
        weights = dict(zip(self.MIXED, (0.26, 0.24, 0.25, 0.25), strict=True))
        shapes = type(POPULATION.shapes).model_validate(weights)
        population = POPULATION.model_copy(update={"shapes": shapes})
        assert self.least_share_p_value(run(100_000, population=population).shape) < FALSE_ALARM

    def aspect_p_value(self, aspect):
        """Smaller p-value of the two ratios against the truncated normal law, times two."""
        # normal(0.8, 0.2) cut to [0.5, 1]
        law = truncnorm(-1.5, 1.0, loc=0.8, scale=0.2)
        return 2.0 * min(kstest(ratio, law.cdf).pvalue for ratio in aspect.T)

    def test_aspect_ratios_follow_the_truncated_normal_law(self, simulation):
        assert simulation.aspect.min() >= 0.5
        assert simulation.aspect.max() <= 1.0
        assert self.aspect_p_value(simulation.aspect) > FALSE_ALARM
        # b/a, c/b and the shape are independent: 4.9 errors, 1e-6 each
        columns = np.column_stack([simulation.aspect, simulation.shape])
        off = np.corrcoef(columns.T)[np.triu_indices(3, 1)]
        assert np.abs(off).max() < 4.9 / np.sqrt(100_000)
        # clipped ratios and those of a slightly other mean are rejected
        rng = np.random.default_rng(91)
        assert self.aspect_p_value(np.clip(rng.normal(0.8, 0.2, (100_000, 2)), 0.5, 1.0)) < 1e-6
        law = truncnorm(-1.55, 0.95, loc=0.81, scale=0.2)
        assert self.aspect_p_value(law.rvs((100_000, 2), random_state=rng)) < FALSE_ALARM

    def test_fixed_aspect_is_kept_and_reaches_the_mechanics(self):
        slim, round_ = (run(5000, population=POPULATION.with_aspect(x, 0.55)) for x in (0.5, 1.0))
        np.testing.assert_array_equal(slim.aspect, np.tile([0.5, 0.55], (5000, 1)))
        assert np.abs(slim.state.mean(axis=0) - round_.state.mean(axis=0)).max() > 0.05


#: What is refused of the arguments of `make_condition`, and of those of a run.
OF_CONDITIONS = {
    "alpha1": (np.radians(9.9e-7), np.radians(90.0000001), np.nan),
    "speed": (0.0, np.inf, True, "0.5", np.array([0.5, 0.6])),
    "spin": ((0.0, 1.0), None, (0.0, 1000.1, 0.0), ["1", 0.0, 0.0]),
    "contact_resolution": (0.11,),
    "tolerance": (1e-15,),
    "inertia": (-0.1, 2.1, np.nan, None),
}
OF_RUNS = {"count": (0, 1.5), "seed": (-1, 2**64), "stream": (2**32,), "threads": (0,)}


@pytest.mark.parametrize("field", [*OF_CONDITIONS, *OF_RUNS])
def test_values_outside_their_range_are_refused_in_one_line(field):
    usual, name = {"alpha1": 0.5, "speed": 200.0}, field.removeprefix("contact_")
    for value in OF_CONDITIONS.get(field, ()):
        refused(field, make_condition, **usual | {name: value})
    for value in OF_RUNS.get(field, ()):
        refused(field, run, **{"count": 10, field: value})


def test_ends_of_the_ranges_are_allowed():
    # 90 degrees from a file may come out a rounding above pi / 2
    assert make_condition(np.pi / 2 * (1.0 + 1e-16), 200.0) == make_condition(np.pi / 2, 200.0)
    assert check_impact_angle(np.radians(1e-6)) == np.radians(1e-6)
    assert make_condition(np.float32(0.5), np.int64(200), np.ones(3)).spin == (1.0, 1.0, 1.0)
    condition = make_condition(np.radians(1e-6), 1e-6, resolution=1e-6, tolerance=1e-14)
    assert np.all(np.isfinite(run(10, condition=condition).state))
    assert np.all(np.isfinite(run(10, seed=2**64 - 1, stream=2**32 - 1).state))


def test_simulate_takes_all_of_a_configuration():
    """`tablegen.simulate` uses its laws, particles and numerics."""
    numerics = {"contact_resolution": 0.05, "tolerance": 1e-5}
    config = load_config("forder-1998").with_changes({"model": numerics})
    spheres = POPULATION.restricted_to("sphere")
    for population in (None, spheres):
        options = {"seed": 3, "stream": 4}
        spin = (0.0, 0.0, 2.0)
        simulation = tablegen.simulate(
            config, 0.5, 200.0, 50, spin=spin, population=population, **options
        )
        people = population or config.population
        condition = make_condition(0.5, 200.0, spin, resolution=0.05, tolerance=1e-5)
        expected = simulate_condition(config.pair, people, condition, 50, **options)
        np.testing.assert_array_equal(simulation.state, expected.state)
        plain = make_condition(0.5, 200.0, spin)
        other = simulate_condition(config.pair, people, plain, 50, **options)
        assert population is spheres or np.any(simulation.state != other.state)


class TestNotEnded:
    """A rebound that does not end, or is not finite, is an error, never a result."""

    @pytest.fixture(autouse=True)
    def spoil(self, monkeypatch):
        """Let particle 3 not leave the wall."""

        def spoiled(law, rows, threads):
            run = simulate_impacts(law, rows, threads)
            run.codes[rows.arrays["index"] == 3] = REBOUND_NOT_ENDED
            return run

        monkeypatch.setattr(SIMULATED, spoiled)

    def test_no_simulation_returns_one(self):
        with pytest.raises(RuntimeError, match="particle 3 of seed 4, stream 0 is still in"):
            simulate_condition(PAIR, POPULATION, CONDITION, 100, seed=4, threads=2)

    def test_no_file_gets_one(self, call, tmp_path):
        words = ["--pair", "corundum-steel", "--shape", "mixture", "--alpha", 45, "--speed", 200]
        words += ["--count", 10, "--seed", 1, "--output", tmp_path / "x.npz"]
        ended = call("tablegen", "simulate", *words)
        assert ended.status == 3
        assert "is still in contact" in ended.err.splitlines()[-1]
        assert not list(tmp_path.iterdir())


class TestInterruption:
    """Ctrl-C ends a run soon, whatever a particle costs."""

    @pytest.mark.parametrize("threads", [1, 2])
    def test_a_long_run(self, threads):
        run(100)  # compiles
        with interrupted(within=1.0):
            run(5_000_000, threads=threads)

    @pytest.mark.parametrize(
        ("seconds", "count", "most"), [(2e-3, 300, 50), (0.0, 20_000, LONGEST_SLICE)]
    )
    def test_calls_take_a_tenth_of_a_second(self, monkeypatch, seconds, count, most):
        lengths, caller = [], threading.get_ident()

        def simulate(law, rows, threads):
            # a run that was interrupted before may still have a slice to do, in its own thread
            if threading.get_ident() == caller:
                lengths.append(rows.n)
                time.sleep(seconds * rows.n)
            ones = np.ones(rows.n)
            return Simulated(np.ones((rows.n, 10)), ones, ones, np.zeros(rows.n, np.intc))

        monkeypatch.setattr(SIMULATED, simulate)
        run(count, threads=1)
        assert sum(lengths) == count
        assert max(lengths) == most
