"""Particle populations: shapes and meshes with weights, and the law of the aspect ratios."""

from typing import Annotated, Any, Literal, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import AfterValidator, Field, ValidationError, create_model, model_validator
from scipy.special import ndtr

from sampler.errors import InputError
from sampler.formats.shape_codes import SHAPE_CODES, SHAPE_NAMES
from sampler.formats.shape_geometry import TRUNCATION, Geometry, geometry_of_shape
from tablegen.config.complaints import refusal, shown
from tablegen.config.defaults import MIXTURE
from tablegen.config.field_types import AspectPair, AspectRange, Line, Record
from tablegen.config.particles_text import particles_text
from tablegen.meshes.mesh_file import MeshFile
from tablegen.meshes.particle import MeshParticle, Vertices, cached_particle, mesh_arguments
from tablegen.model.model_bounds import ASPECT
from tablegen.model.shapes import FIRST_MESH, MeshArguments

#: Least probability of the range of a truncated normal law. With less, the two ends of the range
#: would have the same normal quantile by rounding.
_LEAST_MASS = 1e-6

#: Mean aspect ratio above which ellipsoids count as nearly round.
_NEARLY_ROUND = 0.9

Weight = Annotated[float, Field(ge=0.0, le=1e6)]


class PopulationArguments(NamedTuple):
    """A population of n shapes and meshes as kernels take it, as numbers and arrays."""

    #: (n,): codes of the shapes with positive weight, increasing; mesh k has `FIRST_MESH` + k.
    shape_codes: NDArray[np.int64]
    #: (n,): cumulative sum of their shares; the last is exactly 1.
    cumulative_weights: NDArray[np.float64]
    #: Fraction of each half-edge at which a truncated prism's corners are cut.
    truncation: float
    #: (2, 4): rows b/a and c/b; columns mean, standard deviation, and the standard normal
    #: probabilities p_low, p_high of the range's ends. With u uniform on (0, 1), a ratio is
    #: mean + sd * normal_quantile(p_low + u * (p_high - p_low)). A fixed ratio has sd = 0. Spheres
    #: and meshes ignore the ratios.
    aspect: NDArray[np.float64]
    #: The meshes with positive weight.
    meshes: MeshArguments


class TruncatedNormalAspect(Record):
    """Both ratios independent, from the same normal law restricted to a range."""

    distribution: Literal["truncated-normal"]
    #: Mean and standard deviation of the normal law before it is restricted.
    mean: Annotated[float, Field(ge=-100.0, le=100.0)]
    standard_deviation: Annotated[float, Field(ge=1e-6, le=100.0)]
    range: AspectRange

    def _ends(self) -> NDArray[np.float64]:
        """Return the standard normal probabilities of the two ends of the range."""
        return ndtr((np.array(self.range) - self.mean) / self.standard_deviation)

    @model_validator(mode="after")
    def _range_holds_probability(self) -> Self:
        low, high = self._ends()
        if not high - low >= _LEAST_MASS:
            law = f"mean {self.mean:g} and deviation {self.standard_deviation:g}"
            allowed = f"a range that a normal law of {law} reaches (probability {_LEAST_MASS:g})"
            raise refusal("range", self.range, allowed)
        return self

    def kernel_rows(self) -> NDArray[np.float64]:
        """Return the rows of `PopulationArguments.aspect`."""
        row = (self.mean, self.standard_deviation, *self._ends())
        return np.array([row, row], dtype=np.float64)


class FixedAspect(Record):
    """The same two ratios, b/a and c/b, for every particle."""

    distribution: Literal["fixed"]
    values: AspectPair

    def kernel_rows(self) -> NDArray[np.float64]:
        """Return the rows of `PopulationArguments.aspect`."""
        return np.array([(value, 0.0, 0.0, 1.0) for value in self.values], dtype=np.float64)


#: Ratios of spheres.
_ROUND = FixedAspect(distribution="fixed", values=(1.0, 1.0))

_WEIGHTS: dict[str, Any] = {
    name.replace("-", "_"): (Weight, Field(default=0.0, alias=name)) for name in SHAPE_NAMES
}
_Weights: Any = create_model("_Weights", __base__=Record, **_WEIGHTS)


