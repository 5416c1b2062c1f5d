"""Building blocks of the configuration records: base class and field types.

Records are strict (no text where a number belongs), closed (an unknown field is an error) and
frozen. A field's bounds stand once, in its type; `tablegen.config.messages` tells a user.
"""

import json
from itertools import pairwise
from typing import Annotated, Self, TypeVar

from pydantic import AfterValidator, BaseModel, ConfigDict, Field

from sampler.formats.bounds import is_line, is_text
from sampler.formats.channels import MOST_NAMES, VARIABLES, channels_for
from tablegen.model.model_bounds import ALPHA_DEG, ASPECT, SPEED

Item = TypeVar("Item")


class Record(BaseModel):
    """Base of every part of a configuration: closed, frozen, strict, finite numbers only."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, allow_inf_nan=False)

    @classmethod
    def from_tree(cls, tree: object) -> Self:
        """Validate a tree of TOML tables.

        It goes through JSON, where a strict record of tuples takes the lists of a file.

        Parameters
        ----------
        tree : dict
            Nested as in the file.

        Returns
        -------
        Record

        Raises
        ------
        ValidationError
            If it is not such a record.
        """
        # no field takes a date, which JSON does not have; a list with its text is refused as well
        return cls.model_validate_json(json.dumps(tree, default=lambda value: [str(value)]))


def _rising(pair: tuple[float, float]) -> tuple[float, float]:
    """Refuse a range whose ends are exchanged."""
    if pair[0] > pair[1]:
        raise ValueError("a range [low, high] with low <= high")
    return pair


def _strictly_increasing(values: tuple[float, ...]) -> tuple[float, ...]:
    """Refuse a list of nodes that stalls or turns back."""
    if any(b <= a for a, b in pairwise(values)):
        raise ValueError("numbers each larger than the one before")
    return values


def _known_component(name: str) -> str:
    """Refuse a name that no variable has."""
    if name not in VARIABLES:
        raise ValueError(", ".join(VARIABLES))
    return name


def _each_once(names: tuple[str, ...]) -> tuple[str, ...]:
    """Refuse a list that repeats itself."""
    if len(set(names)) < len(names):
        raise ValueError("each name once")
    return names


def _few_enough(names: tuple[str, ...]) -> tuple[str, ...]:
    """Refuse more names than a table has room for, and more channels than a draw makes."""
    if len(names) > MOST_NAMES:
        raise ValueError(f"up to {MOST_NAMES} names")
    if len(channels_for(names)) > MOST_NAMES:
        raise ValueError(
            "with work_normal or work_shear no collisions, or not all of omega_x, omega_y, omega_z"
        )
    return names


#: Longest name, in characters: it serves as a file name, and stands in tables.
_NAME_CHARACTERS = 100


def _plain_name(value: str) -> str:
    """Refuse a name that could not serve as a file name everywhere."""
    stem = value.translate(str.maketrans("", "", "._-"))
    plain = value[:1].isalnum() and stem.isalnum() and value.isascii()
    if not plain or len(value) > _NAME_CHARACTERS:
        raise ValueError(
            f"up to {_NAME_CHARACTERS} letters, digits, '.', '_' and '-', "
            "the first a letter or digit"
        )
    return value


def _readable(value: str) -> str:
    """Refuse text that says nothing, or that a terminal would obey."""
    if not value.strip() or not is_text(value):
        raise ValueError("text that is not blank and can be shown")
    return value


def _short_line(value: str) -> str:
    """Refuse text that does not fit on a line, or that a terminal would obey."""
    if not is_line(value) or len(value) > _LINE_CHARACTERS:
        raise ValueError(f"one line of up to {_LINE_CHARACTERS} characters that can be shown")
    return value


#: Longest text that stands on a line with others, in characters.
_LINE_CHARACTERS = 200

#: Free text, not blank, of any number of lines.
Text = Annotated[str, AfterValidator(_readable)]

#: Free text on one line, not blank.
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

#: Variables of the state that a scene asks for.
ComponentNames = Annotated[
    tuple[Annotated[str, AfterValidator(_known_component)], ...],
    Field(min_length=1),
    AfterValidator(_each_once),
    AfterValidator(_few_enough),
]
