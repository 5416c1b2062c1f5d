"""Particle populations: shapes with weights, and the law of the aspect ratios."""

from typing import Annotated, Literal, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, ValidationError, model_validator
from scipy.special import ndtr

from sampler.errors import InputError
from tablegen.complaint import shown
from tablegen.fields import AspectPair, AspectRange, Record, refusal

#: Shape numbers in kernels and output files.
SHAPE_CODES = {
    "ellipsoid": 0,
    "prism": 1,
    "truncated-prism": 2,
    "tetrahedron": 3,
    "sphere": 4,
    "mesh": 5,
}

#: Shapes that a population may hold; a mesh needs a file besides its name.
SHAPE_NAMES = tuple(name for name in SHAPE_CODES if name != "mesh")

#: Name of the non-spherical shapes together, with the weights of the population.
MIXTURE = "mixture"

#: Least probability that the range of a truncated normal law must hold. Below it the law would
#: be all tail, and the normal quantile would lose the digits that tell its ends apart.
_LEAST_MASS = 1e-6

Weight = Annotated[float, Field(ge=0.0, le=1e6)]


class PopulationArguments(NamedTuple):
    """A population as arrays and numbers, for kernels."""

    #: int64, (n,): entries of `SHAPE_CODES` with positive weight, increasing.
    shape_codes: NDArray[np.int64]
    #: float64, (n,): running sum of their shares; the last is exactly 1.
    cumulative_weights: NDArray[np.float64]
    #: Fraction of each half-edge at which a truncated prism's corners are cut.
    truncation: float
    #: float64, (2, 4): rows b/a and c/b; columns mean, standard deviation, and the standard
    #: normal probabilities p_low, p_high of the range's ends. With u uniform on (0, 1), a ratio is
    #: mean + sd * normal_quantile(p_low + u * (p_high - p_low)). A fixed ratio has sd = 0. A
    #: sphere ignores the ratios.
    aspect: NDArray[np.float64]


class TruncatedNormalAspect(Record):
    """Both ratios independent, from one normal law cut to a range."""

    distribution: Literal["truncated-normal"]
    #: Mean and standard deviation before the cut.
    mean: Annotated[float, Field(ge=-100.0, le=100.0)]
    standard_deviation: Annotated[float, Field(ge=1e-6, le=100.0)]
    range: AspectRange

    def _ends(self) -> tuple[float, float]:
        """Give the standard normal probabilities of the two ends of the range."""
        low, high = ndtr((np.array(self.range) - self.mean) / self.standard_deviation)
        return float(low), float(high)

    @model_validator(mode="after")
    def _range_holds_probability(self) -> Self:
        low, high = self._ends()
        if not high - low >= _LEAST_MASS:
            raise refusal(
                f"a range that holds at least {_LEAST_MASS:g} of the normal law",
                given=self.range,
                field="range",
            )
        return self

    def kernel_rows(self) -> NDArray[np.float64]:
        """Rows for `PopulationArguments.aspect`: float64, shape (2, 4)."""
        row = (self.mean, self.standard_deviation, *self._ends())
        return np.array([row, row], dtype=np.float64)


class FixedAspect(Record):
    """The same two ratios, b/a and c/b, for every particle."""

    distribution: Literal["fixed"]
    values: AspectPair

    def kernel_rows(self) -> NDArray[np.float64]:
        """Rows for `PopulationArguments.aspect`: float64, shape (2, 4)."""
        return np.array([(value, 0.0, 0.0, 1.0) for value in self.values], dtype=np.float64)


class ShapeWeights(Record):
    """Weight of each shape; shares are weights over their sum, and zero leaves a shape out."""

    ellipsoid: Weight = 0.0
    prism: Weight = 0.0
    truncated_prism: Weight = Field(default=0.0, alias="truncated-prism")
    tetrahedron: Weight = 0.0
    sphere: Weight = 0.0

    @model_validator(mode="after")
    def _some_shape(self) -> Self:
        if not self.positive():
            raise refusal(
                f"a weight above 0 for at least one of {', '.join(SHAPE_NAMES)}",
                given=tuple(self.model_dump().values()),
            )
        return self

    def positive(self) -> dict[str, float]:
        """Shapes with positive weight, in the order of `SHAPE_CODES`."""
        weights = self.model_dump(by_alias=True)
        return {name: weights[name] for name in SHAPE_NAMES if weights[name] > 0.0}


class Population(Record):
    """Shapes with weights, aspect ratios, and how far prisms are truncated."""

    #: f in (0, 1): corners are cut through the points at f times the half-edge from the corner.
    truncation: Annotated[float, Field(gt=0.0, lt=1.0)]
    shapes: ShapeWeights
    aspect: Annotated[TruncatedNormalAspect | FixedAspect, Field(discriminator="distribution")]

    def restricted_to(self, shape: str) -> "Population":
        """Part of the population that has one shape, or all non-spherical ones.

        Parameters
        ----------
        shape : str
            One of `SHAPE_NAMES`, whether or not the population holds it, or "mixture": the
            non-spherical shapes with the weights that they have.

        Returns
        -------
        Population
            A population of spheres has the fixed ratios 1 and 1.

        Raises
        ------
        InputError
            If the shape is unknown, or "mixture" is asked of a population of spheres only.
        """
        if shape == MIXTURE:
            weights = {name: w for name, w in self.shapes.positive().items() if name != "sphere"}
            if not weights:
                raise InputError("shape: got 'mixture', allowed: sphere (the population has only)")
        elif shape in SHAPE_NAMES:
            weights = {shape: 1.0}
        else:
            names = ", ".join((*SHAPE_NAMES, MIXTURE))
            raise InputError(f"shape: got {shown(shape)}, allowed: {names}")
        aspect = self.aspect
        if shape == "sphere":
            aspect = FixedAspect(distribution="fixed", values=(1.0, 1.0))
        shapes = ShapeWeights.model_validate(weights)
        return Population(truncation=self.truncation, shapes=shapes, aspect=aspect)

    def with_aspect(self, ba: float, cb: float) -> "Population":
        """Give every particle the same aspect ratios.

        Parameters
        ----------
        ba, cb : float
            Ratios b/a and c/b of the half-sizes a >= b >= c, in (0, 1].

        Returns
        -------
        Population

        Raises
        ------
        InputError
            If a ratio is not in (0, 1], or other than 1 for a population of spheres.
        """
        try:
            aspect = FixedAspect(distribution="fixed", values=(ba, cb))
        except ValidationError as error:
            allowed = "two ratios b/a and c/b, each above 0 and up to 1"
            raise InputError(f"aspect: got {shown((ba, cb))}, allowed: {allowed}") from error
        if set(self.shapes.positive()) == {"sphere"} and aspect.values != (1.0, 1.0):
            raise InputError(f"aspect: got {shown((ba, cb))}, allowed for spheres: [1, 1]")
        return Population(truncation=self.truncation, shapes=self.shapes, aspect=aspect)

    def kernel_arguments(self) -> PopulationArguments:
        """Write the population as arrays and numbers, for kernels.

        Returns
        -------
        PopulationArguments
        """
        weights = self.shapes.positive()
        shares = np.cumsum(list(weights.values()))
        return PopulationArguments(
            shape_codes=np.array([SHAPE_CODES[name] for name in weights], dtype=np.int64),
            cumulative_weights=shares / shares[-1],
            truncation=self.truncation,
            aspect=self.aspect.kernel_rows(),
        )
