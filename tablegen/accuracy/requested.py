"""Accuracy that a user asks for: a preset, limits, or both."""

from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError

from sampler.errors import InputError
from tablegen.config.complaints import complaint
from tablegen.config.metric_table import METRICS, PRESETS, SPIN_PRESETS
from tablegen.config.targets import SpinTargets

#: Beginning of the names of the limits of the spin law.
_SPIN = "spin_"

_Targets = TypeVar("_Targets", bound=BaseModel)


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
