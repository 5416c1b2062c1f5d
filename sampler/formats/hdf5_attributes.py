"""Checks of what a table file says in words: its root attributes, and the units of its datasets.

Programs print them, so they have no characters that control a terminal.
"""

from collections.abc import Callable, Sequence
from typing import Any

from sampler.errors import TableError, shortened
from sampler.formats.bounds import LINE_CHARACTERS, PAIR_BYTES, SPEED, is_line, is_text
from sampler.formats.channels import CHANNELS, VARIABLES, channels_for
from sampler.formats.layout import ATTRIBUTES, OPTIONAL_ATTRIBUTES


def shown(value: Any) -> str:
    """Write a given value short and in one line."""
    return repr(shortened(value)) if isinstance(value, str) else shortened(repr(value))


def _is_pair(value: str) -> bool:
    return is_line(value) and len(value.encode()) <= PAIR_BYTES


def _is_short_line(value: str) -> bool:
    return is_line(value) and len(value) <= LINE_CHARACTERS


def _is_seed(value: int) -> bool:
    return 0 <= value < 2**64


#: Which values of an attribute are allowed, besides those of its type.
_RULES: dict[str, Callable[[Any], bool]] = {
    "pair": _is_pair,
    "config": is_text,
    "software_version": _is_short_line,
    "seed": _is_seed,
}


def check_attributes(given: dict[str, Any], processors: Sequence[str]) -> None:
    """Refuse attributes of another type, out of range, or with what controls a terminal.

    Parameters
    ----------
    given : dict
        ``pair``, ``config``, ``software_version`` and ``seed``.
    processors : sequence of str

    Raises
    ------
    TableError
    """
    for name, holds in _RULES.items():
        kind, meaning = ATTRIBUTES[name]
        # Not isinstance: True is an int, and would be written as another type.
        if type(given[name]) is not kind or not holds(given[name]):
            raise TableError(f"{name}: got {shown(given[name])}, allowed: {meaning}")
    for processor in processors:
        if not processor or not _is_short_line(processor):
            meaning = OPTIONAL_ATTRIBUTES["processors"][1]
            raise TableError(f"processors: got {shown(processor)}, allowed: {meaning}")


def check_names(variables: tuple[str, ...], channels: tuple[str, ...]) -> None:
    """Refuse components and channels that are unknown, occur twice, or are not enough."""
    for name, given, known in (
        ("components", variables, VARIABLES),
        ("channels", channels, CHANNELS),
    ):
        if not given or not set(given) <= set(known) or len(set(given)) < len(given):
            got, allowed = shown(" ".join(given)), f"some of {' '.join(known)}"
            raise TableError(f"{name}: got {got}, allowed: {allowed}")
    missing = [name for name in channels_for(variables) if name not in channels]
    if missing:
        raise TableError(f"channels: {' '.join(missing)} missing, allowed: all the components need")


def check_units(path: str, given: Any, known: str) -> None:
    """Refuse units of a dataset other than its own; those that were left out mislead nobody.

    They do not count in the checksum.
    """
    if given is not None and not (isinstance(given, str) and given == known):
        raise TableError(f"{path}: units: got {shown(given)}, allowed: {known!r}")


def speeds_of(text: str | None) -> tuple[float, float] | None:
    """Two speeds, in m/s, of the attribute ``valid_speed``; None of none."""
    if text is None:
        return None
    meaning = OPTIONAL_ATTRIBUTES["valid_speed"][1]
    try:
        low, high = (float(word) for word in text.split())
    except ValueError:
        raise TableError(f"valid_speed: got {shown(text)}, allowed: {meaning}") from None
    return low, high


def check_valid_speed(speeds: tuple[float, float] | None) -> None:
    """Refuse speeds that are no range."""
    if speeds is not None and not 0.0 <= speeds[0] <= speeds[1] <= SPEED[1]:
        meaning = OPTIONAL_ATTRIBUTES["valid_speed"][1]
        raise TableError(f"valid_speed: got {shown(speeds)}, allowed: {meaning}")
