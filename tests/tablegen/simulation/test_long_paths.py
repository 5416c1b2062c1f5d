"""Forty hits in a cylinder: drawn phases give the same results as kept orientations."""

import numpy as np
import pytest
from kept_orientations import FIRST, SPEED, kept_chain
from one_particle import NO_MAP, shaped_body

from tablegen.config.config import load_config
from tablegen.model.rebound import MOTION_SIZE
from tablegen.model.rotation import set_orientation
from tablegen.model.shapes import MAX_VERTICES
from tablegen.simulation.direct import model_without_warnings

CONFIG = load_config("corundum-steel")
SHAPES = ("ellipsoid", "prism", "truncated-prism", "tetrahedron")
HITS, SIZE = 40, 20e-6

#: Angles [rad] by which a grain tumbles from hit to hit, least and largest: a few turns, and many.
FEW_TURNS, MANY_TURNS = (10.0, 40.0), (60.0, 200.0)

#: Hits whose averages are compared.
SPANS = ((1, 2), (2, 6), (6, 10), (10, 20), (20, 40))


def model_of(shape):
    weights = {name: float(name == shape) for name in SHAPES}
    return model_without_warnings(CONFIG.with_changes({"population": {"shapes": weights}}))


def kept(model, grains, seed, turns=FEW_TURNS):
    """Simulate grains that keep their orientations; return angles and energies, (hits, n)."""
    rng, results = np.random.default_rng(seed), np.empty((2, HITS, len(grains)))
    law, truncation = CONFIG.pair.kernel_arguments(False), CONFIG.population.truncation
    numerics = CONFIG.model.contact_resolution, CONFIG.model.tolerance, 0.0
    for k, (code, b, c) in enumerate(grains):
        storage = np.empty((MAX_VERTICES, 3)), np.zeros(1, dtype=np.int64), NO_MAP
        body = shaped_body(int(code), b, b * c, truncation, *storage)
        motion = np.empty(MOTION_SIZE)
        set_orientation(*rng.random(3), motion)
        angles, energies = rng.uniform(*turns, HITS), np.empty(HITS)
        assert kept_chain(law, body, numerics, motion, angles, energies)
        results[:, :, k] = angles, energies
    return results


def drawn(model, grains, seed, knows=True):
    """Simulate the same by `DirectModel`, which draws phases or whole orientations."""
    n, results = len(grains), np.empty((2, HITS, len(grains)))
    velocity = np.tile(SPEED * np.array([np.cos(FIRST), -np.sin(FIRST), 0.0]), (n, 1))
    normal, omega, inertia = np.tile([0.0, 1.0, 0.0], (n, 1)), np.zeros((n, 3)), np.zeros(n)
    keys = {"seed": seed, "index": np.arange(n), "grain": grains}
    for hit in range(HITS):
        sine = -np.einsum("nk,nk->n", velocity, normal) / SPEED
        after = model.rebound(
            velocity, normal, SIZE, omega=omega, inertia=inertia if knows else None, hit=hit, **keys
        )
        square = np.sum(after.velocity**2, axis=1) / SPEED**2
        results[:, hit] = np.arcsin(np.minimum(sine, 1.0)), square
        scale = 1.0 / np.sqrt(square)[:, None]
        velocity, omega, inertia = after.velocity * scale, after.omega * scale, after.inertia
        across = velocity * [1.0, 1.0, 0.0]
        chord = 2.0 * np.sum(velocity * normal, axis=1) / np.sum(across**2, axis=1)
        normal = normal - chord[:, None] * across
        normal /= np.linalg.norm(normal, axis=1)[:, None]
    return results


def errors_apart(one, other):
    """Differences of the averages over `SPANS` of both, in standard errors, (2, spans)."""
    means = [[part[:, first:last].mean(axis=1) for first, last in SPANS] for part in (one, other)]
    (a, b), n = np.array(means), one.shape[2]  # each (spans, 2, n)
    spread = np.hypot(a.std(axis=2), b.std(axis=2)) / np.sqrt(n)
    return (a.mean(axis=2) - b.mean(axis=2)) / spread


@pytest.mark.parametrize("shape", SHAPES)
def test_drawn_phases_are_as_good_as_kept_orientations(shape):
    """Ten averages of each shape within 4.5 standard errors: false alarms 3e-4 together."""
    model = model_of(shape)
    grains = model.grains(7, np.arange(800))
    orientations = kept(model, grains, 1)
    assert np.abs(errors_apart(orientations, drawn(model, grains, 2))).max() < 4.5
    if shape == "ellipsoid":  # which settle into rolling: that uniform orientations would be seen
        uniform = errors_apart(orientations, drawn(model, grains, 2, knows=False))
        assert np.abs(uniform).max() > 10.0


@pytest.mark.study
@pytest.mark.parametrize("shape", SHAPES)
def test_drawn_phases_are_as_good_as_kept_orientations_of_many_grains(shape):
    """Of 20,000 grains, and of the discs among them."""
    model = model_of(shape)
    grains = model.grains(7, np.arange(20_000))
    orientations, phases = kept(model, grains, 1, MANY_TURNS), drawn(model, grains, 2)
    assert np.abs(errors_apart(orientations, phases)).max() < 4.5
    discs = (grains[:, 1] > 0.9) & (grains[:, 2] < 0.7)
    assert np.abs(errors_apart(orientations[:, :, discs], phases[:, :, discs])).max() < 4.5
    for first, last in SPANS:
        a, b = (np.median(part[0, first:last][:, discs]) for part in (orientations, phases))
        assert abs(a / b - 1.0) < 0.05
