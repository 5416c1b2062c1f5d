"""Field lists of tables/FORMAT.md, made from the layouts that reader and writer follow.

Run ``python tools/format_page.py`` after a change to `sampler.formats.layout` or
`sampler.formats.binary_layout`. Everything outside the marked parts of the page is written by hand.
"""

import itertools
from collections.abc import Iterable

import numpy as np
from marked_parts import fill_file, filled

from sampler.files import data_directory
from sampler.formats.binary_layout import layout_text
from sampler.formats.bounds import QUANTILES, RESISTANCE_LAWS, RESTITUTION_LAWS
from sampler.formats.layout import (
    ATTRIBUTES,
    BY_SPHERE,
    DATASETS,
    FILE_ATTRIBUTES,
    SPHERE_DATASETS,
    SPIN_DATASETS,
    Dataset,
)

#: File name of the page, in the folder of the tables.
PAGE = "FORMAT.md"


def _row(dataset: Dataset) -> str:
    shape = ", ".join(str(dim) for dim in dataset.dims)
    kind = np.dtype(dataset.dtype).name
    cells = [f"`{dataset.path}`", kind, shape, dataset.units, dataset.long_name]
    cells.append("; ".join(check.allowed for check in dataset.checks))
    return f"| {' | '.join(cells)} |"


def _list_of(datasets: Iterable[Dataset]) -> str:
    """Write datasets as a Markdown table."""
    head = ["| dataset | type | shape | units | meaning | values |", "|---|---|---|---|---|---|"]
    return "\n".join(head + [_row(dataset) for dataset in datasets]) + "\n"


def quantiles_text() -> str:
    """Write the bounds of the quantiles of each channel as an indented block."""
    return "".join(f"    {name} ({low:g}, {high:g})\n" for name, (low, high) in QUANTILES.items())


def laws_text() -> str:
    """Codes of the laws of contact as a Markdown table."""
    rows = itertools.zip_longest(RESTITUTION_LAWS, RESISTANCE_LAWS, fillvalue="")
    lines = ["| code | law of restitution | law of resistance |", "|---|---|---|"]
    lines += [f"| {code} | {' | '.join(laws)} |" for code, laws in enumerate(rows)]
    return "\n".join(lines) + "\n"


def attributes_text() -> str:
    """Root attributes of a table file as a Markdown table."""
    head = ["| attribute | type | meaning |", "|---|---|---|"]
    both = FILE_ATTRIBUTES | ATTRIBUTES
    rows = [f"| `{name}` | {a.kind.__name__} | {a.meaning} |" for name, a in both.items()]
    return "\n".join(head + rows) + "\n"


def filled_page(page: str) -> str:
    """Bring the marked parts of the page up to date; errors as `filled`."""
    parts = {
        "attributes": attributes_text,
        "datasets": lambda: _list_of(DATASETS),
        "spin": lambda: _list_of((*SPIN_DATASETS, BY_SPHERE, *SPHERE_DATASETS)),
        "quantiles": quantiles_text,
        "laws": laws_text,
        "binary": layout_text,
    }
    return filled(page, PAGE, parts)


def main() -> None:
    """Bring the page up to date."""
    fill_file(data_directory() / PAGE, filled_page)


if __name__ == "__main__":
    main()
