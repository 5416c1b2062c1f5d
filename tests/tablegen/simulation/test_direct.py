"""Direct rebounds of particles with a velocity, a spin and a grain each."""

import numpy as np
import pytest
from crowds import CROWD
from refusals import refused
from scipy.spatial.transform import Rotation

import sampler
import tablegen
from sampler.formats.shape_codes import SHAPE_CODES
from tablegen.config.config import load_config
from tablegen.model.shapes import FIRST_MESH
from tablegen.simulation.batches import BATCH
from tablegen.simulation.direct import DirectModel
from tablegen.simulation.simulate import make_condition, simulate_condition

CONFIG = load_config("corundum-steel")
MODEL, CROWDED = DirectModel(CONFIG), DirectModel(CONFIG, CROWD)
SPIN = (0.3, 0.0, -0.8)
IMPACT = {"alpha1": 0.6, "speed": 120.0, "spin": SPIN}
KEYS = {"seed": 4, "index": np.arange(500), "hit": 1}


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


def quaternions(rotations):
    return rotations.as_quat(scalar_first=True)


class TestAgainstSimulate:
    """One condition: what `tablegen.simulate` gives, to the last bit."""

    @pytest.mark.parametrize(
        ("alpha_deg", "spin"), [(0.2, (0.0, 0.0, 0.0)), (20.0, SPIN), (90.0, (0.0, 3.0, 0.0))]
    )
    def test_own_grains_at_the_first_hit(self, alpha_deg, spin):
        alpha, index = np.radians(alpha_deg), np.arange(300)
        made = tablegen.simulate(CONFIG, alpha, 170.0, 300, seed=7, spin=spin)
        found = MODEL.sample(alpha, 170.0, spin=spin, seed=7, index=index, hit=0)
        np.testing.assert_array_equal(found, made.state)

    def test_fresh_and_given_grains_at_a_later_hit(self):
        condition = make_condition(0.5, 170.0, SPIN)
        made = simulate_condition(CONFIG.pair, CROWD, condition, 300, seed=7, stream=4)
        keys = {"seed": 7, "index": np.arange(300), "hit": 4}
        found = CROWDED.sample(0.5, 170.0, spin=SPIN, grain="fresh", **keys)
        np.testing.assert_array_equal(found, made.state)
        # the same grains given
        np.testing.assert_array_equal(made.mesh >= 0, made.shape == SHAPE_CODES["mesh"])
        codes = np.where(made.mesh < 0, made.shape, FIRST_MESH + made.mesh)
        grains = np.column_stack([codes, made.aspect])
        found = CROWDED.sample(0.5, 170.0, spin=SPIN, grain=grains, **keys)
        np.testing.assert_array_equal(found, made.state)


class TestKeys:
    """Equal keys and conditions give equal states."""

    N = BATCH + 700

    def test_in_any_order_batch_and_number_of_threads(self):
        alpha, speed, spin = mixed_impacts(self.N)
        index, hit = np.arange(self.N), np.arange(self.N) % 5
        whole = MODEL.sample(alpha, speed, spin=spin, seed=1, index=index, hit=hit, threads=2)
        order = np.random.default_rng(2).permutation(self.N)
        for part in (order[:6], order[6:]):
            keys = {"seed": 1, "index": index[part], "hit": hit[part], "threads": 1}
            found = MODEL.sample(alpha[part], speed[part], spin=spin[part], **keys)
            np.testing.assert_array_equal(found, whole[part])

    def test_lab_frame_in_any_order(self):
        velocity, normal, omega = lab_impacts(400)
        keys = {"seed": 1, "index": np.arange(400), "hit": 2}
        turned = np.random.default_rng(3).normal(size=(400, 4))
        whole = CROWDED.rebound(
            velocity, normal, 1e-5, omega=omega, orientation=turned, threads=2, **keys
        )
        for k in (0, 17, 399):
            own = {"omega": omega[k], "orientation": turned[k], "index": k}
            one = CROWDED.rebound(velocity[k], normal[k], 1e-5, seed=1, hit=2, **own)
            assert [part.shape for part in one] == [(3,), (3,), (4,)]
            for part, of_all in zip(one, whole, strict=True):
                np.testing.assert_array_equal(part, of_all[k])

    def test_generators_and_shapes(self):
        one = MODEL.sample(0.5, 100.0, rng=np.random.default_rng(1), size=(2, 3))
        same = MODEL.sample(0.5, 100.0, rng=np.random.default_rng(1), size=(2, 3))
        np.testing.assert_array_equal(one, same)
        many = MODEL.sample(0.5, 100.0, spin=np.zeros((4, 1, 3)), seed=1, index=[[1, 2]], hit=0)
        assert (one.shape, many.shape) == ((2, 3, 6), (4, 2, 6))
        assert MODEL.sample([], 100.0, seed=1, index=3).shape == (0, 6)


