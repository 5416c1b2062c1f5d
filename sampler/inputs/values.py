"""Parsers of command-line values that refuse what cannot be used, in one line."""

import argparse
import math
from collections.abc import Callable
from pathlib import Path

from sampler.errors import InputError
from sampler.files.atomic import check_output


def number(low: float, high: float, allowed: str) -> Callable[[str], float]:
    """Parser of a finite number in (low, high]."""

    def parse(text: str) -> float:
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not (low < value <= high and math.isfinite(value)):
            raise argparse.ArgumentTypeError(f"got {text!r}, allowed: {allowed}")
        return value

    return parse


def integer(low: int, high: int, allowed: str) -> Callable[[str], int]:
    """Parser of an integer in [low, high]."""

    def parse(text: str) -> int:
        try:
            value = int(text)
        except ValueError:
            value = low - 1
        if not low <= value <= high:
            raise argparse.ArgumentTypeError(f"got {text!r}, allowed: {allowed}")
        return value

    return parse


def output(text: str) -> Path:
    """Parse a file that can be written, checked before any work is done."""
    try:
        return check_output(text)
    except InputError as error:
        raise argparse.ArgumentTypeError(str(error).removeprefix("output: ")) from None
