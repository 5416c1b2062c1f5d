"""Between walls: free tumbling, and orientation and angular momentum from one wall to the next."""

import numpy as np
import pytest
from free_rotation import FreeRotation
from motion_fixtures import SHAPES, approach, body_of, motion_of, rotation_of
from refusals import refused
from scipy.spatial.transform import Rotation
from scipy.stats import ks_2samp

from tablegen.config.config import load_config
from tablegen.model.impacts import CONDITION_SIZE, condition_of, lab_conditions
from tablegen.model.jit import kernel
from tablegen.model.orientation import axes_from
from tablegen.simulation.direct import DirectModel

CONFIG = load_config("corundum-steel")
MEAN = DirectModel(CONFIG)
INSTANT = DirectModel(CONFIG.with_changes({"domain": {"omega": "departure"}}))
N, SIZE = 60, 2e-5
IDS = np.arange(N)
KEYS = {"seed": 5, "index": IDS}
FLOOR, ROOF = np.array([0.0, 1.0, 0.0]), np.array([0.0, -1.0, 0.0])
GRAINS = MEAN.grains(5, IDS)
NAMES = {code: name for name, code in SHAPES.items()}
BODIES = [body_of(NAMES[int(code)], ba, ba * cb) for code, ba, cb in GRAINS]
MOMENTS = np.array([body.moments for body in BODIES])

condition_of = kernel(condition_of)  # called from Python here


def matrices(orientation):
    return Rotation.from_quat(orientation, scalar_first=True).as_matrix()


def momentum(orientation, omega, moments=MOMENTS):
    """Angular momenta over m a^2, and twice the energy, of angular velocities of an instant."""
    turn = matrices(orientation)
    body = np.einsum("nji,nj->ni", turn, omega)
    return np.einsum("nij,nj->ni", turn, moments * body), np.sum(moments * body**2, axis=1)


def mean_omega(orientation, omega, moments=MOMENTS):
    """(2T/L^2) L of angular velocities of an instant."""
    of_body, twice_energy = momentum(orientation, omega, moments)
    return of_body * (twice_energy / np.sum(of_body**2, axis=1))[:, None]


@pytest.fixture(scope="module")
def turning():
    """Orientations, angular velocities [rad/s] of the instant, and times of some radians."""
    rng = np.random.default_rng(1)
    omega = 1e6 * rng.normal(size=(N, 3))
    time = rng.uniform(2.0, 6.0, N) / np.linalg.norm(omega, axis=1)
    return Rotation.random(N, random_state=2).as_quat(scalar_first=True), omega, time


