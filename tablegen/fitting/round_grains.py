"""Round grains: the outcomes of nearly spherical ellipsoids, less those of a sphere.

A nearly round grain rebounds as a sphere does, but for a scatter that is about proportional to
1 - c/a. Experts of a leaf resolve neither scatter of all sizes nor where spheres begin to roll. So
the outcomes of ellipsoids are stored less those of the sphere that has their mean moment of
inertia, over 1 - c/a; a draw adds these (``rbti_add_spheres`` in C).
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from sampler.formats.bounds import LEAST_FLATNESS
from tablegen.config.config import Config
from tablegen.config.population import Population
from tablegen.model.float_array import FloatArray
from tablegen.model.impacts import GRAZING
from tablegen.simulation.direct import DirectModel

_SPHERES = Population.model_validate({"shapes": {"sphere": 1.0}})


def sphere_laws(config: Config) -> NDArray[np.float64]:
    """Write the laws of contact of a pair as `sphere/laws` has them."""
    law = config.pair.kernel_arguments()
    restitution = law.restitution_law, law.coefficient, law.exponent
    resistance = law.resistance_law, law.strength, law.factor
    numbers = config.model.contact_resolution, *restitution, *resistance, law.numbers.size
    return np.array([*numbers, *law.numbers, *law.resistances])


def less_spheres(config: Config) -> bool:
    """Tell whether outcomes are stored less those of spheres: if all grains are ellipsoids."""
    shapes = config.population.shapes.positive().keys() == {"ellipsoid"}
    return shapes and not config.population.meshes and config.model.contact_resolution <= GRAZING


def sphere_states(config: Config, conditions: FloatArray, ratios: FloatArray) -> FloatArray:
    """Compute the states (n, 6) of spheres in place of grains of ratios (n, 2).

    Conditions (n, 5) are those of `tablegen.fitting.spin_coordinates.coordinates`.
    """
    b, c = ratios[:, 0], ratios.prod(axis=1)
    radius = np.sqrt((1.0 + b * b + c * c) / 3.0)[:, None]
    model = DirectModel.of_parts(config.pair, _SPHERES, config.model)
    keys: dict[str, Any] = {"seed": 0, "index": np.arange(len(ratios)), "hit": 0, "threads": 1}
    states = model.sample(*conditions[:, :2].T, spin=radius * conditions[:, 2:], **keys)
    states[:, 3:] /= radius
    return states


def differences(values: FloatArray, of_spheres: FloatArray, ratios: FloatArray) -> FloatArray:
    """Compute outcomes less those of spheres, over 1 - c/a; of p_v the logarithms, (n, 6)."""
    flat = np.maximum(1.0 - ratios.prod(axis=1), LEAST_FLATNESS)[:, None]
    less = values - of_spheres
    less[:, 1] = np.log(values[:, 1] / of_spheres[:, 1])
    return less / flat
