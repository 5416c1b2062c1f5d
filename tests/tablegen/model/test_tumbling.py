"""Free tumbling: phases in closed form, the reach of a grain, and orientations that are drawn."""

import numpy as np
import pytest
from crowds import CROWD
from motion_fixtures import (
    NON_SPHERICAL,
    PAIR,
    POPULATION,
    angular_momentum_of,
    body_of,
    energy_of,
    fly,
    kernel_condition,
    motion_of,
    place_before_impact,
    random_aspect,
    random_rotations,
    rotation_of,
)
from one_particle import prepared_rows
from scipy.integrate import solve_ivp
from scipy.special import ellipj, ellipk, ellipkinc
from scipy.stats import ks_2samp, kstest

from tablegen.model.reach import MARGIN, _reach_of_box, tumbling_reach
from tablegen.model.shapes import support_depth
from tablegen.model.tumbling import axes_of_tumbling, jacobi, momentum_direction
from tablegen.simulation.simulate import make_condition, simulate_condition

#: Moments over m a^2: generic, long, flat, of a needle and a disc, and of thin bodies.
MOMENTS = [
    (0.13, 0.25, 0.31),
    (0.1, 0.3, 0.3),
    (0.2, 0.2, 0.4),
    (0.1, 0.3, 0.3 * (1 + 1e-13)),
    (0.2, 0.2 * (1 + 1e-13), 0.4),
    (1e-6, 0.2, 0.2000005),
    (0.1999999, 0.2, 0.4),
]


def inertias(moments):
    """Return inertias at both ends, at the separatrix, beside these, and in between."""
    first, second, third = moments
    share = np.array([0.0, 1e-12, 1e-3, 0.2, 0.5, 0.8, 1.0 - 1e-3, 1.0])
    beside = second * (1.0 + np.array([-1e-3, -1e-6, -1e-14, 0.0, 1e-14, 1e-6, 1e-3]))
    return np.clip(np.concatenate([first + (third - first) * share, beside]), first, third)


def rate_and_parameter(moments, inertia):
    """Rate of the argument of Jacobi's functions at |L| = 1, and their parameter."""
    i1, i2, i3 = 1.0 / np.array(moments)
    x = 1.0 / inertia
    if x < i2:
        return np.sqrt((i2 - i3) * (i1 - x)), (i1 - i2) * (x - i3) / ((i2 - i3) * (i1 - x))
    return np.sqrt((i1 - i2) * (x - i3)), (i2 - i3) * (i1 - x) / ((i1 - i2) * (x - i3))


@pytest.mark.parametrize("complement", [1.0, 0.9, 0.5, 1e-2, 1e-4, 1e-8, 1e-12, 2.0**-53])
def test_elliptic_functions_are_those_of_scipy(complement):
    turn = np.linspace(0.0, 1.0, 201)
    computed = np.array([jacobi(t, complement) for t in turn])
    m = 1.0 - complement
    if complement > 1e-6:  # next to 1 a parameter has lost the digits of its complement
        expected = np.column_stack(ellipj(4.0 * ellipk(m) * turn, m)[:3])
        np.testing.assert_allclose(computed, expected, atol=1e-10)
    sn, cn, dn = computed.T
    np.testing.assert_allclose(sn**2 + cn**2, 1.0, rtol=1e-15)
    np.testing.assert_allclose(dn**2, complement + m * cn**2, rtol=1e-9, atol=1e-16)


@pytest.mark.parametrize("moments", MOMENTS)
def test_directions_have_the_inertia_that_was_asked_for(moments):
    for inertia in inertias(moments):
        for turn in (1e-10, 0.1, 0.25, 0.37, 0.5, 0.75, 0.9999):
            for positive in (False, True):
                direction = np.array(momentum_direction(moments, inertia, turn, positive))
                assert abs(direction @ direction - 1.0) < 1e-14
                assert abs(inertia * (direction**2 / moments).sum() - 1.0) < 1e-13