class ShapeWeights(_Weights):
    """Weight of each shape. The share of a shape is its weight over the sum of all weights."""

    def positive(self) -> dict[str, float]:
        """Return the shapes with positive weight, in the order of `SHAPE_CODES`."""
        weights = self.model_dump(by_alias=True)
        return {name: weights[name] for name in SHAPE_NAMES if weights[name] > 0.0}


def _solid(vertices: Vertices) -> Vertices:
    try:
        cached_particle(vertices)
    except InputError as error:
        raise ValueError("4 or more points that span a volume") from error
    return vertices


class MeshShape(Record):
    """A convex particle given by its vertices."""

    #: Name of the file from which the vertices were read, which is not opened again.
    file: Line | None = None
    #: Points whose convex hull is the particle, in any units and axes.
    vertices: Annotated[Vertices, AfterValidator(_solid)]
    weight: Weight = 1.0

    def particle(self) -> MeshParticle:
        """Return the particle with its moments and support map, made once for equal vertices."""
        return cached_particle(self.vertices)


class Stratum(NamedTuple):
    """Part of a population that has one form."""

    #: Code of the shape; FIRST_MESH + k for mesh number k.
    code: int
    #: Weight over the sum of all weights.
    share: float
    population: "Population"


class Population(Record):
    """Shapes and meshes with weights, aspect ratios, and the truncation of prisms."""

    #: f in (0, 1): corners of a truncated prism are cut at f times the half-edge from the corner.
    truncation: Annotated[float, Field(gt=0.0, lt=1.0)] = TRUNCATION
    shapes: ShapeWeights = ShapeWeights()
    #: Ratios of all shapes but spheres; meshes have their own.
    aspect: Annotated[
        TruncatedNormalAspect | FixedAspect | None, Field(discriminator="distribution")
    ] = None
    meshes: tuple[MeshShape, ...] = ()

    @model_validator(mode="after")
    def _some_particle(self) -> Self:
        if not self.shapes.positive() and not self._weighty_meshes():
            allowed = f"a weight above 0 for at least one of {', '.join(SHAPE_NAMES)}, or a mesh"
            raise refusal("shapes", tuple(self.shapes.model_dump().values()), allowed)
        return self

    def __str__(self) -> str:
        """Say in one line which particles there are."""
        without = {"meshes": {"__all__": {"vertices"}}}
        return particles_text(self.model_dump(mode="json", by_alias=True, exclude=without))

    @property
    def lacks_aspect(self) -> bool:
        """Whether a shape needs aspect ratios, and no law of them is given."""
        return self.aspect is None and bool(self.shapes.positive().keys() - {"sphere"})

    @property
    def only_spheres(self) -> bool:
        """Whether all particles are spheres."""
        return self.shapes.positive().keys() == {"sphere"} and not self._weighty_meshes()

    @property
    def nearly_round(self) -> bool:
        """Whether all particles are ellipsoids, with mean aspect ratios above `_NEARLY_ROUND`."""
        if self.shapes.positive().keys() != {"ellipsoid"} or self._weighty_meshes():
            return False
        return bool(self.aspect_rows[:, 0].min() > _NEARLY_ROUND)

    @property
    def shape_codes(self) -> list[int]:
        """Codes of the shapes and meshes with positive weight, as in `PopulationArguments`."""
        shapes = [SHAPE_CODES[name] for name in self.shapes.positive()]
        return shapes + list(range(FIRST_MESH, FIRST_MESH + len(self._weighty_meshes())))

    @property
    def aspect_rows(self) -> NDArray[np.float64]:
        """The law of the ratios, as `PopulationArguments.aspect` has it."""
        return (self.aspect or _ROUND).kernel_rows()

    def mesh_particle(self, shape_code: int) -> MeshParticle:
        """Return the particle of a mesh with positive weight, by its code."""
        return self._weighty_meshes()[shape_code - FIRST_MESH].particle()

    def _weighty_meshes(self) -> tuple[MeshShape, ...]:
        """List the meshes that have a positive weight."""
        return tuple(mesh for mesh in self.meshes if mesh.weight > 0.0)

    def restricted_to(self, shape: str) -> "Population":
        """Select one of `SHAPE_NAMES`, whether or not the population holds it, or the mixture.

        The mixture has all non-spherical shapes and meshes with their weights. Raises `InputError`
        if the shape is unknown, or for the mixture of a population of spheres.
        """
        if shape == MIXTURE:
            weights = {name: w for name, w in self.shapes.positive().items() if name != "sphere"}
            if not weights and not self._weighty_meshes():
                allowed = "'sphere', the only shape of the population"
                raise InputError("shape", f"'{MIXTURE}'", allowed)
        elif shape in SHAPE_NAMES:
            weights = {shape: 1.0}
        else:
            names = ", ".join((*SHAPE_NAMES, MIXTURE))
            raise InputError("shape", shown(shape), names)
        changes = {
            "shapes": ShapeWeights.model_validate(weights),
            "aspect": _ROUND if shape == "sphere" else self.aspect,
            "meshes": self.meshes if shape == MIXTURE else (),
        }
        return self.model_copy(update=changes)

    def strata(self) -> tuple[Stratum, ...]:
        """Split the population into its shapes and meshes of positive weight, in their order."""
        weights, meshes = self.shapes.positive(), self._weighty_meshes()
        total = sum(weights.values()) + sum(mesh.weight for mesh in meshes)
        strata = [
            Stratum(SHAPE_CODES[name], weight / total, self.restricted_to(name))
            for name, weight in weights.items()
        ]
        for k, mesh in enumerate(meshes):
            strata.append(Stratum(FIRST_MESH + k, mesh.weight / total, Population(meshes=(mesh,))))
        return tuple(strata)

    def shape_geometry(self) -> dict[int, Geometry]:
        """Give volume, moment and surface of the shapes and meshes of positive weight, by code."""
        codes = (SHAPE_CODES[name] for name in self.shapes.positive())
        shapes = {code: geometry_of_shape(code, self.truncation) for code in codes}
        meshes = enumerate(self._weighty_meshes(), FIRST_MESH)
        return shapes | {code: mesh.particle().geometry() for code, mesh in meshes}

    def with_mesh(self, mesh: MeshFile) -> "Population":
        """Give all particles the shape of one mesh, from `tablegen.meshes.mesh_file.read_mesh`."""
        meshes = (MeshShape(file=mesh.name, vertices=mesh.vertices),)
        return self.model_copy(update={"shapes": ShapeWeights(), "meshes": meshes})

    def with_aspect(self, ba: float, cb: float) -> "Population":
        """Fix the aspect ratios b/a and c/b of all particles but the meshes.

        Raises `InputError` for a ratio out of range, or other than 1 for a population of spheres.
        """
        try:
            aspect = FixedAspect(distribution="fixed", values=(ba, cb))
        except ValidationError as error:
            allowed = f"two ratios b/a and c/b, each {ASPECT.words}"
            raise InputError("aspect", shown((ba, cb)), allowed) from error
        if self.only_spheres and aspect.values != (1.0, 1.0):
            raise InputError("aspect", shown((ba, cb)), "[1, 1], of spheres")
        return self.model_copy(update={"aspect": aspect})

    def kernel_arguments(self) -> PopulationArguments:
        """Return the population as kernels take it, as numbers and arrays.

        Raises `InputError` if a shape needs aspect ratios and the population has no law for them.
        """
        if self.lacks_aspect:
            shapes = ", ".join(name for name in self.shapes.positive() if name != "sphere")
            problem, remedy = (
                f"is missing for {shapes}",
                "give [population.aspect], or fixed ratios",
            )
            raise InputError("aspect", problem=problem, remedy=remedy)
        weights, meshes = self.shapes.positive(), self._weighty_meshes()
        shares = np.cumsum([*weights.values(), *(mesh.weight for mesh in meshes)])
        return PopulationArguments(
            shape_codes=np.array(self.shape_codes, dtype=np.int64),
            cumulative_weights=shares / shares[-1],
            truncation=self.truncation,
            aspect=self.aspect_rows,
            meshes=mesh_arguments([mesh.particle() for mesh in meshes]),
        )
