"""Grains of the runtime: those of direct simulation, for the same keys."""

import numpy as np
import pytest
from crowds import CROWD
from sampler.drawing.grain import draw_grain

from sampler.formats.grain_law import grain_law
from tablegen.config.config import load_config
from tablegen.model.jit import kernel
from tablegen.model.random_particles import draw_grain as draw_directly
from tablegen.simulation.direct import DirectModel

CONFIG = load_config("corundum-steel")
POPULATIONS = {
    "mixture": CONFIG.population,
    "crowd": CROWD,
    "fixed": CONFIG.population.with_aspect(0.8, 0.7),
    "spheres": CONFIG.population.restricted_to("sphere"),
}


@kernel
def _many(law, seed, index, hit, grains):
    for k in range(index.size):
        grains[k, 0], grains[k, 1], grains[k, 2] = draw_grain(law, seed, index[k], hit)


def law_of(arguments):
    """The law as a table stores it: shares, and the ratios of what draws none."""
    weights = np.diff(arguments.cumulative_weights, prepend=0.0)
    ranges = np.full((weights.size, 2, 2), 0.25)
    ranges[arguments.shape_codes == 4] = 1.0
    b, c = arguments.meshes.sizes[:, 0], arguments.meshes.sizes[:, 1]
    if b.size:
        ranges[-b.size :] = np.stack([b, c / b], axis=1)[:, :, None]
    return grain_law(arguments.shape_codes, weights, arguments.aspect, ranges)


@pytest.mark.parametrize("name", POPULATIONS)
def test_grains_are_those_of_direct_simulation(name):
    model = DirectModel(CONFIG, POPULATIONS[name])
    law, index, grains = law_of(model.arrays.population), np.arange(2000), np.empty((2000, 3))
    seed = np.uint64(2**64 - 3)
    _many(law, seed, index.astype(np.uint64), np.uint32(0), grains)
    np.testing.assert_array_equal(grains, model.grains(2**64 - 3, index))
    # those of another hit are others, and so direct simulation has them
    later = np.empty_like(grains)
    _many(law, seed, index.astype(np.uint64), np.uint32(7), later)
    direct = draw_directly(model.arrays.population, seed, 5, np.uint32(7))
    np.testing.assert_array_equal(later[5], direct)
    assert name == "spheres" or (later != grains).any()


def test_shapes_without_weight_are_left_out():
    law = grain_law([0, 1, 4], [0.0, 3.0, 1.0], np.zeros((2, 4)), np.ones((3, 2, 2)))
    assert law.shape_codes.tolist() == [1, 4]
    assert law.cumulative_weights.tolist() == [0.75, 1.0]
    assert law.fixed_ratios.tolist() == [[0.0, 0.0], [1.0, 1.0]]
