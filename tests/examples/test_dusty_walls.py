"""The four models of the wall, each against what it stands for."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from dusty_gas.gas import CYLINDER, SPHERE, Flow
from dusty_gas.motion import advance, gap
from dusty_gas.walls import (
    MODELS,
    direct_state,
    make_store,
    make_wall,
    rebound_at_wall,
    sphere_state,
    tabulated,
)
from sampler.compilation.jit import no_refcount_kernel
from sampler.drawing.philox import philox_block, uniform
from scipy.spatial.transform import Rotation
from spin_tables import with_spin_law

import sampler
import tablegen
from sampler.table import Table
from tablegen.config.config import load_config
from tablegen.simulation.simulate import make_condition, simulate_condition

HALF_SIZE = 2e-5
CONDITIONS = [(0.5, 60.0), (17.0, 200.0), (60.0, 120.0), (90.0, 290.0)]


@pytest.fixture(scope="module")
def table():
    return sampler.load("corundum-steel")


@pytest.fixture(scope="module")
def config():
    return load_config("corundum-steel")


@pytest.fixture(scope="module")
def wall_of(config, table):
    return {model: make_wall(model, config, table) for model in MODELS}


def _rebound(wall, velocity, normal, keys, omega=(0.0, 0.0, 0.0)):
    out = np.empty(6)
    keys = (np.uint64(keys[0]), *keys[1:])
    # Vectors of one type, or kernels would be compiled for others.
    velocity, normal, omega = (tuple(map(float, v)) for v in (velocity, normal, omega))
    store = make_store(wall)
    status = rebound_at_wall(wall, velocity, normal, HALF_SIZE, omega, keys, store, out)
    return status, out


@pytest.mark.parametrize(("alpha_deg", "speed"), CONDITIONS)
def test_spheres_are_the_spheres_of_the_model(wall_of, config, alpha_deg, speed):
    out = np.empty(6)
    wall = wall_of["spheres"]
    sphere_state(wall, np.radians(alpha_deg), speed, make_store(wall), out)
    spheres = config.population.restricted_to("sphere")
    condition = make_condition(np.radians(alpha_deg), speed)
    made = simulate_condition(config.pair, spheres, condition, 1, seed=1, threads=1)
    np.testing.assert_allclose(out, made.state[0], atol=1e-13)


@pytest.mark.parametrize(("alpha_deg", "speed"), CONDITIONS)
def test_memoryless_rebounds_are_those_of_simulate(wall_of, config, alpha_deg, speed):
    """The same bits for seed, particle, and the hit for a stream."""
    seed, hit, spin = 12, 3, (1.0, 2.0, 3.0)
    condition = make_condition(np.radians(alpha_deg), speed)
    made = simulate_condition(
        config.pair, config.population, condition, 40, seed=seed, stream=hit, threads=1
    )
    wall, out = wall_of["memoryless"], np.empty(6)
    store = make_store(wall)
    for index in range(40):
        keys = (np.uint64(seed), index, hit)
        direct_state(wall, np.radians(alpha_deg), speed, spin, keys, store, out)
        np.testing.assert_array_equal(out, made.state[index])


def test_direct_rebounds_keep_spin_and_grain(wall_of, config):
    """They are those of the direct model with the spin and the particle's own grain."""
    direct, wall = tablegen.DirectModel(config), wall_of["direct"]
    velocity, normal, omega = [70.0, -60.0, 20.0], [0.6, 0.8, 0.0], [2e6, -3e6, 4e6]
    keys = {"seed": 5, "index": 7, "hit": 2}
    expected = direct.rebound(velocity, normal, HALF_SIZE, omega=omega, **keys)
    _, out = _rebound(wall, velocity, normal, (5, 7, 2), omega)
    np.testing.assert_allclose(out[:3], expected.velocity, rtol=1e-9)
    np.testing.assert_allclose(out[3:], expected.omega, rtol=1e-9)
    for forgets in ({"grain": "fresh"}, {"omega": None}):
        given = {"omega": omega} | forgets
        other = direct.rebound(velocity, normal, HALF_SIZE, **given, **keys)
        assert np.abs(out[:3] - other.velocity).max() > 1.0


@pytest.fixture(scope="module")
def spinning(table):
    """A table that takes a spin, whatever its law is."""
    return Table(with_spin_law(table.contents, codes=(0, 1, 2, 3)))


@pytest.mark.parametrize("name", ["table", "spinning"])
def test_table_rebounds_are_those_of_the_table(config, name, request):
    table = request.getfixturevalue(name)
    wall, before = make_wall("table", config, table), [2e6, -3e6, 4e6]
    velocity, normal = [70.0, -60.0, 20.0], [0.6, 0.8, 0.0]
    given = {"omega": before} if table.has_spin else {}
    for keys in ((1, 2, 0), (2**63, 2**40, 7)):
        v, omega = table.rebound(
            velocity, normal, HALF_SIZE, seed=keys[0], index=keys[1], hit=keys[2], **given
        )
        _, out = _rebound(wall, velocity, normal, keys, before)
        np.testing.assert_array_equal(out, [*v, *omega])


def test_a_table_holds_the_law_of_what_it_is_given(table, spinning):
    assert tabulated(spinning) == "direct"
    assert tabulated(table) == ("direct" if table.has_spin else "memoryless")


