"""What the command lines of the examples have in common."""

import argparse
from pathlib import Path

from sampler.errors import InputError
from sampler.files import check_output


def number(low: float, high: float, kind: type = float):
    """Parser of a number from low to high."""

    def parse(text: str):
        try:
            value = kind(text)
        except ValueError:
            value = None
        if value is None or not low <= value <= high:
            allowed = "a whole number" if kind is int else "a number"
            raise argparse.ArgumentTypeError(
                f"got {text!r}, allowed: {allowed} from {low:g} to {high:g}"
            )
        return value

    return parse


def output_file(text: str) -> Path:
    """File that can be written."""
    try:
        return check_output(text)
    except InputError as error:
        raise argparse.ArgumentTypeError(str(error).removeprefix("output: ")) from None


def make_folder(path: Path, first: str) -> None:
    """Make the output folder, and look at its first file, before time is spent on what goes in."""
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(
            f"output: got {path}, allowed: a folder that can be made ({error.strerror})"
        ) from None
    check_output(path / first)
