"""The accuracy that a table declares or a user asks for, with and without a spin law."""

from typing import Annotated, Any, Literal, NamedTuple, TypeVar

from pydantic import Field, ValidationError, create_model, model_validator

from sampler.errors import InputError
from tablegen.config.complaints import complaint
from tablegen.config.field_types import Record
from tablegen.config.metric_table import (
    JOINT,
    JOINT_METRICS,
    LATER,
    METRICS,
    PRESETS,
    SPIN_PRESETS,
    declared_accuracy,
    metric_of,
)


def _fields_of(limits: dict[str, str]) -> dict[str, Any]:
    """Return the preset, and a field for each limit, given as {limit: metric}."""
    fields: dict[str, Any] = {"preset": (Literal[tuple(PRESETS)], "standard")}
    for limit, metric in limits.items():
        fields[limit] = (Annotated[float, Field(**metric_of(metric).allowed)], ...)
    return fields


_LIMITS = {name: name for name in METRICS}
_SPIN_LIMITS = _LIMITS | {f"{JOINT}{name}": name for name in JOINT_METRICS}
_SPIN_LIMITS |= {name: name for name in LATER}
#: Beginning of the names of the limits of the spin law, where a user asks for an accuracy.
_SPIN = "spin_"

_Accuracy: Any = create_model("_Accuracy", __base__=Record, **_fields_of(_LIMITS))
_SpinAccuracy: Any = create_model("_SpinAccuracy", __base__=Record, **_fields_of(_SPIN_LIMITS))


class AccuracyTargets(_Accuracy):
    """Largest distances from direct simulation that a table declares, by metric.

    A distance that is not given is the preset's.
    """

    @model_validator(mode="before")
    @classmethod
    def _from_preset(cls, given: object) -> object:
        return declared_accuracy(given) if isinstance(given, dict) else given


class JointTargets(NamedTuple):
    """Largest distances of the law of condition and outcome over the impacts of chains."""

    ks: float
    auc: float


class SpinTargets(_SpinAccuracy):
    """Largest distances from direct simulation that a spin law declares.

    Limits named as a metric hold for particles that do not spin, those with ``joint_`` for the law
    of condition and outcome over the impacts of chains, those with ``cell_`` in cells of
    conditions, and those with ``chain_`` after each hit of chains. A distance that is not given is
    the preset's.
    """

    @model_validator(mode="before")
    @classmethod
    def _from_preset(cls, given: object) -> object:
        return declared_accuracy(given, SPIN_PRESETS) if isinstance(given, dict) else given

    @property
    def joint(self) -> JointTargets:
        """Limits over the impacts of chains."""
        return JointTargets(self.joint_ks, self.joint_auc)


_Targets = TypeVar("_Targets", bound=Record)


def asked_accuracy(declared: _Targets, text: str | None) -> _Targets:
    """Read the accuracy that a law is held against: the declared one, changed by a text.

    The text has a preset, limits, or both, separated by commas: "fine", "ks=0.01,auc=0.56",
    "standard,auc=0.6". A preset counts for both laws. Limits of the spin law begin with "spin_",
    such as "spin_ks=0.03", and limits that are not named stay as declared. `InputError` says what
    is wrong with the text.
    """
    if text is None:
        return declared
    record, (limits, spin), prefix = type(declared), _parsed(text), ""
    if isinstance(declared, SpinTargets):
        limits, prefix = spin, _SPIN
    whole = limits if "preset" in limits else {**declared.model_dump(), **limits}
    try:
        return record.model_validate(whole)
    except ValidationError as error:
        raise InputError(f"accuracy: {prefix}{complaint(error, record)}") from error


def _parsed(text: str) -> tuple[dict[str, Any], dict[str, Any]]:
    """Parse the limits of the first-impact law and of the spin law."""
    limits: dict[str, Any] = {}
    spin: dict[str, Any] = {}
    try:
        for word in (part.strip() for part in text.split(",")):
            name, sign, number = (part.strip() for part in word.partition("="))
            of_spin = name.removeprefix(_SPIN)
            if name in PRESETS and not sign:
                limits = {"preset": name, **PRESETS[name]}
                spin = {"preset": name, **SPIN_PRESETS[name]}
            elif name in METRICS:
                limits[name] = float(number)
            elif of_spin != name and of_spin in SPIN_PRESETS["standard"]:
                spin[of_spin] = float(number)
            else:
                raise ValueError(name)
    except ValueError:
        raise InputError(
            f"accuracy: got {text!r}, allowed: {', '.join(PRESETS)}, or limits such as "
            f"ks=0.01,auc=0.56 (of {', '.join(METRICS)}), or both"
        ) from None
    return limits, spin
