"""Rebounds of spheres. A spin law states how those of ellipsoids differ from them."""

import numpy as np
from numpy.typing import NDArray

from sampler.formats.shape_codes import SHAPE_CODES
from tablegen.config.config import Config
from tablegen.config.pairs import TabulatedResistance, TabulatedRestitution
from tablegen.config.population import Population, ShapeWeights
from tablegen.model.float_array import FloatArray
from tablegen.simulation.direct_law import DirectLaw, DirectParts
from tablegen.simulation.impact_chains import Impacts, simulate_departures

#: Particles that are all spheres.
_SPHERES = Population(shapes=ShapeWeights(sphere=1.0))


def sphere_laws(config: Config) -> NDArray[np.float64]:
    """Write the laws of contact of a pair as the numbers of ``sphere/laws`` and ``spin/laws``."""
    law = config.pair.kernel_arguments()
    restitution = law.restitution_law, law.coefficient, law.exponent
    resistance = law.resistance_law, law.strength, law.factor
    numbers = config.model.contact_resolution, *restitution, *resistance, law.numbers.size
    return np.array([*numbers, *law.numbers, *law.resistances])


def counts_from_spheres(config: Config, shape_code: int) -> bool:
    """Tell whether outcomes of a shape without spin are differences from a sphere's rebound.

    Those of ellipsoids are, if the laws are tables. Tables have kinks, which a sphere's rebound has
    too, and which experts cannot follow. Ellipsoids under other laws, and shapes with corners under
    all laws, are fitted better by themselves
    (tablegen/fitting/EXPERIMENTS.md, "Nearly round grains").
    """
    tables = isinstance(config.pair.restitution, TabulatedRestitution) and isinstance(
        config.pair.resistance, TabulatedResistance
    )
    return tables and shape_code == SHAPE_CODES["ellipsoid"]


def sphere_rebounds(config: Config, impacts: Impacts) -> FloatArray:
    """Compute the velocities u and v over V of spheres after impacts without spin, (n, 2)."""
    law, count = DirectLaw(DirectParts.from_config(config, _SPHERES)), len(impacts.index)
    spheres = impacts._replace(
        spin=np.zeros((count, 3)),
        inertia=np.zeros(count),
        grain=np.tile([float(SHAPE_CODES["sphere"]), 1.0, 1.0], (count, 1)),
    )
    return simulate_departures(law, spheres, 0, threads=1).states[:, :2]