class TestGrain:
    """A grain is the particle's own, at every hit; or a fresh one, if that is asked for."""

    def test_own_is_that_of_the_particle_at_every_hit(self):
        grains = CROWDED.grains(5, range(400))
        assert set(grains[:, 0]) == {0, 1, 2, 3, 4, FIRST_MESH, FIRST_MESH + 1}
        for hit in (0, 3):
            keys = {"seed": 5, "index": np.arange(400), "hit": hit}
            own = CROWDED.sample(**IMPACT, **keys)
            given = CROWDED.sample(**IMPACT, grain=grains, **keys)
            np.testing.assert_array_equal(own, given)
            fresh = CROWDED.sample(**IMPACT, grain="fresh", **keys)
            assert (own == fresh).all() == (hit == 0)

    def test_is_that_of_the_table(self):
        table, index = sampler.load("corundum-steel"), np.arange(2000)
        np.testing.assert_array_equal(
            MODEL.grains(2**64 - 3, index), table.grains(2**64 - 3, index)
        )


class TestLabFrame:
    """Walls of any direction and velocity, and particles of any size."""

    def test_is_the_frame_of_the_wall(self):
        alpha, speed, spin = mixed_impacts(500)
        states = MODEL.sample(alpha, speed, spin=spin, **KEYS)
        velocity = speed[:, None] * np.column_stack([np.cos(alpha), -np.sin(alpha), 0.0 * alpha])
        scale = speed[:, None] / 2e-5
        v, omega, _ = MODEL.rebound(velocity, [0.0, 1.0, 0.0], 2e-5, omega=scale * spin, **KEYS)
        # last digits of the angle grow in a long chain of collisions
        assert np.quantile(np.abs(v / speed[:, None] - states[:, :3]), 0.99) < 1e-12
        assert np.abs(v / speed[:, None] - states[:, :3]).max() < 1e-6
        assert np.abs(omega / scale - states[:, 3:]).max() < 1e-6

    def test_turns_and_moves_with_the_wall(self):
        velocity, normal, omega = lab_impacts(500)
        turn, moves = Rotation.random(random_state=3), np.array([30.0, -200.0, 7.0])
        poses = Rotation.random(500, random_state=4)
        v, after, left = MODEL.rebound(
            velocity, normal, 1e-5, omega=omega, orientation=quaternions(poses), **KEYS
        )
        turned, spun, posed = MODEL.rebound(
            turn.apply(velocity) + moves,
            3.0 * turn.apply(normal),
            2e-5,
            omega=turn.apply(omega) / 2.0,
            orientation=-3.0 * quaternions(turn * poses),
            wall_velocity=moves,
            **KEYS,
        )
        assert np.abs(turned - moves - turn.apply(v)).max() < 1e-5
        assert np.abs(2.0 * spun - turn.apply(after)).max() < 1.0
        off = turn * Rotation.from_quat(left, scalar_first=True)
        off *= Rotation.from_quat(posed, scalar_first=True).inv()
        assert off.magnitude().max() < 1e-5
        assert (posed[:, 0] >= 0.0).all()
        np.testing.assert_allclose(np.linalg.norm(posed, axis=1), 1.0, rtol=1e-14)
        assert (np.einsum("nk,nk->n", v, normal) > 0.0).all()


WALL = {"alpha1": 0.5, "speed": 100.0, "seed": 1, "index": [4, 5], "hit": 0}
LAB = {"velocity": [1.0, -1.0, 0.0], "normal": [0.0, 1.0, 0.0], "half_size": 1e-5}
LAB |= {"seed": 1, "index": [4, 5], "hit": 0}