@pytest.mark.parametrize("moments", [*MOMENTS[:3], MOMENTS[5]])
@pytest.mark.parametrize("positive", [False, True])
def test_phases_are_uniform_in_time(moments, positive):
    """Equal parts of the period by an integration of Euler's equations, dl/dt = l x (l / J)."""
    first, second, third = moments
    between = first + (third - first) * np.array([1e-3, 0.2, 0.5, 0.8, 1.0 - 1e-3])
    # from a first direction on the separatrix an integration leaves it on any side
    beside = [second * (1.0 + x) for x in (-1e-4, 1e-4)] if first < second < third else []
    turns = np.linspace(0.0, 1.0, 33)[:-1] + 1e-9
    for inertia in [*between, *beside]:
        rate, m = rate_and_parameter(moments, inertia)
        if not rate > 0.0:
            continue
        times = 4.0 * ellipk(m) / rate * turns * (1.0 if positive else -1.0)
        directions = np.array([momentum_direction(moments, inertia, t, positive) for t in turns])
        exact = solve_ivp(
            lambda _, x: np.cross(x, x / moments),
            (times[0], times[-1]),
            directions[0],
            t_eval=times,
            rtol=1e-11,
            atol=1e-13,
            method="DOP853",
        )
        np.testing.assert_allclose(directions, exact.y.T, atol=1e-6)


@pytest.mark.parametrize("moments", MOMENTS)
def test_momentum_and_energy_are_exactly_those_of_the_four_numbers(moments):
    rng = np.random.default_rng(1)
    for inertia in inertias(moments):
        spin = rng.normal(size=3) * 10.0 ** rng.uniform(-6, 1)
        n, x = map(np.array, axes_of_tumbling(moments, inertia, tuple(spin), rng.random(3)))
        rotation = np.array([x, n, np.cross(x, n)])
        np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-14)
        body = body_of("ellipsoid")._replace(moments=moments)
        motion = motion_of(rotation)
        condition = kernel_condition(make_condition(1.0, 100.0, spin, inertia=inertia))
        place_before_impact(condition, body, motion)
        scale = inertia * np.linalg.norm(spin)
        momentum = angular_momentum_of(moments, motion)
        np.testing.assert_allclose(momentum, inertia * spin, atol=1e-12 * scale)
        energy = 0.5 * inertia * spin @ spin
        assert energy_of(moments, motion) == pytest.approx(energy, rel=1e-12)


def drawn(population, condition, count=20_000, seed=3):
    """Rotations from body to wall axes, (n, 3, 3), and grains."""
    rows, prepared = prepared_rows(population, condition, count, seed)
    n, x = prepared[:, :3], prepared[:, 3:6]
    return np.stack([x, n, np.cross(x, n)], axis=1), rows.grain


