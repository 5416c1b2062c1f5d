"""Particles through bends, with made-up walls whose outcome is known."""

import dataclasses

import numpy as np
import pytest
from many_hits.cases import BEND, FLOWS, GROUPS, SEPARATOR, follow_flow
from many_hits.flow import BACK, RECORD, SPLIT, THROUGH, Particles, Run, follow_bend, next_inlet
from many_hits.flow_report import cells, density, flow_numbers, flow_text
from many_hits.models import HALF_SIZE
from many_hits.motion import Gas

from sampler.arguments import Rebound

SPEED = 150.0
#: So heavy that they fly straight on; the gas moves them by 1e-4 of the width at most.
HEAVY = Gas(SPEED, 0.1)


def _mirror(hits, seed):
    """Perfect rebound, and a spin of V/a about z."""
    normal = np.broadcast_to(hits.normal, hits.velocity.shape)
    into = (hits.velocity * normal).sum(axis=1)[:, None]
    omega = np.zeros_like(hits.omega)
    omega[:, 2] = np.linalg.norm(hits.velocity, axis=1) / HALF_SIZE
    return Rebound(hits.velocity - 2.0 * into * normal, omega)


def _sticky(hits, seed):
    """Nothing is left of the velocity into the wall."""
    rebound = _mirror(hits, seed)
    return Rebound(0.5 * (rebound.velocity + hits.velocity), rebound.omega)


def _column(flow, name):
    return flow.records[:, RECORD.index(name)]


@pytest.fixture(scope="module")
def mirrored():
    return follow_flow(BEND, HEAVY, _mirror, 400, seed=1)


def test_perfect_rebounds_keep_their_angle_along_the_outer_wall(mirrored):
    """So do paths of light in a whispering gallery."""
    first, second = (mirrored.records[_column(mirrored, "hit") == hit] for hit in (0, 1))
    place, outer, angle = (RECORD.index(name) for name in ("place", "outer", "angle"))
    turn = 0.5 * np.pi * BEND[0].bend.middle
    again = second[(second[:, place] < turn) & (second[:, outer] == 1.0)]
    before = first[np.argsort(first[:, 0])][np.searchsorted(np.sort(first[:, 0]), again[:, 0])]
    assert len(again) > 50
    np.testing.assert_allclose(again[:, angle], before[:, angle], atol=0.3)


def test_first_hits_are_where_straight_lines_meet_the_outer_wall(mirrored):
    first = mirrored.records[_column(mirrored, "hit") == 0]
    bend = BEND[0].bend
    # At the height y a line along x meets the wall where cos(turn) = y / outer.
    turn = first[:, RECORD.index("place")] / bend.middle
    np.testing.assert_allclose(first[:, RECORD.index("angle")], np.degrees(turn), atol=0.2)
    assert len(first) == mirrored.count
    assert np.degrees(turn).max() <= 60.1  # y is at least half of the outer radius


def test_every_particle_leaves_and_is_counted_once(mirrored):
    assert np.isin(mirrored.left, (THROUGH, BACK)).all()
    numbers = flow_numbers("bend", HEAVY, {"direct": mirrored})
    shares = numbers["models"]["direct"]["stages"][0]["shares"]
    assert sum(share["value"] for share in shares.values()) == pytest.approx(1.0)
    assert numbers["models"]["direct"]["hits"]["value"] == pytest.approx(mirrored.hits.mean())


def test_spin_decays_between_hits():
    """By the viscous torque on a sphere, for the time of a flight."""
    light = Gas(SPEED, 20e-6)
    seen = []

    def wall(hits, seed):
        seen.append(hits)
        return _mirror(hits, seed)

    stage = BEND[0]
    ids = np.arange(1)
    x = np.array([[-stage.bend.before], [0.19]])
    v, omega = np.array([[SPEED], [0.0], [0.0]]), np.array([[3e5], [0.0], [1e6]])
    start = Particles(x, v, omega, ids, np.zeros(1, dtype=np.int64), np.zeros(1))
    follow_bend(0, stage, light, Run(wall, 1, 1, 1), start)
    # the gas hardly moves it before the bend, and over a tenth of a metre in it
    flight = (stage.bend.before + 0.07) / SPEED
    left = np.exp(-10.0 / 3.0 * flight / light.response)
    np.testing.assert_allclose(seen[0].omega[0], left * omega[:, 0], rtol=0.2)
    assert left < 0.7


def test_particles_without_a_rebound_slide_to_the_outlet():
    flow = follow_flow(BEND, HEAVY, _sticky, 40, seed=1)
    assert (flow.left == THROUGH).all()
    assert (flow.hits == 1).all()
    assert flow.slid > 100


def test_splitters_take_what_is_outside():
    """A gas that carries its particles along loses the shares of its own flow."""
    dust = Gas(SPEED, 1e-6)
    flow = follow_flow(SEPARATOR, dust, _mirror, 2000, seed=1)
    first, second = (float((left == SPLIT).mean()) for left in flow.left)
    # gas: 0.2 and 0.16; the smallest inertia adds to the first
    assert first == pytest.approx(0.22, abs=0.03)
    assert second == pytest.approx(0.14, abs=0.04)
    assert (flow.left[1] >= 0).sum() == (flow.left[0] == THROUGH).sum()


def test_next_bend_turns_the_particles_with_their_spin():
    stage, bend = SEPARATOR[0], SEPARATOR[1].bend
    x = np.array([[0.1, 0.18], [-0.11, -0.11]])
    v = np.array([[1.0, 0.0], [-9.0, -9.0], [2.0, 0.0]])
    particles = Particles(x, v, v[::-1], np.arange(2), np.ones(2, dtype=np.int64), np.zeros(2))
    there = next_inlet(stage, bend, particles)
    # what was inside is outside, and all fly along the new x
    np.testing.assert_allclose(there.x, [[0.01 - bend.before] * 2, [bend.outer, bend.inner]])
    np.testing.assert_allclose(there.v, [[9.0, 9.0], [-1.0, 0.0], [-2.0, 0.0]])
    # a rotation: vectors keep their angle and their sense
    crossed = np.cross(there.v.T, there.omega.T)[0]
    turned = next_inlet(stage, bend, dataclasses.replace(particles, v=np.cross(v.T, v[::-1].T).T))
    np.testing.assert_allclose(crossed, turned.v[:, 0])


def test_density_is_one_where_particles_keep_to_the_inlet():
    """Before the bend, where heavy particles have not met a wall."""
    flow = follow_flow(BEND, HEAVY, _mirror, 4000, seed=2)
    bend, particles = BEND[0].bend, np.bincount(flow.group, minlength=GROUPS)
    field = density(bend, bend.width, flow.density[0], particles).mean(axis=0)
    # The first steps and the cells half within the bend are left out.
    before = field[1 : np.searchsorted(cells(bend)[0], 0.0) - 1]
    assert len(before) > 4
    assert before.mean() == pytest.approx(1.0, abs=0.05)


def test_report_names_every_model_and_what_there_is_none_of():
    made = {"direct": _mirror, "spheres": _sticky}
    flows = {name: follow_flow(SEPARATOR, HEAVY, wall, 60, seed=3) for name, wall in made.items()}
    numbers = flow_numbers("separator", HEAVY, flows)
    assert len(numbers["stages"]) == len(FLOWS["separator"])
    text = flow_text(numbers, "`command`")
    for heading in ("## Bend 2", "### Impacts on the outer wall", "## Hits", "| 6 | spheres |"):
        assert heading in text
    assert "nan" not in text