REFUSED = [
    *((WALL, "alpha1", {"alpha1": x}) for x in ([0.5, 1.6], np.nan)),
    (WALL, "speed", {"speed": [1.0, 0.0]}),
    (WALL, "orientation", {"orientation": [1.0, 0.0, 0.0]}),
    (LAB, "orientation", {"orientation": np.eye(2, 4, -1)}),
    (WALL, "spin", {"spin": [1.0, 2.0]}),
    (WALL | {"alpha1": 1e-3}, "spin", {"spin": [[0.0, 0.0, 1.0], [0.0, 0.0, 501.0]]}),
    (WALL | {"speed": 9.0}, "alpha1", {"spin": [1001.0, 0.0, 0.0]}),
    (WALL, "grain", {"grain": "old"}),
    *(
        (WALL, "grain", {"grain": [[0.0, 1.0, 1.0], grain]})
        for grain in ((0, 1.1, 1), (4, 1, 0.9), (FIRST_MESH, 1, 1), (np.nan, 1, 1))
    ),
    (WALL, "index", {"index": None}),
    (LAB, "velocity", {"velocity": [[1.0, -1.0, 0.0], [1.0, 1.0, 0.0]]}),
    (LAB, "normal", {"normal": [0.0, 0.0, 0.0]}),
    (LAB, "half_size", {"half_size": [1e-5, 0.0]}),
    (LAB, "omega", {"omega": [0.0, 1e12, 0.0]}),
]


@pytest.mark.parametrize(("usual", "field", "change"), REFUSED)
def test_bad_input_is_refused_in_one_line(usual, field, change):
    refused(field, MODEL.sample if "alpha1" in usual else MODEL.rebound, **usual | change)


def test_first_bad_row_is_named_whatever_the_batches():
    alpha = np.full(3 * BATCH, 0.5)
    alpha[[BATCH + 3, 2 * BATCH + 1]] = -1.0
    given = {"seed": 1, "index": range(3 * BATCH), "threads": 2}
    assert f" at row {BATCH + 3} " in refused("alpha1", MODEL.sample, alpha, 100.0, **given)


@pytest.mark.parametrize(
    "resistance", [{}, {"law": "coulomb", "static": 0.4, "dynamic": 0.3, "source": "x"}]
)
def test_works_balance_the_energy_of_spinning_particles(resistance):
    """Energies by the body's own moments, with k = <x^2> / a^2 of an ellipsoid and of a prism."""
    changes = {"spin": False, "domain": {"omega": "departure"}, "model": {"tolerance": 1e-13}}
    pair = {"pair": {"resistance": resistance}} if resistance else {}
    model, n = DirectModel(CONFIG.with_changes(changes | pair)), 400
    rng, works = np.random.default_rng(8), np.empty((400, 2))
    code, b, cb = rng.integers(0, 2, n), *rng.uniform(0.5, 1.0, (2, n))
    c2, k = (b * cb) ** 2, np.where(code == 0, 0.2, 1.0 / 3.0)
    moments = k[:, None] * np.column_stack([b**2 + c2, 1.0 + c2, 1.0 + b**2])
    velocity = 100.0 * np.column_stack([rng.uniform(-1, 1, n), rng.uniform(-1, -0.1, n), 0.0 * b])
    omega, q = rng.normal(0.0, 800.0, (n, 3)), rng.normal(size=(n, 4))
    q /= np.linalg.norm(q, axis=1)[:, None]
    given = {"omega": omega, "orientation": q, "grain": np.column_stack([code, b, cb])}
    given |= {"seed": 1, "index": np.arange(n), "hit": 0}
    after = model.rebound(velocity, [0.0, 1.0, 0.0], 0.1, works=works, **given)

    def energy(velocity, omega, q):
        own = Rotation.from_quat(q, scalar_first=True).inv().apply(omega)
        return (velocity**2).sum(axis=1) + 0.01 * (moments * own**2).sum(axis=1)

    before = energy(velocity, omega, q)
    lost = 0.5 * (before - energy(*after))  # J/kg
    np.testing.assert_allclose(works.sum(axis=1), lost, rtol=0, atol=1e-12 * before.max())
    assert (works >= 0.0).all()
    assert (works.min(axis=0) < 0.05 * (velocity**2).sum(axis=1).max()).all()
