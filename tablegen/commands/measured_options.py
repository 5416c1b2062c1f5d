"""Options that `compare` and `calibrate` have in common: measured rebounds and a picture."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

from sampler.commands import options
from sampler.commands.file_types import Named
from tablegen.commands import bounded

#: Name or path of a file of measurements.
MEASURED = Named(".csv")

_TILT = options.Number("0 to 28.6 degrees", 0.0, 28.6)

Decorator = Callable[[Any], Any]


def speed(text: str) -> Decorator:
    """Make the option ``--speed`` of rows that state none."""
    return click.option("--speed", type=bounded.SPEED, metavar="M_S", help=text)


def wall_tilt(text: str) -> Decorator:
    """Make the option ``--wall-tilt`` of a rough wall."""
    return click.option(
        "--wall-tilt", type=_TILT, default=0.0, show_default=True, metavar="DEG", help=text
    )


def picture(text: str) -> Decorator:
    """Make the option ``--picture``."""
    return click.option(
        "--picture",
        type=options.OUTPUT,
        metavar="F.png|pdf|svg",
        callback=_drawable,
        help=text,
    )


def _drawable(_context: click.Context, _option: click.Parameter, path: Path | None) -> Path | None:
    """Refuse a picture that cannot be drawn before any time is spent on what it shows."""
    from tablegen.measured.comparison_picture import check_picture
    from tablegen.presentation import require_matplotlib

    if path is not None:
        require_matplotlib("--picture")
        check_picture(path)
    return path
