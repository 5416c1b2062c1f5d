"""Pictures that commands draw: .png or .svg, refused before any work is done."""

from pathlib import Path

from sampler.errors import InputError

_ENDINGS = (".png", ".svg")


def check_picture(path: Path | None) -> None:
    """Check that a picture, if one is asked for, can be drawn.

    Raises
    ------
    InputError
        If its name has another ending, or matplotlib is not installed.
    """
    from tablegen.studies.paper_figures.style import require_matplotlib

    if path is None:
        return
    if path.suffix.lower() not in _ENDINGS:
        raise InputError(f"--picture: got {path.name}, allowed: a name that ends in .png or .svg")
    require_matplotlib("--picture")
