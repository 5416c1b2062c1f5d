"""Data as JSON text: the one place that writes it."""

import json
from collections.abc import Mapping, Sequence


def json_text(data: Mapping[str, object] | Sequence[object], indent: int | None = 1) -> str:
    """Write data as JSON, with a line end; NaN and infinity, which JSON does not have, are errors.

    Parameters
    ----------
    data : mapping or sequence
        Of numbers, texts, and such mappings and sequences.
    indent : int or None
        Spaces a level, or everything on one line.

    Raises
    ------
    ValueError
        If a number is not finite.
    """
    return json.dumps(data, indent=indent, allow_nan=False) + "\n"
