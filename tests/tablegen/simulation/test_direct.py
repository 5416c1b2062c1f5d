"""`DirectModel` is a table: its methods, codes and counts, and states by direct simulation."""

import pickle
from functools import cache

import numba
import numpy as np
import pytest
from crowds import CROWD
from refusals import refused
from scipy.spatial.transform import Rotation

import sampler
import sampler.numba
import tablegen
from sampler.formats.shape_codes import SHAPE_CODES
from tablegen.config.config import load_config
from tablegen.model.shapes import FIRST_MESH
from tablegen.parallel import LONGEST_SLICE
from tablegen.simulation.direct import DirectModel, model_without_warnings
from tablegen.simulation.simulate import make_condition, simulate_condition

CONFIG = load_config("corundum-steel")
#: Prisms that can all turn with an inertia of 0.4.
SOLID = CONFIG.population.restricted_to("prism").with_aspect(0.9, 0.6)
SPIN = (0.3, 0.0, -0.8)
IMPACT = {"alpha1": 0.6, "speed": 120.0, "spin": SPIN}
KEYS = {"seed": 4, "index": np.arange(500), "hit": 1}


@cache
def model():
    """Model of the shipped pair; made by the first test, which may have to compile it."""
    return model_without_warnings(CONFIG)


@cache
def crowded():
    return model_without_warnings(CONFIG, CROWD)


def mixed_impacts(n, seed=1):
    """Angles, speeds and spins of n impacts; a third of them without spin."""
    rng = np.random.default_rng(seed)
    spin = rng.normal(0.0, 0.8, (n, 3)) * (rng.random((n, 1)) < 0.67)
    return np.radians(rng.uniform(1.0, 90.0, n)), rng.uniform(10.0, 300.0, n), spin


def lab_impacts(n, seed=1):
    """Velocities towards walls of random normals, and angular velocities of particles of 10 um."""
    rng = np.random.default_rng(seed)
    normal, velocity = rng.standard_normal((2, n, 3))
    velocity *= -50.0 * np.sign(np.einsum("nk,nk->n", velocity, normal))[:, None]
    return velocity, normal, rng.normal(0.0, 5e6, (n, 3))


class TestAgainstSimulate:
    """At one condition, states equal those of `tablegen.simulate` bit by bit."""

    @pytest.mark.parametrize(
        ("alpha_deg", "spin", "inertia"),
        [
            (0.2, (0.0, 0.0, 0.0), None),
            (20.0, SPIN, None),
            (20.0, SPIN, 0.4),
            (90.0, (0.0, 3.0, 0.0), 0.4),
        ],
    )
    def test_own_grains_at_the_first_hit(self, alpha_deg, spin, inertia):
        alpha, index = np.radians(alpha_deg), np.arange(300)
        given = {"spin": spin, "inertia": inertia or 0.0, "population": SOLID}
        simulation = tablegen.simulate(CONFIG, alpha, 170.0, 300, seed=7, **given)
        model, after = model_without_warnings(CONFIG, SOLID), np.empty(300)
        keys = {"seed": 7, "index": index, "hit": 0, "inertia_after": after}
        states = model.sample(alpha, 170.0, spin=spin, inertia=inertia, **keys)
        np.testing.assert_array_equal(states, simulation.state)
        np.testing.assert_array_equal(after, simulation.inertia)

    def test_fresh_and_given_grains_at_a_later_hit(self):
        condition = make_condition(0.5, 170.0, SPIN)
        simulation = simulate_condition(CONFIG.pair, CROWD, condition, 300, seed=7, stream=4)
        keys = {"seed": 7, "index": np.arange(300), "hit": 4}
        states = crowded().sample(0.5, 170.0, spin=SPIN, grain="fresh", **keys)
        np.testing.assert_array_equal(states, simulation.state)
        # the same grains given
        assert set(simulation.shape) == {*SHAPE_CODES.values(), FIRST_MESH, FIRST_MESH + 1}
        grains = np.column_stack([simulation.shape, simulation.aspect])
        states = crowded().sample(0.5, 170.0, spin=SPIN, grain=grains, **keys)
        np.testing.assert_array_equal(states, simulation.state)


