"""Building blocks of the configuration records: base class, field types, refusals.

Records are strict (no text where a number belongs), closed (an unknown field is an error) and
frozen. A field's bounds stand once, in its type; `tablegen.configuration.messages` turns them into
words.
"""

from collections.abc import Callable
from itertools import pairwise
from typing import Annotated

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field
from pydantic_core import PydanticCustomError

from sampler.formats.channels import COMPONENTS

#: Error type of `refusal`; tells `tablegen.configuration.messages` that the context holds the whole
#: message.
REFUSED = "refused"


#: What `refusal` is given for a field that must be there.
MISSING = object()


class Record(BaseModel):
    """Base of every part of a configuration: closed, frozen, strict, finite numbers only."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, allow_inf_nan=False)


def refusal(allowed: str, *, given: object = None, field: str = "") -> PydanticCustomError:
    """Error for a value that a rule of our own refuses.

    Parameters
    ----------
    allowed : str
        What the rule allows, to follow the word "allowed:".
    given : object, optional
        The value to report; that of the validated field or record if None. `MISSING` for none.
    field : str, optional
        Dotted path of the offending field, relative to the validated record.

    Returns
    -------
    PydanticCustomError
        To be raised inside a validator.
    """
    # Braces would be read as placeholders of the template, so the text travels as context.
    return PydanticCustomError(
        REFUSED, "{allowed}", {"allowed": allowed, "given": given, "field": field}
    )


def _as_tuple(value: object) -> object:
    """TOML arrays arrive as lists; a frozen record holds tuples."""
    return tuple(value) if isinstance(value, list) else value


def _ordered(allowed: str, low: float, high: float) -> Callable[..., tuple[float, float]]:
    """Make a validator of pairs low < first <= second <= high."""

    def check(pair: tuple[float, float]) -> tuple[float, float]:
        if not low < pair[0] <= pair[1] <= high:
            raise refusal(allowed, given=pair)
        return pair

    return check


def _strictly_increasing(values: tuple[float, ...]) -> tuple[float, ...]:
    """Refuse an empty list of nodes and one that stalls or turns back."""
    if not values or any(b <= a for a, b in pairwise(values)):
        raise refusal("at least one number, each larger than the one before", given=values)
    return values


def _known_components(given: object) -> object:
    """Refuse anything but a list of names of components, each once."""
    names = _as_tuple(given)
    if not isinstance(names, tuple) or not names or any(name not in COMPONENTS for name in names):
        raise refusal(f"a list of some of {', '.join(COMPONENTS)}", given=given)
    if len(set(names)) < len(names):
        raise refusal("each component once", given=given)
    return names


def _plain_name(value: str) -> str:
    """Refuse a name that could not serve as a file name everywhere."""
    stem = value.translate(str.maketrans("", "", "._-"))
    if not (value[:1].isalnum() and stem.isalnum() and value.isascii()):
        raise refusal("letters, digits, '.', '_' and '-', the first a letter or digit")
    return value


def _not_blank(value: str) -> str:
    """Refuse text that says nothing."""
    if not value.strip():
        raise refusal("text that is not blank")
    return value


#: Free text, not blank.
Text = Annotated[str, AfterValidator(_not_blank)]

#: Name that can serve as a file name.
Name = Annotated[str, AfterValidator(_plain_name)]

#: Number above zero.
Positive = Annotated[float, Field(gt=0.0)]

#: Ratio of two half-sizes of a particle, the smaller over the larger.
AspectRatio = Annotated[float, Field(gt=0.0, le=1.0)]

#: Values b/a and c/b.
AspectPair = Annotated[tuple[AspectRatio, AspectRatio], BeforeValidator(_as_tuple)]

#: Range of an aspect ratio.
AspectRange = Annotated[
    tuple[float, float],
    BeforeValidator(_as_tuple),
    AfterValidator(_ordered("two ratios, low <= high, above 0 and up to 1", 0.0, 1.0)),
]

#: Range of the impact angle from the wall, degrees; equal ends stand for one angle.
AngleRange = Annotated[
    tuple[float, float],
    BeforeValidator(_as_tuple),
    AfterValidator(_ordered("two angles, low <= high, above 0 and up to 90 degrees", 0.0, 90.0)),
]

#: Fastest speed that a configuration may name, m/s: far above any flow, far below overflow.
_FASTEST = 1e5

#: Range of speeds, m/s; equal ends stand for one speed.
SpeedRange = Annotated[
    tuple[float, float],
    BeforeValidator(_as_tuple),
    AfterValidator(
        _ordered(f"two speeds, low <= high, above 0 and up to {_FASTEST:g} m/s", 0.0, _FASTEST)
    ),
]

#: Nodes of a table axis.
Nodes = Annotated[
    tuple[float, ...], BeforeValidator(_as_tuple), AfterValidator(_strictly_increasing)
]

#: Components of the state that a scene asks for.
ComponentNames = Annotated[tuple[str, ...], BeforeValidator(_known_components)]
