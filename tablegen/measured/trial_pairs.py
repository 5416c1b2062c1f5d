"""The pair, population and wall that some coordinates of the free parameters stand for."""

from collections.abc import Sequence
from functools import reduce

import numpy as np

from tablegen.config.config import Config
from tablegen.config.pairs import MaterialPair
from tablegen.config.population import Population
from tablegen.config.scenes import Tree, merged
from tablegen.measured.parameters import SHAPES, WALL_TILT, Parameter
from tablegen.model.float_array import FloatArray


class TrialPairs:
    """Pairs that differ from a given one in the free parameters.

    Parameters
    ----------
    config : Config
        The given pair.
    parameters : sequence of Parameter
    wall_tilt_deg : float
        Roughness of the wall, unless it is free.

    Attributes
    ----------
    labels : tuple of str
        Of the fitted numbers.
    start, low, high, first, last, step : (p,) float64
        Of all coordinates, as in `Parameter`.
    of_shares : (p,) bool
        Which coordinates decide nothing but the shares of the shapes.
    """

    def __init__(
        self, config: Config, parameters: Sequence[Parameter], wall_tilt_deg: float
    ) -> None:
        self.config = config
        self._parameters = tuple(parameters)
        self._tilt = wall_tilt_deg
        self.labels = tuple(label for p in parameters for label in p.labels)
        self.start, self.low, self.high, self.first, self.last, self.step = (
            np.concatenate([getattr(p, name) for p in parameters])
            for name in ("start", "low", "high", "first", "last", "step")
        )
        self.of_shares = np.repeat(
            [p.name == SHAPES for p in parameters], [p.start.size for p in parameters]
        )
        self._pair = config.pair.model_dump(mode="json", by_alias=True, exclude_none=True)
        self._weights = config.population.shapes.model_dump(by_alias=True)
        self._aspect = config.population.aspect

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the free parameters."""
        return tuple(parameter.name for parameter in self._parameters)

    def _parts(self, x: FloatArray) -> list[FloatArray]:
        ends = np.cumsum([parameter.start.size for parameter in self._parameters])[:-1]
        return np.split(x, ends)

    def numbers(self, x: FloatArray) -> FloatArray:
        """Fitted numbers (k,), one for each label, for coordinates (p,)."""
        parts = zip(self._parameters, self._parts(x), strict=True)
        return np.concatenate([p.scale.values(part) for p, part in parts])

    def slopes(self, x: FloatArray) -> FloatArray:
        """Differentiate the fitted numbers by the coordinates, (k, p)."""
        h = 1e-6 * self.step
        sides = [(self.numbers(x + d), self.numbers(x - d)) for d in np.diag(h)]
        return np.array([(up - down) / (2.0 * s) for (up, down), s in zip(sides, h, strict=True)]).T

    def changes(self, x: FloatArray) -> Tree:
        """Fields of the pair file that differ, with rounded numbers; and the roughness."""
        parts = zip(self._parameters, self._parts(x), strict=True)
        return reduce(merged, [p.changes(p.numbers(part)) for p, part in parts], {})

    def pair(self, x: FloatArray) -> MaterialPair:
        """Laws of contact."""
        tree = merged({"pair": self._pair}, self.changes(x))
        return MaterialPair.from_tree(tree["pair"])

    def population(self, x: FloatArray) -> Population:
        """Particles."""
        given = self.config.population
        changes = self.changes(x).get("population", {})
        new: Tree = {}
        if "shapes" in changes:
            new["shapes"] = type(given.shapes).from_tree({**self._weights, **changes["shapes"]})
        if "aspect" in changes and given.aspect is not None:
            aspect = given.aspect.model_dump(mode="json") | changes["aspect"]
            new["aspect"] = type(given.aspect).from_tree(aspect)
        if "truncation" in changes:
            new["truncation"] = changes["truncation"]
        return given.model_copy(update=new)

    def every_shape(self, x: FloatArray) -> Population:
        """Particles among which is each shape whose share may differ from zero."""
        population = self.population(x)
        if not self.of_shares.any():
            return population
        free = {label.removeprefix(f"{SHAPES}.") for label in self.labels}
        present = {n: 1.0 for n, w in self._weights.items() if w > 0.0 or n in free}
        shapes = type(population.shapes).from_tree(present)
        return population.model_copy(update={"shapes": shapes})

    def shares(self, x: FloatArray) -> FloatArray:
        """Share of each part of `every_shape`, in its order."""
        share = {part.code: part.share for part in self.population(x).strata()}
        return np.array([share.get(part.code, 0.0) for part in self.every_shape(x).strata()])

    def wall_tilt_deg(self, x: FloatArray) -> float:
        """Roughness of the wall, degrees."""
        return float(self.changes(x).get(WALL_TILT, self._tilt))