class TestKeys:
    """Equal keys and conditions give equal states."""

    N = LONGEST_SLICE + 700

    def test_in_any_order_batch_and_number_of_threads(self):
        alpha, speed, spin = mixed_impacts(self.N)
        index, hit = np.arange(self.N), np.arange(self.N) % 5
        whole = model().sample(alpha, speed, spin=spin, seed=1, index=index, hit=hit, threads=2)
        order = np.random.default_rng(2).permutation(self.N)
        for part in (order[:6], order[6:]):
            keys = {"seed": 1, "index": index[part], "hit": hit[part], "threads": 1}
            states = model().sample(alpha[part], speed[part], spin=spin[part], **keys)
            np.testing.assert_array_equal(states, whole[part])

    def test_lab_frame_in_any_order(self):
        velocity, normal, omega = lab_impacts(400)
        keys = {"seed": 1, "index": np.arange(400), "hit": 2}
        first = crowded().rebound(velocity, normal, 1e-5, omega=omega, **keys)
        inertia = first.inertia
        whole = crowded().rebound(
            velocity, normal, 1e-5, omega=omega, inertia=inertia, threads=2, **keys
        )
        assert (whole.velocity != first.velocity).any(axis=1).mean() > 0.8
        for k in (0, 17, 399):
            own = {"omega": omega[k], "inertia": inertia[k], "index": k}
            one = crowded().rebound(velocity[k], normal[k], 1e-5, seed=1, hit=2, **own)
            assert [part.shape for part in one] == [(3,), (3,), ()]
            for part, of_all in zip(one, whole, strict=True):
                np.testing.assert_array_equal(part, of_all[k])

    def test_generators_and_shapes(self):
        one = model().sample(0.5, 100.0, rng=np.random.default_rng(1), size=(2, 3))
        same = model().sample(0.5, 100.0, rng=np.random.default_rng(1), size=(2, 3))
        np.testing.assert_array_equal(one, same)
        many = model().sample(0.5, 100.0, spin=np.zeros((4, 1, 3)), seed=1, index=[[1, 2]], hit=0)
        assert (one.shape, many.shape) == ((2, 3, 6), (4, 2, 6))
        assert model().sample([], 100.0, seed=1, index=3).shape == (0, 6)


class TestGrain:
    """A particle has its own grain at every hit, or a fresh one if that is asked for."""

    def test_own_is_that_of_the_particle_at_every_hit(self):
        grains = crowded().grains(5, range(400))
        assert set(grains[:, 0]) == {0, 1, 2, 3, 4, FIRST_MESH, FIRST_MESH + 1}
        for hit in (0, 3):
            keys = {"seed": 5, "index": np.arange(400), "hit": hit}
            own = crowded().sample(**IMPACT, **keys)
            given = crowded().sample(**IMPACT, grain=grains, **keys)
            np.testing.assert_array_equal(own, given)
            fresh = crowded().sample(**IMPACT, grain="fresh", **keys)
            assert (own == fresh).all() == (hit == 0)

    def test_is_that_of_the_table(self):
        table, index = sampler.load("corundum-steel"), np.arange(2000)
        np.testing.assert_array_equal(
            model().grains(2**64 - 3, index), table.grains(2**64 - 3, index)
        )


class TestLabFrame:
    """Walls of any direction and velocity, and particles of any size."""

    def test_is_the_frame_of_the_wall(self):
        alpha, speed, spin = mixed_impacts(500)
        states = model().sample(alpha, speed, spin=spin, **KEYS)
        velocity = speed[:, None] * np.column_stack([np.cos(alpha), -np.sin(alpha), 0.0 * alpha])
        scale = speed[:, None] / 2e-5
        v, omega, _ = model().rebound(velocity, [0.0, 1.0, 0.0], 2e-5, omega=scale * spin, **KEYS)
        # last digits of the angle grow in a long chain of collisions
        assert np.quantile(np.abs(v / speed[:, None] - states[:, :3]), 0.99) < 1e-12
        assert np.abs(v / speed[:, None] - states[:, :3]).max() < 1e-6
        assert np.abs(omega / scale - states[:, 3:]).max() < 1e-6

    def test_turns_and_moves_with_the_wall(self):
        velocity, normal, omega = lab_impacts(500)
        turn, moves = Rotation.random(random_state=3), np.array([30.0, -200.0, 7.0])
        inertia = model().rebound(velocity, normal, 1e-5, omega=omega, **KEYS).inertia
        v, after, left = model().rebound(
            velocity, normal, 1e-5, omega=omega, inertia=inertia, **KEYS
        )
        turned, spun, kept = model().rebound(
            turn.apply(velocity) + moves,
            3.0 * turn.apply(normal),
            2e-5,
            omega=turn.apply(omega) / 2.0,
            inertia=inertia,
            wall_velocity=moves,
            **KEYS,
        )
        assert np.abs(turned - moves - turn.apply(v)).max() < 1e-5
        assert np.abs(2.0 * spun - turn.apply(after)).max() < 1.0
        assert np.abs(kept - left).max() < 1e-6
        assert (np.einsum("nk,nk->n", v, normal) > 0.0).all()


