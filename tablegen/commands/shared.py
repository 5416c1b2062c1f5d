"""Types and options that several commands share: configurations, measurements, bounded numbers."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

from sampler import options
from sampler.errors import InputError
from sampler.options import Named, Number
from tablegen.config.defaults import VALIDATE_CONDITIONS
from tablegen.model import model_bounds as bounds

#: Name of a material pair or a scene, or the path of its file.
CONFIG = Named(".toml")

#: Name or path of a file of measurements.
MEASURED = Named(".csv")

#: Endings of pictures.
KINDS = (".png", ".pdf", ".svg")

Decorator = Callable[[Any], Any]


def _within(allowed: bounds.Bounds) -> Number:
    return Number(allowed.words, allowed.low, allowed.high)


ANGLE = _within(bounds.ALPHA_DEG)
SPEED = _within(bounds.SPEED)
RATIO = _within(bounds.ASPECT)
SPIN = _within(bounds.SPIN)
INERTIA = _within(bounds.INERTIA)


def count(default: int, text: str, kind: Any = options.COUNT) -> Decorator:
    """Add ``--count``, of particles."""
    how: Any = {"default": default, "show_default": True, "metavar": "N"}
    return click.option("--count", type=kind, help=text, **how)


def conditions(text: str) -> Decorator:
    """Add ``--conditions``, between the nodes of a table."""
    how: Any = {"default": VALIDATE_CONDITIONS, "show_default": True}
    return click.option("--conditions", type=options.CONDITIONS, help=text, **how)


def speed(text: str) -> Decorator:
    """Add ``--speed``, of rows that state none."""
    return click.option("--speed", type=SPEED, metavar="M_S", help=text)


def wall_tilt(text: str) -> Decorator:
    """Add ``--wall-tilt``, of a rough wall."""
    kind, names = options.Number("0 to 28.6 degrees", 0.0, 28.6), ("--wall-tilt", "wall_tilt_deg")
    return click.option(*names, type=kind, default=0.0, show_default=True, metavar="DEG", help=text)


def check_written(path: Path) -> None:
    """Refuse a file that a command makes for its ``--output`` as that would be refused."""
    options.OUTPUT(path, click.Option(["--output"]), click.get_current_context())


def picture(text: str) -> Decorator:
    """Add ``--picture``."""
    how: Any = {"type": options.OUTPUT, "callback": _check_picture, "metavar": "F.png|pdf|svg"}
    return click.option("--picture", help=text, **how)


def _check_picture(_context: click.Context, _option: click.Parameter, path: Path | None) -> Any:
    """Refuse a picture that cannot be drawn before any other work."""
    from tablegen.presentation import require_matplotlib

    if path is not None:
        require_matplotlib("--picture")
        if path.suffix.lower() not in KINDS:
            allowed = f"a name that ends in {' or '.join(KINDS)}"
            raise InputError("--picture", str(path), allowed)
    return path
