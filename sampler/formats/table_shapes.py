"""Check that the shapes of the datasets of a table fit together, and suit the draw."""

from collections.abc import Mapping

from sampler.errors import TableError
from sampler.formats.bounds import (
    LANES,
    LENGTHS,
    N_EXPERTS,
    expert_stride,
    record_stride,
)
from sampler.formats.layout import layout_of

_MOST_ENTRIES = 2**31


def _shape_text(dims: tuple[str | int, ...], lengths: Mapping[str, int]) -> str:
    parts = (f"{d}={lengths[d]}" if d in lengths else str(d) for d in map(str, dims))
    return "(" + ", ".join(parts) + ("," if len(dims) == 1 else "") + ")"


def check_shapes(shapes: Mapping[str, tuple[int, ...]]) -> dict[str, int]:
    """Find the lengths of the named dimensions, from the shapes of all datasets by path.

    Raises
    ------
    TableError
        If a dataset is missing, or has a shape that does not fit the others'.
    """
    lengths: dict[str, int] = {}
    for dataset in layout_of(shapes):
        if dataset.path not in shapes:
            raise TableError(dataset.path, problem="the dataset is missing")
        shape = shapes[dataset.path]
        fits = len(shape) == len(dataset.dims)
        for dim, length in zip(dataset.dims, shape, strict=False):
            if isinstance(dim, int):
                fits = fits and length == dim
                continue
            least, most = LENGTHS.get(dim, (0, length))
            if length < least:
                raise TableError(dataset.path, f"{dim} = {length}", f"{least} or more")
            if length > most:
                raise TableError(dataset.path, f"{dim} = {length}", f"at most {most}")
            if fits:
                fits = lengths.setdefault(dim, length) == length
        if not fits:
            allowed = _shape_text(dataset.dims, lengths)
            raise TableError(dataset.path, f"shape {shape}", allowed)
    _check_entries(lengths)
    return lengths


def _check_entries(lengths: Mapping[str, int]) -> None:
    """Refuse tables whose arrays have more entries than a draw can count in 32 bits."""
    if "n_components" not in lengths:  # of spheres
        return
    n_alpha, n_speed = lengths["n_alpha"], lengths["n_speed"]
    cells = max(n_alpha - 1, 1) * max(n_speed - 1, 1)
    marginals = lengths["n_classes"] * lengths["n_marginals"]
    records = n_alpha * n_speed * lengths["n_components"]
    entries = {
        "marginals/quantiles": 4 * cells * marginals * lengths["n_knots"],
        "dependence/cholesky": records * record_stride(lengths["n_channels"]) + LANES,
        "dependence/first_of_class": n_alpha * n_speed * lengths["n_classes"],
    }
    if "n_leaves" in lengths:
        outcomes, leaves = lengths["n_outcomes"], lengths["n_leaves"]
        entries["spin/mean"] = leaves * N_EXPERTS * expert_stride(outcomes) + LANES
        entries["spin/quantiles"] = leaves * outcomes * lengths["n_spin_knots"]
    for path, count in entries.items():
        if count >= _MOST_ENTRIES:
            raise TableError(path, f"{count} entries in memory", f"below {_MOST_ENTRIES}")