class TestInertia:
    """The inertia about a spin, as an argument and as a result."""

    def test_that_is_not_known_is_that_of_a_uniform_orientation(self):
        none = model().sample(**IMPACT, **KEYS)
        np.testing.assert_array_equal(model().sample(**IMPACT, inertia=0.0, **KEYS), none)

    def test_of_what_does_not_spin_does_not_matter(self):
        still = IMPACT | {"spin": np.zeros(3)}
        for inertia in (0.0, 0.2, 9.0):
            states = model().sample(**still, inertia=inertia, **KEYS)
            expected = model().sample(0.6, 120.0, spin=np.zeros(3), **KEYS)
            np.testing.assert_array_equal(states, expected)

    def test_of_a_single_moment_and_of_fresh_grains(self):
        after, spheres = np.empty(500), {"grain": (4.0, 1.0, 1.0)}
        crowded().sample(**IMPACT, **spheres, inertia=0.4, inertia_after=after, **KEYS)
        np.testing.assert_array_equal(after, 0.4)
        model().sample(0.6, 120.0, inertia_after=after, **KEYS)
        np.testing.assert_array_equal(after, 0.0)
        head_on = crowded().sample(np.pi / 2, 9.0, **spheres, inertia_after=after, **KEYS)
        np.testing.assert_array_equal(after, np.where(head_on[:, 3:].any(axis=1), 0.4, 0.0))

    def test_is_given_back_at_the_next_wall_to_single_precision(self):
        velocity, normal, _ = lab_impacts(500)
        keys = {"seed": 4, "index": np.arange(500)}
        first = crowded().rebound(velocity, normal, 1e-5, hit=0, **keys)
        for inertia in (first.inertia, first.inertia.astype("f4")):
            crowded().rebound(
                velocity, normal, 1e-5, omega=first.omega, inertia=inertia, hit=1, **keys
            )


WALL = {"alpha1": 0.5, "speed": 100.0, "seed": 1, "index": [4, 5], "hit": 0}
LAB = {"velocity": [1.0, -1.0, 0.0], "normal": [0.0, 1.0, 0.0], "half_size": 1e-5}
LAB |= {"seed": 1, "index": [4, 5], "hit": 0}

REFUSED = [
    *((WALL, "alpha1", {"alpha1": x}) for x in ([0.5, 1.6], np.nan)),
    (WALL, "speed", {"speed": [1.0, 0.0]}),
    *((WALL, "inertia", {"spin": SPIN, "inertia": [0.3, x]}) for x in (-1.0, np.nan)),
    (LAB, "inertia", {"omega": [0.0, 1e5, 0.0], "inertia": [0.3, np.inf]}),
    (WALL, "spin", {"spin": [1.0, 2.0]}),
    (WALL, "grain", {"grain": "old"}),
    *(
        (WALL, "grain", {"grain": [[0.0, 1.0, 1.0], grain]})
        for grain in ((0, 1.1, 1), (4, 1, 0.9), (FIRST_MESH, 1, 1), (np.nan, 1, 1))
    ),
    (WALL, "index", {"index": None}),
    (LAB, "velocity", {"velocity": [[1.0, -1.0, 0.0], [1.0, 1.0, 0.0]]}),
    (LAB, "normal", {"normal": [0.0, 0.0, 0.0]}),
    (LAB, "half_size", {"half_size": [1e-5, 0.0]}),
]


@pytest.mark.parametrize(("usual", "field", "change"), REFUSED)
def test_bad_input_is_refused_in_one_line(usual, field, change):
    refused(field, model().sample if "alpha1" in usual else model().rebound, **usual | change)


#: Conditions beyond the range, the kind of the flag, and the nearest condition.
BEYOND = [
    ({"alpha1": 1e-9}, "angle", {"alpha1": np.radians(1e-6)}),
    ({"speed": 1e-7}, "speed", {"speed": 1e-6}),
    ({"speed": 2e5}, "speed", {"speed": 1e5}),
    ({"spin": (0.0, 2000.0, 0.0)}, "spin", {"spin": (0.0, 1000.0, 0.0)}),
    # the grain turns by 1e6 rad before its first contact, and the angle is raised
    ({"alpha1": 1e-3, "spin": (0.0, 0.0, 900.0)}, "angle", {"alpha1": 2.0 * 900.0 / 1e6}),
    ({"spin": SPIN, "inertia": 9.0}, "spin", {"inertia": 0.2 * (1.0 + 0.7**2)}),
    ({"spin": SPIN, "inertia": 1e-3}, "spin", {"inertia": 0.2 * 0.7**2 * (1.0 + 0.5**2)}),
]