@pytest.mark.parametrize("model", MODELS)
def test_rebounds_turn_with_the_wall(wall_of, model):
    rng = np.random.default_rng(3)
    for k in range(20):
        normal = rng.standard_normal(3)
        normal /= np.linalg.norm(normal)
        velocity = rng.standard_normal(3)
        velocity *= -120.0 * np.sign(velocity @ normal) / np.linalg.norm(velocity)
        turn = Rotation.random(random_state=k)
        status, out = _rebound(wall_of[model], velocity, normal, (1, k, 0))
        assert status >= 0
        _, turned = _rebound(wall_of[model], turn.apply(velocity), turn.apply(normal), (1, k, 0))
        np.testing.assert_allclose(turned[:3], turn.apply(out[:3]), atol=1e-8)
        np.testing.assert_allclose(turned[3:], turn.apply(out[3:]), rtol=1e-6, atol=1.0)
        assert out[:3] @ normal > 0.0
        assert np.linalg.norm(out[:3]) <= 120.0 * (1.0 + 1e-12)


@pytest.mark.parametrize("model", MODELS)
def test_law_is_held_at_the_ends_of_its_range(wall_of, model):
    """Slower than the table's least speed the state is that at it; all models count it."""
    least = wall_of[model].limits[2] / np.sqrt(2.0)
    slow, held = [0.2 * least, -0.2 * least, 0.0], [least, -least, 0.0]
    low, edge = (_rebound(wall_of[model], v, [0.0, 1.0, 0.0], (1, 5, 0)) for v in (slow, held))
    assert low[0] == sampler.CLAMPED
    assert edge[0] == 0
    np.testing.assert_allclose(low[1], 0.2 * edge[1], rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize("model", MODELS)
def test_receding_particles_are_refused(wall_of, model):
    assert _rebound(wall_of[model], [0.0, 1.0, 0.0], [0.0, 1.0, 0.0], (1, 1, 0))[0] < 0


def test_azimuth_at_normal_impact_is_uniform(wall_of):
    """Direct simulation; false-alarm rate 1e-6 each."""
    n = 4000
    out = np.array(
        [_rebound(wall_of["direct"], [0, -200.0, 0], [0, 1.0, 0], (1, k, 0))[1] for k in range(n)]
    )
    angle = np.arctan2(out[:, 2], out[:, 0])
    for harmonic in (1, 2):
        resultant = np.abs(np.exp(1j * harmonic * angle).mean())
        # P(n |mean|^2 > x) = exp(-x) for uniform angles
        assert n * resultant**2 < np.log(1e6)
    # the check sees angles that keep to one half of the circle a little
    assert n * np.abs(np.exp(1j * (angle + 0.2 * np.sin(angle))).mean()) ** 2 > np.log(1e6)


@no_refcount_kernel
def _throw(flow, wall, seed, first, count, store, out):
    """Throw particles at the body from close by; how many hits, and how many of them went wrong.

    Wrong: not finite, not away from the wall, faster than before, or inside the body afterwards.
    """
    hits = wrong = 0
    for index in range(first, first + count):
        a, b, c, d = philox_block(seed, index, 1, 9)
        cosine, turn = 2.0 * uniform(a) - 1.0, 6.283185307179586 * uniform(b)
        sine = np.sqrt(1.0 - cosine * cosine)
        normal = (cosine, sine, 0.0)
        if flow.body == SPHERE:
            normal = (cosine, sine * np.cos(turn), sine * np.sin(turn))
        # towards a random point of the body's middle
        speed, steep = 0.25 + 1.25 * uniform(c), uniform(d)
        along = (-normal[1] * speed * (1.0 - steep), normal[0] * speed * (1.0 - steep), 0.0)
        p = (
            1.001 * normal[0],
            1.001 * normal[1],
            1.001 * normal[2],
            along[0] - speed * steep * normal[0],
            along[1] - speed * steep * normal[1],
            along[2] - speed * steep * normal[2],
        )
        hit, _, p = advance(flow, p, 0.04)
        if not hit:
            continue
        hits += 1
        r = np.sqrt(p[0] ** 2 + p[1] ** 2 + (p[2] ** 2 if flow.body == SPHERE else 0.0))
        n = (p[0] / r, p[1] / r, p[2] / r if flow.body == SPHERE else 0.0)
        v = (200.0 * p[3], 200.0 * p[4], 200.0 * p[5])
        status = rebound_at_wall(wall, v, n, 2e-5, (0.0, 0.0, 0.0), (seed, index, 0), store, out)
        good = status >= 0
        for k in range(6):
            good = good and np.isfinite(out[k])
        good = good and out[0] * n[0] + out[1] * n[1] + out[2] * n[2] > 0.0
        before = v[0] ** 2 + v[1] ** 2 + v[2] ** 2
        good = good and out[0] ** 2 + out[1] ** 2 + out[2] ** 2 <= before * (1.0 + 1e-12)
        q = (p[0], p[1], p[2], out[0] / 200.0, out[1] / 200.0, out[2] / 200.0)
        _, _, q = advance(flow, q, 0.04)
        good = good and gap(flow, q) > -1e-14
        if not good:
            wrong += 1
    return hits, wrong


def _throw_all(wall, count, workers=2):
    """Hits and wrong ones of `count` particles thrown at each body."""

    def work(part):
        body, first, size = part
        flow = Flow(body, 0.1, 100.0)
        return _throw(flow, wall, 5, first, size, make_store(wall), np.empty(6))

    size = count // 20
    parts = [(body, k * size, size) for body in (CYLINDER, SPHERE) for k in range(20)]
    with ThreadPoolExecutor(workers) as pool:
        return np.sum(list(pool.map(work, parts)), axis=0)


@pytest.mark.parametrize("model", MODELS)
def test_no_rebound_is_wrong(wall_of, model):
    hits, wrong = _throw_all(wall_of[model], 20_000)
    assert hits > 20_000
    assert wrong == 0


@pytest.mark.study
def test_none_of_a_hundred_million_rebounds_is_wrong(wall_of):
    """Some two minutes on two cores; the hits are found by the tracker's flight."""
    hits, wrong = _throw_all(wall_of["table"], 60_000_000)
    assert hits > 100_000_000
    assert wrong == 0
