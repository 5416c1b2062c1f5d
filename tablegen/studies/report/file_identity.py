"""Where a table comes from: the attributes of its file that the format fixes."""

from pathlib import Path

import h5py

#: Root attributes of a table file, in the order in which they are shown.
ATTRIBUTES = ("pair", "content_sha256", "seed", "software_version", "format_version")


def identity(path: Path) -> dict[str, str]:
    """Attributes of a table file as text.

    Parameters
    ----------
    path : Path
        Of a file that has been read as a table.

    Returns
    -------
    dict
        The `ATTRIBUTES`; the version of the format as "major.minor".
    """
    with h5py.File(path, "r") as file:
        values = {name: file.attrs[name] for name in ATTRIBUTES}
    values["format_version"] = ".".join(str(int(part)) for part in values["format_version"])
    return {name: str(value) for name, value in values.items()}
