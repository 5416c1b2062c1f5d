"""Tables whose grains have the sizes of a population of shapes and meshes; their law is made up."""

import itertools
from dataclasses import replace

import numpy as np
from spin_tables import with_spin_law
from synthetic_table import make_contents

from tablegen.config.population import Population
from tablegen.fitting.law_conditions import ratio_range

#: Ratios b/a and c/b of the shapes, and the fraction at which truncated prisms are cut.
RATIOS, CUT = (0.7, 0.9), 0.3


def _even_points(count):
    """Place points on a sphere, about equally far from each other (Swinbank & Purser 2006)."""
    k = np.arange(count) + 0.5
    angle, z = np.pi * (1.0 + np.sqrt(5.0)) * k, 1.0 - 2.0 * k / count
    across = np.sqrt(1.0 - z * z)
    return np.column_stack([across * np.cos(angle), across * np.sin(angle), z])


#: An octahedron, a cube, and a body that is nearly a sphere.
MESHES = (
    np.concatenate([np.eye(3), -np.eye(3)]),
    np.array(list(itertools.product((1.0, -1.0), repeat=3))),
    _even_points(2000),
)

POPULATION = Population.model_validate(
    {
        "truncation": CUT,
        "shapes": {"ellipsoid": 1.0, "prism": 1.0, "truncated-prism": 1.0, "tetrahedron": 1.0},
        "aspect": {"distribution": "fixed", "values": RATIOS},
        "meshes": tuple({"vertices": tuple(map(tuple, mesh.tolist()))} for mesh in MESHES),
    }
)


def sized_contents():
    """Return the contents of a table with a random spin law, and grains of `POPULATION`."""
    arguments = POPULATION.kernel_arguments()
    codes = [int(code) for code in arguments.shape_codes]
    contents = with_spin_law(make_contents(), codes=codes)
    datasets = contents.datasets | {
        "spin/shape_weights": np.diff(arguments.cumulative_weights, prepend=0.0),
        "spin/ratio_range": np.array([ratio_range(POPULATION, code) for code in codes]),
        "spin/aspect": arguments.aspect,
        "spin/shape_geometry": np.array(list(POPULATION.shape_geometry().values())),
    }
    return replace(contents, datasets=datasets)
