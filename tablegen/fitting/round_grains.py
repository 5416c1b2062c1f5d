"""Round grains: the outcomes of nearly spherical ellipsoids, less those of a sphere.

A nearly round grain rebounds as a sphere does, but for a scatter that is about proportional to
1 - c/a. Experts of a leaf resolve neither scatter of all sizes nor where spheres begin to roll. So
the outcomes of ellipsoids are stored less those of the sphere that has their mean moment of
inertia, over 1 - c/a; a draw adds these (``rbti_add_spheres`` in C).
"""

import numpy as np
from numpy.typing import NDArray

from sampler.formats.bounds import LEAST_FLATNESS
from tablegen.config.config import Config
from tablegen.config.population import Population
from tablegen.fitting.spin_coordinates import outcomes_of
from tablegen.model.float_array import FloatArray
from tablegen.model.impacts import GRAZING
from tablegen.simulation.direct import DirectModel
from tablegen.simulation.impact_chains import Impacts, energy_factor

#: Moment of inertia of a sphere over m a^2.
_INERTIA = 0.4

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


def sphere_outcomes(config: Config, impacts: Impacts) -> FloatArray:
    """Compute the outcomes p and o (n, 6) of spheres in place of the grains of impacts.

    The spheres have the mean moments of inertia of the grains, and their own energies.
    """
    b, c = impacts.grain[:, 1], impacts.grain[:, 1:].prod(axis=1)
    radius = np.sqrt((1.0 + b * b + c * c) / 3.0)
    spin = radius[:, None] * impacts.spin
    model = DirectModel.of_parts(config.pair, _SPHERES, config.model)
    states = model.sample(
        impacts.alpha1,
        impacts.speed,
        spin=spin,
        inertia=_INERTIA,
        seed=0,
        index=np.arange(len(b)),
        hit=0,
        threads=1,
    )
    inertia = np.full(len(b), _INERTIA)
    return outcomes_of(states, inertia, energy_factor(spin, inertia) ** 2)


def differences(outcomes: FloatArray, of_spheres: FloatArray, ratios: FloatArray) -> FloatArray:
    """Compute outcomes less those of spheres, over 1 - c/a; of p_v the logarithms, (n, 6)."""
    flat = np.maximum(1.0 - ratios.prod(axis=1), LEAST_FLATNESS)[:, None]
    less = outcomes - of_spheres
    less[:, 1] = np.log(outcomes[:, 1] / of_spheres[:, 1])
    return less / flat
