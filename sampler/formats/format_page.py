"""Field lists of tables/FORMAT.md, made from the layouts that reader and writer follow.

Run ``python -m sampler.formats.format_page`` after a change to `sampler.formats.hdf5_layout` or
`sampler.formats.binary_layout`; everything outside the marked parts of the page is written by hand.
"""

import numpy as np

from sampler.errors import InputError
from sampler.files.atomic import write_text
from sampler.files.locate import data_directory
from sampler.formats.binary_layout import layout_text
from sampler.formats.hdf5_layout import ATTRIBUTES, DATASETS, OPTIONAL_ATTRIBUTES, Dataset

#: File name of the page, in the folder of the tables.
PAGE = "FORMAT.md"


def _row(dataset: Dataset) -> str:
    shape = ", ".join(str(dim) for dim in dataset.dims)
    kind = np.dtype(dataset.dtype).name
    return f"| `{dataset.path}` | {kind} | {shape} | {dataset.units} | {dataset.long_name} |"


def datasets_text() -> str:
    """Datasets of a table file as a Markdown table."""
    head = ["| dataset | type | shape | units | meaning |", "|---|---|---|---|---|"]
    return "\n".join(head + [_row(dataset) for dataset in DATASETS]) + "\n"


def attributes_text() -> str:
    """Root attributes of a table file as a Markdown table."""
    head = ["| attribute | type | meaning |", "|---|---|---|"]
    both = {**ATTRIBUTES, **OPTIONAL_ATTRIBUTES}
    rows = [f"| `{name}` | {kind.__name__} | {what} |" for name, (kind, what) in both.items()]
    return "\n".join(head + rows) + "\n"


def filled(page: str) -> str:
    """Replace the marked parts of the page.

    Parameters
    ----------
    page : str
        Text with a line ``<!-- begin NAME -->`` and a line ``<!-- end NAME -->`` around each part.

    Returns
    -------
    str

    Raises
    ------
    InputError
        If a part is not marked exactly once.
    """
    parts = {"attributes": attributes_text, "datasets": datasets_text, "image": layout_text}
    for name, text in parts.items():
        begin, end = f"<!-- begin {name} -->\n", f"<!-- end {name} -->\n"
        if page.count(begin) != 1 or page.count(end) != 1 or page.index(begin) > page.index(end):
            raise InputError(
                f"{PAGE}: part '{name}' is not marked, allowed: {begin.strip()}, then {end.strip()}"
            )
        before, rest = page.split(begin)
        page = f"{before}{begin}{text()}{end}{rest.split(end)[1]}"
    return page


def main() -> None:
    """Bring the page up to date."""
    path = data_directory() / PAGE
    page = filled(path.read_text(encoding="utf-8"))
    write_text(path, page)


if __name__ == "__main__":
    main()