class TestTumble:
    """Free rotation, whatever an angular velocity stands for."""

    def test_is_that_of_an_independent_integration(self, turning):
        orientation, omega, time = turning
        turned, after = INSTANT.tumble(orientation, omega, GRAINS, SIZE, time)
        mean = mean_omega(orientation, omega)
        by_mean, kept = MEAN.tumble(orientation, mean, GRAINS, SIZE, time)
        np.testing.assert_array_equal(kept, mean)
        for k, turn in enumerate(matrices(orientation)):
            exact = FreeRotation(MOMENTS[k], motion_of(turn, 1e-6 * omega[k]), 1e6 * time[k])
            end = exact.rotation([1e6 * time[k]])[0]
            np.testing.assert_allclose(matrices(turned[k]), end, atol=1e-8)
            np.testing.assert_allclose(matrices(by_mean[k]), end, atol=1e-8)
            spin = end @ exact.spin([1e6 * time[k]])[0]
            np.testing.assert_allclose(1e-6 * after[k], spin, atol=1e-8)
        # the means in place of the velocities, other grains and constant velocities are seen
        others = GRAINS * [1.0, 1.0, 0.99]
        for wrong in (
            matrices(INSTANT.tumble(orientation, mean, GRAINS, SIZE, time)[0]),
            matrices(MEAN.tumble(orientation, mean, others, SIZE, time)[0]),
            Rotation.from_rotvec(omega * time[:, None]).as_matrix() @ matrices(orientation),
        ):
            assert np.quantile(np.abs(wrong - matrices(turned)).max(axis=(1, 2)), 0.1) > 1e-3

    def test_angular_velocity_is_the_mean_over_a_long_time(self, turning):
        """Weights that vanish smoothly at both ends take the ends' effect away."""
        orientation, omega, _ = turning
        share = (np.arange(1000) + 0.5) / 1000
        weight = np.sin(np.pi * share) ** 4
        for k in range(0, N, 6):
            times = share * 600.0 / np.linalg.norm(omega[k])
            _, passed = INSTANT.tumble(orientation[k], omega[k], GRAINS[k], SIZE, times)
            mean = mean_omega(orientation[[k]], omega[[k]], MOMENTS[[k]])[0]
            found = weight @ passed / weight.sum()
            assert np.linalg.norm(found - mean) < 1e-3 * np.linalg.norm(mean)
            assert np.linalg.norm(omega[k] - mean) > 1e-2 * np.linalg.norm(mean)

    def test_two_halves_are_one_flight_and_no_time_is_none(self, turning):
        orientation, omega, time = turning
        whole = INSTANT.tumble(orientation, omega, GRAINS, SIZE, time)
        half = INSTANT.tumble(orientation, omega, GRAINS, SIZE, 0.5 * time)
        half = INSTANT.tumble(*half, GRAINS, SIZE, 0.5 * time)
        np.testing.assert_allclose(matrices(half[0]), matrices(whole[0]), atol=1e-8)
        np.testing.assert_allclose(half[1], whole[1], atol=1e-8 * np.abs(omega).max())
        none = INSTANT.tumble(-3.0 * orientation, omega, GRAINS, SIZE, 0.0)
        np.testing.assert_allclose(matrices(none[0]), matrices(orientation), atol=1e-15)
        np.testing.assert_allclose(none[1], omega, rtol=1e-12)
        still = MEAN.tumble(orientation, np.zeros(3), GRAINS, SIZE, 1e300)
        np.testing.assert_allclose(matrices(still[0]), matrices(orientation), atol=1e-15)

    @pytest.mark.parametrize(
        ("place", "field", "value"),
        [
            (0, "orientation", np.zeros(4)),
            (1, "omega", (0.0, np.nan, 0.0)),
            (2, "grain", (1.0, 0.8, 2.0)),
            (3, "half_size", -1.0),
            (4, "time", (0.0, 1.1)),
        ],
    )
    def test_wrong_arguments_are_refused(self, place, field, value):
        given = [(1.0, 0.0, 0.0, 0.0), (0.0, 1e6, 0.0), (1.0, 0.8, 0.7), SIZE, (1e-6, 1e-6)]
        given[place] = value
        refused(field, MEAN.tumble, *given)


