"""Types and options that several commands have: configurations, measurements, bounded numbers."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

from sampler import options
from sampler.errors import InputError
from sampler.limits import Bounds
from sampler.options import Named, Number
from tablegen.config.defaults import VALIDATE_CONDITIONS
from tablegen.model import model_bounds as bounds

#: Name of a material pair or a scene, or the path of its file.
CONFIG = Named(".toml")

#: Name or path of a file of measurements.
MEASURED = Named(".csv")

#: Endings of the names of pictures.
PICTURE_ENDINGS = (".png", ".pdf", ".svg")

Decorator = Callable[[Any], Any]


ANGLE = Number(bounds.ALPHA_DEG)
SPEED = Number(bounds.SPEED)
RATIO = Number(bounds.ASPECT)
SPIN = Number(bounds.SPIN)
INERTIA = Number(bounds.INERTIA)


def count(default: int, text: str, kind: Any = options.COUNT) -> Decorator:
    """Add ``--count``, a number of particles."""
    return click.option(
        "--count", type=kind, default=default, show_default=True, metavar="N", help=text
    )


def conditions(text: str) -> Decorator:
    """Add ``--conditions``, a number of conditions between the nodes of a table."""
    return click.option(
        "--conditions",
        type=options.CONDITIONS,
        default=VALIDATE_CONDITIONS,
        show_default=True,
        help=text,
    )


def speed(text: str) -> Decorator:
    """Add ``--speed``, the impact speed of measured rows that state none."""
    return click.option("--speed", type=SPEED, metavar="M_S", help=text)


def wall_tilt(text: str) -> Decorator:
    """Add ``--wall-tilt``, the roughness of a wall."""
    return click.option(
        "--wall-tilt",
        "wall_tilt_deg",
        type=options.Number(Bounds(0.0, 28.6, " degrees")),
        default=0.0,
        show_default=True,
        metavar="DEG",
        help=text,
    )


def check_written(path: Path) -> None:
    """Check a second file, written beside ``--output``, as ``--output`` itself is checked."""
    options.OUTPUT(path, click.Option(["--output"]), click.get_current_context())


def picture(text: str) -> Decorator:
    """Add ``--picture``, the file of a figure."""
    return click.option(
        "--picture",
        type=options.OUTPUT,
        callback=_check_picture,
        metavar="F.png|pdf|svg",
        help=text,
    )


def _check_picture(_context: click.Context, _option: click.Parameter, path: Path | None) -> Any:
    """Raise `InputError`, before any work, if a picture cannot be drawn."""
    from tablegen.presentation import require_matplotlib

    if path is not None:
        require_matplotlib("--picture")
        if path.suffix.lower() not in PICTURE_ENDINGS:
            allowed = f"a name that ends in {' or '.join(PICTURE_ENDINGS)}"
            raise InputError("--picture", str(path), allowed)
    return path