@pytest.mark.parametrize(("change", "kind", "nearest"), BEYOND)
def test_beyond_its_range_the_nearest_impact_is_simulated_and_counted(change, kind, nearest):
    model = model_without_warnings(CONFIG, CONFIG.population.restricted_to("ellipsoid"))
    usual = {"alpha1": 0.5, "speed": 100.0, "spin": np.zeros(3), "grain": (0.0, 0.7, 0.5)}
    usual |= {"seed": 1, "index": np.arange(40), "hit": 0}
    states = model.sample(**usual | change)
    assert model.counts[kind] == 40
    expected = model.sample(**usual | change | nearest)
    np.testing.assert_allclose(states, expected, rtol=0.0, atol=1e-5 if kind == "spin" else 0.0)
    strict = DirectModel(CONFIG, CONFIG.population.restricted_to("ellipsoid"), outside="raise")
    with pytest.raises(sampler.InputError, match=r"the range of the table corundum-steel|or 0 if"):
        strict.sample(**usual | change)


def test_it_warns_where_the_pair_was_not_measured():
    model = DirectModel(CONFIG)
    with pytest.warns(sampler.OutsideTableWarning, match="it was measured at 50 to 300 m/s"):
        model.sample(0.5, 10.0, seed=1, index=3)
    assert model.counts["extrapolated"] == 1


def test_codes_of_rows_in_place_of_errors():
    velocity = [[80.0, -60.0, 0.0], [80.0, 60.0, 0.0], [np.nan, -1.0, 0.0], [8.0, -6.0, 0.0]]
    codes, works = np.empty(4, np.intc), np.empty((4, 2))
    given = {"omega": [[1.0, 2.0, 3.0]] * 4, "inertia": 0.0, "codes": codes, "works": works}
    after = model().rebound(velocity, [0.0, 1.0, 0.0], 1e-5, seed=2, index=range(4), hit=1, **given)
    assert codes.tolist() == [0, sampler.errors.NOT_APPROACHING, sampler.errors.NOT_FINITE, 8]
    np.testing.assert_array_equal(after.velocity[1], velocity[1])
    np.testing.assert_array_equal(after.omega[1], [1.0, 2.0, 3.0])
    assert after.inertia[1] == 0.0
    assert np.isnan(after.velocity[2]).all()
    assert np.isnan(works[1:3]).all()
    assert (works[[0, 3]] > 0.0).all()


def test_moments_and_quantiles_are_those_of_simulations():
    """Within six standard errors of both sides."""
    model = model_without_warnings(CONFIG, CONFIG.population.restricted_to("prism"))
    states = tablegen.simulate(
        CONFIG, 0.6, 120.0, 200_000, seed=5, population=CONFIG.population.restricted_to("prism")
    ).state
    error = 6.0 * states.std(axis=0) * np.sqrt(1 / 200_000 + 2.0**-18)
    assert (np.abs(model.mean(0.6, 120.0) - states.mean(axis=0)) < error).all()
    assert (np.abs(model.std(0.6, 120.0) / states.std(axis=0) - 1.0) < 0.02).all()
    median = model.quantile(0.5, "v", 0.6, 120.0)
    assert abs(np.mean(states[:, 1] < median) - 0.5) < 6.0 * 0.5 * np.sqrt(1 / 200_000 + 2.0**-18)


def test_it_has_what_a_table_has():
    table = sampler.load("corundum-steel")
    public = {name for name in dir(table) if not name.startswith("_")}
    assert public <= {name for name in dir(model()) if not name.startswith("_")}
    assert model().mean_half_size(2e-5) == pytest.approx(table.mean_half_size(2e-5), rel=1e-12)
    assert model().shape_geometry == table.shape_geometry
    again = pickle.loads(pickle.dumps(model()))
    states = [one.sample(0.5, 90.0, seed=1, index=range(9)) for one in (model(), again)]
    np.testing.assert_array_equal(*states)
    with pytest.raises(sampler.InputError, match="direct simulation does not run on a GPU"):
        model().to_device()


@pytest.mark.parametrize("config", ["kharaz-2001", None, CONFIG.pair])
def test_what_is_no_configuration_is_refused(config):
    refused("config", DirectModel, config)


