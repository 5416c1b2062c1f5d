"""The accuracy that a user asks for of a table, in a word or a few numbers."""

from typing import TypeVar

from pydantic import BaseModel, ValidationError

from sampler.errors import InputError
from tablegen.config.config import AccuracyTargets
from tablegen.config.messages import complaint
from tablegen.config.metric_table import METRICS, PRESETS, SPIN_PRESETS
from tablegen.config.targets import SpinTargets

_ALLOWED = (
    f"{', '.join(PRESETS)}, or limits such as ks=0.01,auc=0.56 (of {', '.join(METRICS)}), or both"
)

#: What the limits of the spin law begin with.
_SPIN = "spin_"

_Limits = dict[str, float | str]
_Targets = TypeVar("_Targets", bound=BaseModel)


def asked_accuracy(declared: AccuracyTargets, text: str | None) -> AccuracyTargets:
    """Accuracy that a table is held against.

    Parameters
    ----------
    declared : AccuracyTargets
        Of the table; what the text does not name stays so.
    text : str, optional
        A preset, limits, or both, with commas between: "fine", "ks=0.01,auc=0.56",
        "standard,auc=0.6". Those of the spin law, such as "spin_ks=0.03", are for
        `asked_spin_accuracy`.

    Raises
    ------
    InputError
        If the text is none of these, or a limit is out of range.
    """
    if text is None:
        return declared
    limits, _ = _parsed(text)
    return _changed(declared, limits, "")


def asked_spin_accuracy(declared: SpinTargets, text: str | None) -> SpinTargets:
    """Accuracy that a spin law is held against; see `asked_accuracy`.

    A preset counts for both; the limits are "spin_ks", "spin_joint_auc" and so on.
    """
    if text is None:
        return declared
    _, limits = _parsed(text)
    return _changed(declared, limits, _SPIN)


def _changed(declared: _Targets, limits: _Limits, prefix: str) -> _Targets:
    """Accuracy with other limits, or of a preset; refuse what is out of range."""
    record = type(declared)
    whole = limits if "preset" in limits else {**declared.model_dump(), **limits}
    try:
        return record.model_validate(whole)
    except ValidationError as error:
        raise InputError(f"accuracy: {prefix}{complaint(error, record)}") from error


def _parsed(text: str) -> tuple[_Limits, _Limits]:
    """Read what is asked of today's law and of the spin law."""
    limits: _Limits = {}
    spin: _Limits = {}
    for word in (part.strip() for part in text.split(",")):
        name, sign, number = (part.strip() for part in word.partition("="))
        of_spin = name.removeprefix(_SPIN)
        if name in PRESETS and not sign:
            limits, spin = {"preset": name, **PRESETS[name]}, {"preset": name, **SPIN_PRESETS[name]}
        elif name in METRICS:
            limits[name] = _number(number, text)
        elif of_spin != name and of_spin in SPIN_PRESETS["standard"]:
            spin[of_spin] = _number(number, text)
        else:
            raise InputError(f"accuracy: got {text!r}, allowed: {_ALLOWED}")
    return limits, spin


def _number(text: str, whole: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise InputError(f"accuracy: got {whole!r}, allowed: {_ALLOWED}") from None
