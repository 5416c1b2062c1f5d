"""Base class and field types of the configuration records."""

import json
import re
from itertools import pairwise
from typing import Annotated, Self, TypeVar

from pydantic import AfterValidator, BaseModel, ConfigDict, Field

from sampler.formats.channels import MOST_NAMES, VARIABLES, channels_for
from tablegen.model.model_bounds import ALPHA_DEG, ASPECT, SPEED

Item = TypeVar("Item")


class Record(BaseModel):
    """Base of every part of a configuration: frozen, finite numbers, no unknown fields."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, allow_inf_nan=False)

    @classmethod
    def from_tree(cls, tree: object) -> Self:
        """Validate a tree of TOML tables; raise pydantic's ValidationError.

        The tree is written as JSON first, because a strict record accepts lists as tuples only from
        JSON.
        """
        return cls.model_validate_json(json.dumps(tree, default=str))


def _rising(pair: tuple[float, float]) -> tuple[float, float]:
    if pair[0] > pair[1]:
        raise ValueError("a range [low, high] with low <= high")
    return pair


def _strictly_increasing(values: tuple[float, ...]) -> tuple[float, ...]:
    if any(b <= a for a, b in pairwise(values)):
        raise ValueError("numbers each larger than the one before")
    return values


def _usable_variables(names: tuple[str, ...]) -> tuple[str, ...]:
    if len(set(names)) < len(names) or not set(names) <= set(VARIABLES) or len(names) > MOST_NAMES:
        raise ValueError(f"up to {MOST_NAMES} names, each once, of {', '.join(VARIABLES)}")
    if len(channels_for(names)) > MOST_NAMES:
        raise ValueError(
            "with work_normal or work_shear no collisions, or not all of omega_x, omega_y, omega_z"
        )
    return names


def _plain_name(value: str) -> str:
    if not re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9._-]{0,99}", value):
        raise ValueError("up to 100 letters, digits, '.', '_' and '-', the first a letter or digit")
    return value


def _not_blank(value: str) -> str:
    if not value.strip():
        raise ValueError("text that is not blank")
    return value


def _short_line(value: str) -> str:
    if not value.isprintable() or len(value) > 200:
        raise ValueError("one line of up to 200 characters")
    return value


#: Text that is not blank, of any number of lines.
Text = Annotated[str, AfterValidator(_not_blank)]
#: Text on one line, not blank.
Line = Annotated[Text, AfterValidator(_short_line)]
#: Name that can serve as a file name.
Name = Annotated[str, AfterValidator(_plain_name)]
#: Number above zero.
Positive = Annotated[float, Field(gt=0.0)]
#: Ratio of two half-sizes of a particle, the smaller over the larger.
AspectRatio = Annotated[float, Field(**ASPECT.field)]
#: Values b/a and c/b.
AspectPair = tuple[AspectRatio, AspectRatio]
#: Range of an aspect ratio.
AspectRange = Annotated[AspectPair, AfterValidator(_rising)]
#: Impact angle from the wall, degrees.
Angle = Annotated[float, Field(**ALPHA_DEG.field)]
#: Range of the impact angle; equal ends stand for one angle.
AngleRange = Annotated[tuple[Angle, Angle], AfterValidator(_rising)]
#: Impact speed, m/s.
Speed = Annotated[float, Field(**SPEED.field)]
#: Range of speeds; equal ends stand for one speed.
SpeedRange = Annotated[tuple[Speed, Speed], AfterValidator(_rising)]
#: List of increasing numbers, at least one.
Increasing = Annotated[tuple[Item, ...], Field(min_length=1), AfterValidator(_strictly_increasing)]
#: Names of the variables that a draw gives.
VariableNames = Annotated[tuple[str, ...], Field(min_length=1), AfterValidator(_usable_variables)]