class TestDrawn:
    """Orientations of particles; false-alarm rate of each test 1e-6 or less."""

    SPIN = np.array([0.3, -0.2, 0.5])

    def directions(self, rotations):
        return np.einsum("nij,i->nj", rotations, self.SPIN / np.linalg.norm(self.SPIN))

    def test_turn_about_the_spin_uniformly_and_to_either_side(self):
        grains = POPULATION.restricted_to("ellipsoid").with_aspect(0.8, 0.7)
        moments = np.array(body_of("ellipsoid", 0.8, 0.56).moments)
        for inertia in (0.9 * moments[2] + 0.1 * moments[1], 0.9 * moments[0] + 0.1 * moments[1]):
            rotations, _ = drawn(grains, make_condition(0.5, 100.0, self.SPIN, inertia=inertia))
            along = self.directions(rotations)
            np.testing.assert_allclose((along**2 / moments).sum(axis=1), 1.0 / inertia, rtol=1e-13)
            side = along[:, 2 if inertia > moments[1] else 0] > 0.0
            assert abs(side.mean() - 0.5) < 4.9 * 0.5 / np.sqrt(len(side))
            # about the spin, the angle of a body axis from the wall normal
            spin = self.SPIN / np.linalg.norm(self.SPIN)
            zero = np.cross(spin, [0.0, 1.0, 0.0])
            across = np.cross(spin, zero)
            axis = rotations[:, :, 1]
            zero, across = zero / np.linalg.norm(zero), across / np.linalg.norm(across)
            angle = np.arctan2(axis @ across, axis @ zero)
            for part in (slice(None), side, ~side):
                assert kstest(angle[part], "uniform", (-np.pi, 2.0 * np.pi)).pvalue > 1e-7

    def test_tumble_at_a_phase_that_is_uniform_in_time(self):
        grains = POPULATION.restricted_to("ellipsoid").with_aspect(0.8, 0.7)
        moments = np.array(body_of("ellipsoid", 0.8, 0.56).moments)
        i1, i2, i3 = 1.0 / moments
        for inertia in (0.9 * moments[2] + 0.1 * moments[1], 0.9 * moments[0] + 0.1 * moments[1]):
            rotations, _ = drawn(grains, make_condition(0.5, 100.0, self.SPIN, inertia=inertia))
            first, second, third = self.directions(rotations).T
            x = 1.0 / inertia
            if x < i2:
                sn = second * np.sqrt((i2 - i3) / (x - i3))
                cn = first * np.sqrt((i1 - i3) / (x - i3))
            else:
                sn = second * np.sqrt((i1 - i2) / (i1 - x))
                cn = third * np.sqrt((i1 - i3) / (i1 - x))
            parameter = rate_and_parameter(moments, inertia)[1]
            time = ellipkinc(np.arctan2(sn, cn), parameter) / ellipk(parameter)
            assert kstest(time, "uniform", (-2.0, 4.0)).pvalue > 1e-7

    @pytest.mark.parametrize(
        ("aspect", "inertia"), [((0.8, 0.7), 0.0), ((1.0, 1.0), 0.4), ((1.0, 1.0), 0.0)]
    )
    def test_are_uniform_where_the_inertia_is_not_known_or_says_nothing(self, aspect, inertia):
        grains = POPULATION.restricted_to("ellipsoid").with_aspect(*aspect)
        rotations, _ = drawn(grains, make_condition(0.5, 100.0, self.SPIN, inertia=inertia))
        same, _ = drawn(grains, make_condition(0.5, 100.0))
        np.testing.assert_array_equal(rotations, same)

    def test_take_the_nearest_inertia_that_a_grain_can_have(self):
        for inertia, end in ((1e-3, 0), (2.0, 2)):
            rotations, kind = drawn(CROWD, make_condition(0.5, 100.0, self.SPIN, inertia=inertia))
            along = np.abs(self.directions(rotations)[:, end])
            assert along[kind[:, 0] == 0].min() > 1.0 - 1e-12
            spheres = along[kind[:, 0] == 4]
            assert kstest(spheres, "uniform").pvalue > 1e-7

    def test_rebounds_are_symmetric_about_the_plane_of_impact(self):
        mirror = np.array([1.0, 1.0, -1.0, -1.0, -1.0, 1.0])
        one, two = (
            simulate_condition(
                PAIR,
                POPULATION,
                make_condition(0.3, 100.0, self.SPIN * sign, inertia=0.3),
                20_000,
                seed=seed,
            )
            for seed, sign in ((1, np.ones(3)), (2, mirror[3:]))
        )
        pairs = [*zip(one.state.T, (two.state * mirror).T, strict=True), (one.inertia, two.inertia)]
        assert min(ks_2samp(*pair).pvalue for pair in pairs) > 1e-7
        # seen without the mirror
        assert ks_2samp(one.state[:, 2], two.state[:, 2]).pvalue < 1e-7


