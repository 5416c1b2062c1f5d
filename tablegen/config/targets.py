"""The accuracy that a table declares or a user asks for, with and without a spin law."""

import math
from collections.abc import Mapping
from typing import Annotated, Any, Literal, TypeVar

from pydantic import Field, ValidationError, create_model, model_validator

from sampler.errors import InputError
from sampler.files import parse_number
from tablegen.config.complaints import complaint
from tablegen.config.field_types import Record
from tablegen.config.metric_table import (
    CHAINS,
    METRICS,
    PRESETS,
    SPIN,
    SPIN_PRESETS,
    Metric,
    declared_accuracy,
)


def _fields_of(limits: Mapping[str, Metric]) -> dict[str, Any]:
    """Make a field for each limit."""
    return {name: (Annotated[float, Field(**m.allowed)], ...) for name, m in limits.items()}


_PRESET: dict[str, Any] = {"preset": (Literal[tuple(PRESETS)], "standard")}
_CHAINS: dict[str, Any] = {
    name: (Annotated[float | None, Field(**metric.allowed)], None)
    for name, metric in CHAINS.items()
}

_Accuracy: Any = create_model("_Accuracy", __base__=Record, **_PRESET, **_fields_of(METRICS))
_SpinAccuracy: Any = create_model("_SpinAccuracy", __base__=_Accuracy, **_CHAINS)


class AccuracyTargets(_Accuracy):
    """Largest distances from direct simulation that a table declares, by metric.

    A distance that is not given is the preset's.
    """

    @model_validator(mode="before")
    @classmethod
    def _from_preset(cls, given: object) -> object:
        return declared_accuracy(given) if isinstance(given, dict) else given


class SpinTargets(_SpinAccuracy):
    """Largest distances from direct simulation that a spin law declares.

    Limits named as a metric hold for particles that do not spin, those with ``chain_`` along
    chains of hits. A distance that is not given is the preset's, and a limit of chains is one of
    `tablegen.config.metric_table.CHAIN_LIMITS`.
    """

    @model_validator(mode="before")
    @classmethod
    def _from_preset(cls, given: object) -> object:
        return declared_accuracy(given, SPIN_PRESETS) if isinstance(given, dict) else given


_Targets = TypeVar("_Targets", bound=Record)


def asked_accuracy(declared: _Targets, text: str | None) -> _Targets:
    """Read the accuracy against which a law is judged: the declared one, changed by a text.

    The text has a preset, limits, or both, separated by commas: "fine", "ks=0.01,auc=0.56",
    "standard,auc=0.6". A preset applies to both laws. Limits of the spin law begin with "spin_",
    such as "spin_ks=0.03". Limits that are not named stay as declared. Raises `InputError` if the
    text cannot be read.
    """
    if text is None:
        return declared
    record, (limits, spin), prefix = type(declared), _parsed(text), ""
    if isinstance(declared, SpinTargets):
        limits, prefix = spin, SPIN
    try:
        return record.model_validate({**declared.model_dump(), **limits})
    except ValidationError as error:
        raise complaint(error, record, prefix).within("accuracy") from error


def _limit(text: str) -> float:
    """Read a limit; raises ValueError if it is no number."""
    value = parse_number(text)
    if math.isnan(value):
        raise ValueError(text)
    return value


def _parsed(text: str) -> tuple[dict[str, Any], dict[str, Any]]:
    """Parse the limits of the law of first impacts and of the spin law."""
    limits: dict[str, Any] = {}
    spin: dict[str, Any] = {}
    try:
        for word in (part.strip() for part in text.split(",")):
            name, sign, number = (part.strip() for part in word.partition("="))
            of_spin = name.removeprefix(SPIN)
            if name in PRESETS and not sign:
                limits = {"preset": name, **PRESETS[name]}
                spin = {"preset": name, **SPIN_PRESETS[name]}
            elif name in METRICS:
                limits[name] = _limit(number)
            elif of_spin != name and of_spin in (*METRICS, *CHAINS):
                spin[of_spin] = _limit(number)
            else:
                raise ValueError(name)
    except ValueError:
        allowed = (
            f"{', '.join(PRESETS)}, or limits such as ks=0.01,auc=0.56 (of {', '.join(METRICS)}), "
            "or both"
        )
        raise InputError("accuracy", repr(text), allowed) from None
    return limits, spin
