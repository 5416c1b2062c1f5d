"""Named populations that a configuration may ask for, from angular to well-rounded grains.

The names are those of sedimentology (M. C. Powers, J. Sediment. Petrol. 23 (1953) 117-119). The
shapes and aspect ratios for each name are our choice.
"""

from sampler.errors import InputError
from sampler.formats.shape_codes import SHAPE_NAMES
from tablegen.config.complaints import shown
from tablegen.config.scenes import Tree

_CRUSHED = ("prism", "truncated-prism", "tetrahedron")

#: For each name: weights of the shapes, mean and standard deviation of the aspect ratios.
_GRAINS: dict[str, tuple[dict[str, float], float, float]] = {
    "angular": (dict.fromkeys(_CRUSHED, 1.0), 0.8, 0.2),
    "subangular": ({**dict.fromkeys(_CRUSHED, 1.0), "ellipsoid": 3.0}, 0.8, 0.2),
    "subrounded": ({"ellipsoid": 1.0}, 0.8, 0.15),
    "rounded": ({"ellipsoid": 1.0}, 0.88, 0.1),
    "well-rounded": ({"ellipsoid": 1.0}, 0.95, 0.05),
}

#: Names of populations, the most angular first.
GRAINS = tuple(_GRAINS)


def named_population(name: str, origin: str = "") -> Tree:
    """Write out a named population; `origin` is the file that names it, for an error."""
    if name not in _GRAINS:
        allowed = f"{', '.join(GRAINS)}, or a table [population]"
        raise InputError("population", shown(name), allowed, source=origin)
    weights, mean, deviation = _GRAINS[name]
    aspect: Tree = {"distribution": "truncated-normal", "mean": mean}
    aspect |= {"standard_deviation": deviation, "range": [0.5, 1.0]}
    shapes = dict.fromkeys(SHAPE_NAMES, 0.0) | weights
    return {"shapes": shapes, "aspect": aspect, "meshes": []}
