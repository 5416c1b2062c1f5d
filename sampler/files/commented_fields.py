"""Fields that a data file states about itself, in comment lines at its top."""

import re

_FIELD = re.compile(r"#\s*([a-z][a-z_]*):\s+(\S.*)")


def commented_fields(text: str) -> dict[str, str]:
    """Lines ``# key: value`` before the first line that is neither comment nor empty.

    Parameters
    ----------
    text : str
        Of the file.

    Returns
    -------
    dict of str to str
        The first value of each key; what could not be shown in one line is left out.
    """
    fields: dict[str, str] = {}
    for line in text.split("\n"):
        stripped = line.strip()
        if stripped and not stripped.startswith("#"):
            break
        found = _FIELD.fullmatch(stripped)
        if found and found[2].isprintable():
            fields.setdefault(found[1], found[2].strip())
    return fields
