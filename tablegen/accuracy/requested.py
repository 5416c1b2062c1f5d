"""Accuracy that a user asks for: a preset, limits, or both."""

from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError

from sampler.errors import InputError
from tablegen.config.config import AccuracyTargets
from tablegen.config.messages import complaint
from tablegen.config.metric_table import METRICS, PRESETS, SPIN_PRESETS
from tablegen.config.spin_targets import SpinTargets

#: Beginning of the names of the limits of the spin law.
_SPIN = "spin_"

_Targets = TypeVar("_Targets", bound=BaseModel)


def asked_accuracy(declared: AccuracyTargets, text: str | None) -> AccuracyTargets:
    """Read the accuracy that the first-impact law is held against.

    The text has a preset, limits, or both, separated by commas: "fine", "ks=0.01,auc=0.56",
    "standard,auc=0.6". The declared accuracy holds for limits that it does not name. Limits of the
    spin law, such as "spin_ks=0.03", are ignored here. `InputError` says what is wrong with the
    text.
    """
    return declared if text is None else _changed(declared, _parsed(text)[0], "")


def asked_spin_accuracy(declared: SpinTargets, text: str | None) -> SpinTargets:
    """Read the accuracy that a spin law is held against; see `asked_accuracy`.

    A preset counts for both laws. The limits are "spin_ks", "spin_joint_auc" and so on.
    """
    return declared if text is None else _changed(declared, _parsed(text)[1], _SPIN)


def _changed(declared: _Targets, limits: dict[str, Any], prefix: str) -> _Targets:
    """Change the limits of an accuracy; refuse numbers out of range."""
    record = type(declared)
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
