"""What examples write: a report, its numbers and pictures."""

import io
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from sampler.files.atomic import write_bytes, write_text
from sampler.files.json_text import json_text
from tablegen.presentation import Picture


def write_report(folder: Path, name: str, text: str, numbers: Mapping[str, Any]) -> list[str]:
    """Write NAME.md and NAME.json; returns their names."""
    write_text(folder / f"{name}.md", text)
    write_text(folder / f"{name}.json", json_text(_finite(numbers)))
    return [f"{name}.md", f"{name}.json"]


def _finite(numbers: Any) -> Any:
    """Numbers with None for those that there are none of: JSON has no others."""
    if isinstance(numbers, Mapping):
        return {key: _finite(value) for key, value in numbers.items()}
    if isinstance(numbers, list | tuple):
        return [_finite(value) for value in numbers]
    return None if isinstance(numbers, float) and not math.isfinite(numbers) else numbers


def with_few_colours(drawn: Picture) -> Picture:
    """Return a PNG of many dots in 256 colours, near all of its own, in a third of the bytes."""
    from PIL import Image  # matplotlib brings it

    buffer = io.BytesIO()
    image = Image.open(io.BytesIO(drawn.data)).convert("RGB")
    near_all = Image.Quantize.MAXCOVERAGE
    few = image.quantize(256, method=near_all, dither=Image.Dither.NONE)
    few.save(buffer, "PNG", optimize=True)
    return drawn._replace(data=buffer.getvalue())


def write_picture(drawn: Picture, *paths: Path | None) -> None:
    """Write a picture to all places where it is asked for."""
    for path in paths:
        if path is not None:
            write_bytes(path, drawn.data)