class TestFromWallToWall:
    """What a particle brings to the second wall is what it took from the first."""

    VELOCITY = np.tile([150.0, -120.0, 30.0], (N, 1))
    FLIGHT = np.linspace(0.0, 2e-5, N)

    def started(self, model, velocity, omega, turned):
        """Angular momentum and twice the energy with which a rebound at `ROOF` starts."""
        impacts = velocity, np.tile(ROOF, (N, 1)), np.full(N, SIZE), np.zeros((N, 3))
        keys = np.uint64(5), IDS.astype(np.uint64), np.ones(N, dtype=np.uint32)
        rows, axes = np.empty((N, CONDITION_SIZE)), np.empty((N, 6))
        assert lab_conditions(impacts, omega, keys, model._arrays.numerics, rows) == (-1, 0)
        assert axes_from(turned, impacts, keys, axes) == (-1, 0)
        found = np.empty((N, 4))
        for k, body in enumerate(BODIES):
            motion = motion_of(np.eye(3))
            motion[3:9] = axes[k]
            approach(condition_of(rows[k]), body, motion)
            e_x = velocity[k] * [1.0, 0.0, 1.0] / np.hypot(velocity[k, 0], velocity[k, 2])
            to_lab = np.column_stack([e_x, ROOF, np.cross(e_x, ROOF)]) @ rotation_of(motion)
            spin = motion[0:3] * np.linalg.norm(velocity[k]) / SIZE
            found[k] = *(to_lab @ (MOMENTS[k] * spin)), MOMENTS[k] @ spin**2
        return found[:, :3], found[:, 3]

    def test_momentum_and_energy_are_those_of_the_departure(self):
        left = INSTANT.rebound(self.VELOCITY, FLOOR, SIZE, hit=0, **KEYS)
        expected, energy = momentum(left.orientation, left.omega)
        scale = np.linalg.norm(expected, axis=1)
        for model in (MEAN, INSTANT):
            # before the flight to rounding, after it to its tolerance
            first = model.rebound(self.VELOCITY, FLOOR, SIZE, hit=0, **KEYS)
            np.testing.assert_array_equal(first.velocity, left.velocity)
            np.testing.assert_array_equal(first.orientation, left.orientation)
            turned, omega = model.tumble(first.orientation, first.omega, GRAINS, SIZE, self.FLIGHT)
            for given, most in (((first.omega, first.orientation), 1e-12), ((omega, turned), 1e-8)):
                found, brought = self.started(model, first.velocity, *given)
                assert np.abs((found - expected) / scale[:, None]).max() < most
                assert np.abs(brought / energy - 1.0).max() < most
        # uniform orientations, and the one velocity taken for the other, break both
        mean = MEAN.rebound(self.VELOCITY, FLOOR, SIZE, hit=0, **KEYS).omega
        uniform = Rotation.random(N, random_state=3).as_quat(scalar_first=True)
        for given in ((mean, uniform), (left.omega, left.orientation)):
            found, brought = self.started(MEAN, left.velocity, *given)
            assert np.median(np.abs(brought / energy - 1.0)) > 0.02
            assert np.median(np.linalg.norm(found - expected, axis=1) / scale) > 0.02


def energies(model, paths, seed, keeps=True):
    """Energies (6, 10,000) at hits of opposite walls, with flights between ``paths`` half-sizes."""
    rng, index, found = np.random.default_rng(seed), np.arange(10_000), []
    velocity = np.tile(240.0 * np.array([np.cos(0.663), -np.sin(0.663), 0.0]), (len(index), 1))
    omega, turned, grains = np.zeros((len(index), 3)), None, model.grains(seed, index)
    for hit in range(6):
        keys = {"omega": omega, "seed": seed, "index": index, "hit": hit}
        keys["orientation"] = turned if keeps else None
        velocity, omega, turned = model.rebound(velocity, (FLOOR, ROOF)[hit % 2], SIZE, **keys)
        found.append((velocity**2).sum(axis=1))
        time = SIZE * rng.uniform(*paths, len(index)) / np.sqrt(found[-1])
        turned, omega = model.tumble(turned, omega, grains, SIZE, time)
    return np.array(found)


def test_chains_that_forget_the_orientation_gain_energy_and_flights_of_any_length_agree():
    """As an independent simulation found: 1.19 times too much energy at the sixth hit.

    Means within 4.5 standard errors, KS within 2.7 (2/n)^(1/2): false alarms 1e-4 together.
    """
    short, long = (energies(MEAN, *given) for given in (((1.5, 4.0), 1), ((50.0, 150.0), 2)))
    forgotten = energies(INSTANT, (0.0, 0.0), 3, keeps=False)
    mean, short_mean, most = (x.mean(axis=1) for x in (long, short, forgotten))
    error = 4.5 * np.hypot(long.std(axis=1), short.std(axis=1)) / 100.0
    ks = [max(map(lambda a, b: ks_2samp(a, b).statistic, x, long)) for x in (short, forgotten)]
    assert ks[0] < 0.038 < ks[1]
    assert (np.abs(short_mean - mean) < error).all()
    assert abs(most[-1] / mean[-1] - 1.19) < 1.2 * error[-1] / mean[-1] + 0.005
    assert (most - mean > error)[3:].all()
