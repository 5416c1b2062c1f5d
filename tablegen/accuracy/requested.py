"""The accuracy that a user asks of a table, in a word or a few numbers."""

from pydantic import ValidationError

from sampler.errors import InputError
from tablegen.config import AccuracyTargets
from tablegen.configuration.messages import complaint
from tablegen.configuration.metric_table import METRICS, PRESETS

_ALLOWED = (
    f"{', '.join(PRESETS)}, or limits such as ks=0.01,auc=0.56 (of {', '.join(METRICS)}), or both"
)


def asked_accuracy(declared: AccuracyTargets, text: str | None) -> AccuracyTargets:
    """Accuracy that a table is held against.

    Parameters
    ----------
    declared : AccuracyTargets
        Of the table; what the text does not name stays so.
    text : str, optional
        A preset, limits, or both, with commas between: "fine", "ks=0.01,auc=0.56",
        "standard,auc=0.6".

    Raises
    ------
    InputError
        If the text is none of these, or a limit is out of range.
    """
    if text is None:
        return declared
    limits: dict[str, float | str] = dict(declared.model_dump())
    for word in (part.strip() for part in text.split(",")):
        name, sign, number = (part.strip() for part in word.partition("="))
        if name in PRESETS and not sign:
            limits = {"preset": name, **PRESETS[name]}
        elif name in METRICS:
            limits[name] = _number(number, text)
        else:
            raise InputError(f"accuracy: got {text!r}, allowed: {_ALLOWED}")
    try:
        return AccuracyTargets.model_validate(limits)
    except ValidationError as error:
        raise InputError(f"accuracy: {complaint(error, AccuracyTargets)}") from error


def _number(text: str, whole: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise InputError(f"accuracy: got {whole!r}, allowed: {_ALLOWED}") from None