@pytest.mark.parametrize("spin", [(0.0, 0.0, 0.0), (0.5, -1.0, 2.0)])
@pytest.mark.parametrize("alpha_deg", [0.05, 3.0, 90.0])
def test_inertia_after_a_rebound_gives_its_energy(spin, alpha_deg):
    condition = make_condition(np.radians(alpha_deg), 50.0, spin, inertia=0.3)
    simulation = simulate_condition(PAIR, CROWD, condition, 3000, seed=5)
    spheres = simulation.shape == 4
    assert (simulation.inertia[spheres] == 0.4).all()
    for number in (0, 1):
        names, grains = ("ellipsoid", "prism"), simulation.aspect[simulation.shape == number]
        ends = np.array([body_of(names[number], b, b * c).moments for b, c in grains])
        inertia = simulation.inertia[simulation.shape == number]
        assert ((ends[:, 0] <= inertia) & (inertia <= ends[:, 2])).all()
        before = 0.5 + 0.5 * np.clip(0.3, ends[:, 0], ends[:, 2]) * np.dot(spin, spin)
        turning = (
            0.5 * inertia * np.sum(simulation.state[simulation.shape == number, 3:] ** 2, axis=1)
        )
        expected = simulation.energy[simulation.shape == number, 1]
        np.testing.assert_allclose(turning / before, expected, rtol=1e-12, atol=1e-14)


class TestReach:
    """The reach is a height at which a tumbling grain never touches the wall."""

    @staticmethod
    def motions(name, count, seed):
        rng = np.random.default_rng(seed)
        for rotation in random_rotations(rng, count):
            body = body_of(name, *random_aspect(rng, 0.1))
            spin = rng.normal(size=3) * (rng.random(3) < 0.7)
            motion = motion_of(rotation)
            if rng.random() < 0.3:  # about an axis, along the normal or across it
                motion = motion_of(np.roll(np.eye(3), rng.integers(3), axis=1))
                motion[3:9] += 1e-9 * rng.normal(size=6)
            motion[0:3] = rotation_of(motion).T @ spin + 1e-12
            yield body, motion

    @pytest.mark.parametrize("name", NON_SPHERICAL)
    def test_is_above_every_phase_and_not_much(self, name):
        excess = []
        for body, motion in self.motions(name, 40, 11):
            momentum = tuple(body.moments * motion[0:3])
            reach = tumbling_reach(body, momentum, tuple(motion[3:6]))
            assert reach <= body.bounding_radius + MARGIN
            rate, deepest = np.linalg.norm(motion[0:3]), 0.0
            for _ in range(400):
                fly(body.moments, motion, 0.9 / rate)
                deepest = max(deepest, support_depth(body, *motion[3:6]))
            assert deepest < reach
            excess.append(reach - deepest)
        assert np.median(excess) < (0.25 if name == "tetrahedron" else 0.1)

    def test_the_reach_of_a_box_is_its_largest_support_within_the_bounds_on_the_normal(self):
        """The largest support of 20,000 normals is less than 0.02 below the largest of all.

        If one axis were set to its bound only where it is too large by a factor of 2, every fifth
        of these boxes would reach too little, by up to 0.17.
        """
        rng, compared = np.random.default_rng(1), 0
        normals = np.abs(rng.normal(size=(20_000, 3)))
        normals /= np.linalg.norm(normals, axis=1)[:, None]
        for half, ends in rng.uniform(0.1, 1.0, (300, 2, 3)):
            inside = normals[(normals <= ends).all(axis=1)]
            if len(inside) < 20:
                continue
            largest = (inside @ half).max()
            assert largest <= _reach_of_box(tuple(half), tuple(ends)) < largest + 0.02
            compared += 1
        assert compared > 100

    def test_the_rounding_of_a_cosine_near_one_is_within_the_margin(self):
        tilt = 1e-8  # its cosine is 1 in double precision
        reach = tumbling_reach(body_of("prism", 0.95, 0.3), (0.0, 0.0, 1.0), (tilt, 0.0, 1.0))
        assert reach > 0.3 + tilt

    def test_flat_discs_reach_as_far_as_they_are_thick_and_rolling_ones_their_radius(self):
        for name in ("ellipsoid", "prism"):
            body = body_of(name, 0.95, 0.3)
            flat = tumbling_reach(body, (0.0, 0.0, 1.0), (0.0, 0.0, 1.0))
            assert flat == pytest.approx(0.3, abs=3e-6)
            rolling = tumbling_reach(body, (0.0, 0.0, 1.0), (0.0, 1.0, 0.0))
            radius = 1.0 if name == "ellipsoid" else np.hypot(1.0, 0.95)
            assert rolling == pytest.approx(radius, abs=3e-6)