def test_first_bad_row_is_named_whatever_the_batches():
    alpha = np.full(3 * LONGEST_SLICE, 0.5)
    alpha[[LONGEST_SLICE + 3, 2 * LONGEST_SLICE + 1]] = -1.0
    given = {"seed": 1, "index": range(3 * LONGEST_SLICE), "threads": 2}
    assert f" at row {LONGEST_SLICE + 3} " in refused(
        "alpha1", model().sample, alpha, 100.0, **given
    )


@pytest.mark.parametrize(
    "resistance", [{}, {"law": "coulomb", "static": 0.4, "dynamic": 0.3, "source": "x"}]
)
def test_works_balance_the_energy_of_spinning_particles(resistance):
    pair = {"pair": {"resistance": resistance}} if resistance else {}
    model, n = (
        model_without_warnings(CONFIG.with_changes({"model": {"tolerance": 1e-13}} | pair)),
        400,
    )
    rng, works = np.random.default_rng(8), np.empty((400, 2))
    code, b, cb = rng.integers(0, 2, n), *rng.uniform(0.5, 1.0, (2, n))
    c2, k = (b * cb) ** 2, np.where(code == 0, 0.2, 1.0 / 3.0)
    ends = k * np.array([b**2 + c2, 1.0 + b**2])
    velocity = 100.0 * np.column_stack([rng.uniform(-1, 1, n), rng.uniform(-1, -0.1, n), 0.0 * b])
    omega, inertia = rng.normal(0.0, 800.0, (n, 3)), rng.uniform(*ends)
    given = {"omega": omega, "inertia": inertia, "grain": np.column_stack([code, b, cb])}
    given |= {"seed": 1, "index": np.arange(n), "hit": 0}
    after = model.rebound(velocity, [0.0, 1.0, 0.0], 0.1, works=works, **given)

    def energy(velocity, omega, inertia):
        return (velocity**2).sum(axis=1) + 0.01 * inertia * (omega**2).sum(axis=1)

    before = energy(velocity, omega, inertia)
    lost = 0.5 * (before - energy(*after))  # J/kg
    np.testing.assert_allclose(works.sum(axis=1), lost, rtol=0, atol=1e-12 * before.max())
    assert (works >= 0.0).all()
    assert (works.min(axis=0) < 0.05 * (velocity**2).sum(axis=1).max()).all()


@numba.njit(nogil=True)
def _states_in_numba(handle, alpha1, speed, spin, inertia, out):
    for k in range(len(out)):
        turning = spin[k, 0], spin[k, 1], spin[k, 2]
        given = turning, inertia[k], None, k, 2, None, False, 7
        code = sampler.numba.sample(handle, alpha1[k], speed[k], *given, out[k])
        if code < 0:
            return code
    return 0


@numba.njit(nogil=True)
def _rebounds_in_numba(handle, velocity, normal, omega, roughness, out):
    for k in range(len(out)):
        v = velocity[k, 0], velocity[k, 1], velocity[k, 2]
        n = normal[k, 0], normal[k, 1], normal[k, 2]
        turning = omega[k, 0], omega[k, 1], omega[k, 2]
        others = None, turning, 0.0, roughness, None, k, 2, False, False, 7
        code = sampler.numba.rebound(handle, v, n, 1e-5, *others, out[k])
        if code < 0:
            return code
    return 0


class TestCompiledCode:
    """`model.handle` serves functions that numba compiles."""

    def test_states(self):
        alpha, speed, spin = mixed_impacts(300)
        inertia, out = np.full(300, 0.3), np.empty((300, 6))
        assert _states_in_numba(model().handle, alpha, speed, spin, inertia, out) == 0
        given = {"spin": spin, "inertia": inertia, "index": np.arange(300), "hit": 2}
        np.testing.assert_array_equal(out, model().sample(alpha, speed, seed=7, **given))

    @pytest.mark.parametrize("roughness", [0.0, 0.2])
    def test_rebounds(self, roughness):
        velocity, normal, omega = lab_impacts(300)
        out, works = np.empty((300, 9)), np.empty((300, 2))
        assert _rebounds_in_numba(model().handle, velocity, normal, omega, roughness, out) == 0
        given = {"omega": omega, "roughness": roughness or None, "works": works}
        keys = {"seed": 7, "index": np.arange(300), "hit": 2}
        after = model().rebound(velocity, normal, 1e-5, **given, **keys)
        expected = np.column_stack([after.velocity, after.omega, after.inertia, works])
        np.testing.assert_array_equal(out, expected)
