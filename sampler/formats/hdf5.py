r"""Table files, read and written by h5py as `sampler.formats.layout` describes them.

Everything that the layout says is checked before a file is written and after it is read, so that a
draw may index without looking.

``content_sha256`` is the SHA-256 of the following bytes: for each dataset of the file in the
order of its path the text ``path dtype shape\n`` (dtype as numpy's ``dtype.str``, shape as JSON)
and its values in C order, then for each root attribute but the two checksums, in the order of its
name, the text ``name value\n`` (value as JSON).

``file_sha256`` is the SHA-256 of all bytes of the file, with zeros in place of its own 64 digits.
It is checked before HDF5 sees a file, because a damaged one may hang HDF5 or end the process.
"""

import hashlib
import io
import json
import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from sampler.errors import InputError, TableError, value_text
from sampler.files import read_file, write_bytes
from sampler.formats import checks
from sampler.formats.bounds import N_OUTCOMES, N_OUTCOMES_WITH_WORKS, QUANTILES
from sampler.formats.channels import CHANNELS, VARIABLES, channels_for, has_works
from sampler.formats.checks import Array, Check
from sampler.formats.layout import (
    ATTRIBUTES,
    FORMAT,
    FORMAT_VERSION,
    GROUP,
    OPTIONAL_ATTRIBUTE,
    SPHERE_DATASETS,
    Dataset,
    layout_of,
)
from sampler.formats.table_shapes import check_shapes

#: Bytes of a chunk of a compressed dataset, if a row has not more.
_CHUNK = 2**19

#: First bytes of every HDF5 file.
_SIGNATURE = b"\x89HDF\r\n\x1a\n"

#: Checksum of the bytes in a file: an attribute of the root. HDF5 writes its digits behind its
#: name.
_SEAL = re.compile(rb"file_sha256\0.{0,64}?([0-9a-f]{64})", re.DOTALL)
_NO_DIGITS = b"0" * 64

#: What files of these suffixes are, if they are no HDF5 files.
_OTHER_KINDS = {
    ".toml": "this is a configuration, not a table",
    ".csv": "this is a file of measurements, not a table",
    ".rbt": "this is a binary table, for C and Fortran",
}


def _check_attributes(given: Mapping[str, Any]) -> None:
    """Refuse attributes that are missing, of another type, or not allowed."""
    for name, (kind, meaning, holds) in ATTRIBUTES.items():
        if name not in given:
            if name == OPTIONAL_ATTRIBUTE:
                continue
            raise TableError(name, problem=f"the attribute is missing ({meaning})")
        # Not isinstance: True is an int, and would be written as another type.
        if type(given[name]) is not kind or not holds(given[name]):
            raise TableError(name, value_text(given[name]), meaning)


def _check_names(variables: tuple[str, ...], channels: tuple[str, ...]) -> None:
    """Refuse variables and channels that are unknown, occur twice, or are not enough."""
    for name, given, known in (
        ("variables", variables, VARIABLES),
        ("channels", channels, CHANNELS),
    ):
        if not given or not set(given) <= set(known) or len(set(given)) < len(given):
            allowed = f"some of {' '.join(known)}, each once"
            raise TableError(name, value_text(" ".join(given)), allowed)
    missing = [name for name in channels_for(variables) if name not in channels]
    if missing:
        problem = f"the variables need {' '.join(missing)}, too"
        raise TableError("channels", value_text(" ".join(channels)), problem=problem)


def _check_units(path: str, given: Any, known: str) -> None:
    """Refuse units of a dataset other than its own; those that were left out mislead nobody.

    They do not count in the checksum.
    """
    if given is not None and not (isinstance(given, str) and given == known):
        raise TableError("units", value_text(given), repr(known), source=path)


def _convert_values(dataset: Dataset, values: Any) -> Array:
    """Convert values to the type of the file; refuse values that the conversion would change."""
    target = np.dtype(dataset.dtype)
    array = np.asarray(values)
    if array.dtype.kind not in ("iu" if target.kind in "iu" else "f"):
        raise TableError(dataset.path, array.dtype.name, target.name)
    if target.kind in "iu" and array.size:
        low, high = array.min(), array.max()
        if low < np.iinfo(target).min or high > np.iinfo(target).max:
            raise TableError(dataset.path, f"{low} to {high}", target.name)
    with np.errstate(over="ignore"):  # an overflow becomes infinite, which is refused later
        return np.ascontiguousarray(array, dtype=target)


def _check_values(arrays: Mapping[str, Array]) -> None:
    """Run every check of the layout."""
    # Finite first and everywhere: the other checks compare, which NaN would slip through.
    layout = layout_of(arrays)
    tests: list[tuple[str, Check]] = [(dataset.path, checks.finite) for dataset in layout]
    tests += [(dataset.path, check) for dataset in layout for check in dataset.checks]
    for path, check in tests:
        problem = check.problem(arrays[path], arrays)
        if problem is not None:
            raise problem.within(path)


def _check_ranges(quantiles: Array, marginals: tuple[str, ...]) -> None:
    """Refuse quantiles beyond what is physical."""
    for k, name in enumerate(marginals):
        low, high = QUANTILES[name]
        part = quantiles[..., k, :]
        refused = (part <= low) | (part >= high)
        if refused.any():
            where = tuple(int(n) for n in np.argwhere(refused)[0])
            given, allowed = f"{part[where]:.9g}", f"above {low:g}, below {high:g}"
            raise TableError(f"of {name}", given, allowed, row=where, source="marginals/quantiles")


@dataclass(frozen=True, eq=False, kw_only=True)
class TableContents:
    """Everything that a table file holds.

    The contents are checked when the record is made, and are not changed afterwards.

    Attributes
    ----------
    datasets : mapping from str to array
        Datasets by their path. Floating-point arrays are rounded to the type of the file.
    pair : str
        Name of the material pair.
    config : str
        TOML text of the configuration from which the table was made.
    seed : int
        Seed of the simulation behind the table.
    software_version : str
        Version of rebound-tables that made the table.
    variables : tuple of str
        Variables of the states that the table gives.
    channels : tuple of str
        Channels of the mixture, in the order of its factors.
    speed_independent : bool
        Whether rebounds do not depend on the speed.
    least_inertia : float
        Smallest moment of inertia of any grain, over m a^2.
    valid_speed : tuple of two float, optional
        Speeds [m/s] between which the contact laws of the pair were measured.

    Raises
    ------
    TableError
        If a dataset or an attribute is missing, unknown or not allowed. The message names it.

    Notes
    -----
    tables/FORMAT.md lists the datasets and attributes.
    """

    datasets: Mapping[str, Array]
    pair: str
    config: str
    seed: int
    software_version: str
    variables: tuple[str, ...]
    channels: tuple[str, ...]
    speed_independent: bool
    least_inertia: float
    valid_speed: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        _check_attributes(self.attributes)
        layout = layout_of(self.datasets)
        known = [dataset.path for dataset in layout]
        for path in self.datasets:
            if path not in known:
                problem = "the dataset is unknown"
                raise TableError(path, problem=problem, allowed=", ".join(known))
        _check_names(self.variables, self.channels)
        shapes = {path: np.shape(values) for path, values in self.datasets.items()}
        lengths = check_shapes(shapes)
        for dim, (needed, why) in self._lengths().items():
            if lengths.get(dim, needed) != needed:
                raise TableError(dim, str(lengths[dim]), f"{needed}, {why}")
        arrays = {d.path: _convert_values(d, self.datasets[d.path]) for d in layout}
        _check_values(arrays)
        if not self.of_spheres:
            _check_ranges(arrays["marginals/quantiles"], self.marginals)
        object.__setattr__(self, "datasets", arrays)

    def _lengths(self) -> dict[str, tuple[int, str]]:
        """Find the lengths that follow from the names, and why."""
        outcomes = N_OUTCOMES_WITH_WORKS if has_works(self.variables) else N_OUTCOMES
        lengths = {
            "n_columns": (len(self.variables), "one for each name"),
            "n_channels": (len(self.channels), "one for each name"),
            "n_marginals": (len(self.marginals), "one for each name"),
            "n_outcomes": (outcomes, "8 with works, else 7"),
            "n_spin_factors": (outcomes * (outcomes + 1) // 2, "lower triangles"),
        }
        return lengths | ({"n_shapes": (1, "the sphere")} if self.of_spheres else {})

    def __getitem__(self, path: str) -> Array:
        return self.datasets[path]

    @property
    def has_spin(self) -> bool:
        """Whether the table has a spin law."""
        return f"{GROUP}shape_codes" in self.datasets

    @property
    def of_spheres(self) -> bool:
        """Whether the table holds the laws of contact of spheres in place of nodes."""
        return SPHERE_DATASETS[0].path in self.datasets

    @property
    def marginals(self) -> tuple[str, ...]:
        """Channels with quantile functions, from which the variables are computed."""
        needed = (*channels_for(self.variables), "normal_hat")
        return tuple(name for name in self.channels if name in needed)

    @property
    def attributes(self) -> dict[str, Any]:
        """Root attributes of the file but the checksum."""
        valid = self.valid_speed
        return {
            "format": FORMAT,
            "format_version": list(FORMAT_VERSION),
            "pair": self.pair,
            "config": self.config,
            "seed": self.seed,
            "software_version": self.software_version,
            "variables": " ".join(self.variables),
            "channels": " ".join(self.channels),
            "speed_independent": int(self.speed_independent),
            "least_inertia": self.least_inertia,
        } | ({} if valid is None else {"valid_speed": list(valid)})

    @cached_property
    def content_sha256(self) -> str:
        """Checksum of the contents, hexadecimal."""
        return content_sha256(self.datasets, self.attributes)


def content_sha256(datasets: Mapping[str, Array], attributes: Mapping[str, Any]) -> str:
    """Compute the checksum of datasets and root attributes, as the head of this module says."""
    digest = hashlib.sha256()
    for path in sorted(datasets):
        values = np.ascontiguousarray(datasets[path])
        shape = json.dumps(list(datasets[path].shape))
        digest.update(f"{path} {values.dtype.str} {shape}\n".encode())
        digest.update(values.data if values.size else b"")
    for name in sorted(attributes):
        if name not in ("content_sha256", "file_sha256"):
            digest.update(f"{name} {json.dumps(attributes[name])}\n".encode())
    return digest.hexdigest()


def write_table(path: str | Path, contents: TableContents) -> None:
    """Write a table file.

    Parameters
    ----------
    path : str or Path
        File to write. An existing file is replaced.
    contents : TableContents
        The contents.

    Raises
    ------
    InputError
        If the file cannot be written. Then an existing file stays as it was.

    Notes
    -----
    Equal contents give equal bytes, because the file does not say when or where it was written.
    """
    write_bytes(path, _file_image(contents))


def _file_image(contents: TableContents) -> bytes:
    """Make a table file in memory, because HDF5 crashes the process if a disk is full."""
    with h5py.File("table", "w", driver="core", backing_store=False, libver="earliest") as file:
        layout = layout_of(contents.datasets)
        for dataset in layout:
            _write_dataset(file, dataset, contents[dataset.path])
        _name_axes(file, layout)
        for name, value in contents.attributes.items():
            # An unsigned type only where it is needed: the seed may exceed int64.
            file.attrs[name] = np.uint64(value) if name == "seed" else value
        file.attrs["content_sha256"] = contents.content_sha256
        file.attrs["file_sha256"] = np.bytes_(_NO_DIGITS)
        file.flush()
        return sealed(bytes(file.id.get_file_image()))


def sealed(image: bytes) -> bytes:
    """Write the checksum of the bytes of a table file into them."""
    start, end = _seal_of(image).span(1)
    return image[:start] + _bytes_sha256(image, start, end) + image[end:]


def _seal_of(image: bytes) -> re.Match[bytes]:
    """Find the checksum of the bytes in a table file."""
    found = _SEAL.search(image)
    if found is None:
        problem = "the checksum of the bytes is missing: the file is damaged, or no rebound table"
        raise TableError("file_sha256", problem=problem)
    return found


def _bytes_sha256(image: bytes, start: int, end: int) -> bytes:
    """Compute the checksum of the bytes of a file, whose digits lie from start to end."""
    view = memoryview(image)
    digest = hashlib.sha256(view[:start])
    digest.update(_NO_DIGITS)
    digest.update(view[end:])
    return digest.hexdigest().encode()


def _check_bytes(image: bytes) -> None:
    """Refuse a file with other bytes than when it was written."""
    found = _seal_of(image)
    if found[1] != _bytes_sha256(image, *found.span(1)):
        problem = "the file has changed since it was written: its bytes have another checksum"
        raise TableError("file_sha256", problem=problem, remedy="use another copy of the table")


def _write_dataset(file: h5py.File, dataset: Dataset, values: Array) -> None:
    storage: dict[str, Any] = {"track_times": False}
    if dataset.compressed:
        # Few chunks, which open fast, small enough for the cache. Level 9 takes eight times as long
        # as level 6, seconds beside minutes of fitting, and saves 2 % of the bytes.
        rows = max(1, min(len(values), _CHUNK // values[0].nbytes))
        storage |= {"chunks": (rows, *values.shape[1:]), "shuffle": True}
        storage |= {"compression": "gzip", "compression_opts": 9}
    written = file.create_dataset(dataset.path, data=values, **storage)
    written.attrs["units"] = dataset.units
    written.attrs["long_name"] = dataset.long_name


def _name_axes(file: h5py.File, layout: tuple[Dataset, ...]) -> None:
    """Label every axis by its dimension, and make scales, from which xarray takes its names.

    The first dataset of a group with one axis is the scale of that axis. Only datasets with one
    axis get it attached: readers of netCDF want scales in the group of a dataset, for all of its
    axes or for none, and most axes of a table are no dataset.
    """
    scales: dict[tuple[str, str], h5py.Dataset] = {}
    for dataset in layout:
        node = file[dataset.path]
        named = [(axis, dim) for axis, dim in enumerate(dataset.dims) if isinstance(dim, str)]
        for axis, dim in named:
            node.dims[axis].label = dim
        if len(dataset.dims) == len(named) == 1:
            group, _, name = dataset.path.rpartition("/")
            scale = scales.setdefault((group, named[0][1]), node)
            if scale is node:
                node.make_scale(name)
            else:
                node.dims[0].attach_scale(scale)


def read_table(path: str | Path) -> TableContents:
    """Read a table file, and check everything in it.

    `sampler.load` reads a table to draw from. Use this function to look at the datasets.

    Parameters
    ----------
    path : str or Path
        The .h5 file.

    Returns
    -------
    TableContents

    Raises
    ------
    TableError
        If the file cannot be read, is not a table, has another major version, has changed since it
        was written, or holds something that the layout does not allow. The message names the file,
        what is wrong, and what is allowed.

    Examples
    --------
    >>> import sampler
    >>> path = sampler.data_directory() / "corundum-steel-compact.h5"
    >>> contents = sampler.read_table(path)
    >>> contents["marginals/quantiles"].ndim
    5
    """
    try:
        data = read_file("table", path)
    except InputError as error:
        raise TableError(error.argument, problem=error.problem) from None
    try:
        _check_kind(data, Path(path).suffix)
        _check_bytes(data)
        # from memory: HDF5 locks files, which not every file system can
        with h5py.File(io.BytesIO(data), "r") as file:
            attributes = _read_attributes(file)
            datasets = _read_datasets(file)
        return _contents_of(attributes, datasets)
    except TableError as error:
        raise error.within(path) from None
    except (OSError, RuntimeError, KeyError, ValueError, TypeError) as error:  # h5py's
        reason = str(error).partition("\n")[0]
        problem = f"is a damaged HDF5 file ({reason})"
        raise TableError("", problem=problem, source=str(path)) from error


def _check_kind(data: bytes, suffix: str) -> None:
    """Refuse a file that is no HDF5 file, by what it is."""
    if data.startswith(_SIGNATURE):
        return
    problem = _OTHER_KINDS.get(suffix, "this is no HDF5 file") if data else "the file is empty"
    raise TableError("", problem=problem, remedy="give a table in .h5")


def _contents_of(attributes: Mapping[str, Any], datasets: Mapping[str, Array]) -> TableContents:
    """Check what was read from a file."""
    digest = content_sha256(datasets, attributes)
    if attributes.get("content_sha256") != digest:
        problem = "the file has changed since it was written: its contents have another checksum"
        raise TableError("content_sha256", problem=problem)
    known = {dataset.path for dataset in layout_of(datasets)}
    valid = attributes.get("valid_speed")
    contents = TableContents(
        datasets={name: values for name, values in datasets.items() if name in known},
        pair=attributes["pair"],
        config=attributes["config"],
        seed=attributes["seed"],
        software_version=attributes["software_version"],
        variables=tuple(attributes["variables"].split()),
        channels=tuple(attributes["channels"].split()),
        speed_independent=bool(attributes["speed_independent"]),
        least_inertia=attributes["least_inertia"],
        valid_speed=None if valid is None else (valid[0], valid[1]),
    )
    whole = contents.attributes | {"content_sha256": digest} == attributes
    if whole and len(known) == len(datasets):
        contents.__dict__["content_sha256"] = digest  # not computed again
    return contents


def _read_attributes(file: h5py.File) -> dict[str, Any]:
    """Read the root attributes, after format and version were found to be ours."""
    values = {n: _plain(value) for n, value in file.attrs.items() if n != "file_sha256"}
    if values.get("format") != FORMAT:
        problem = f'this HDF5 file is no table: its format is not "{FORMAT}"'
        raise TableError("format", problem=problem)
    version = values.get("format_version")
    if not (isinstance(version, list) and [type(v) for v in version] == [int, int]):
        raise TableError("format_version", value_text(version), "two integers")
    if version[0] != FORMAT_VERSION[0]:
        given, allowed = f"{version[0]}.{version[1]}", f"{FORMAT_VERSION[0]}.x"
        remedy = "make the table again: tablegen generate"
        raise TableError("format_version", given, allowed, remedy=remedy)
    _check_attributes(values)
    return values


def _plain(value: Any) -> Any:
    """Turn the value of an attribute into Python's own types."""
    return value.tolist() if isinstance(value, np.ndarray | np.generic) else value


def _read_datasets(file: h5py.File) -> dict[str, Array]:
    """Read all datasets; those of a later minor version count in the checksum."""
    nodes: dict[str, h5py.Dataset] = {}

    def keep(path: str, node: Any) -> None:
        if isinstance(node, h5py.Dataset):
            nodes[path] = node

    file.visititems(keep)
    check_shapes({path: node.shape for path, node in nodes.items()})
    for known in layout_of(nodes):
        node, allowed = nodes[known.path], np.dtype(known.dtype)
        if node.dtype.str != known.dtype:
            order = "big-endian " if node.dtype.str[0] == ">" else ""
            raise TableError(known.path, f"{order}{node.dtype.name}", allowed.name)
        _check_units(known.path, _plain(node.attrs.get("units")), known.units)
    return {path: node[()] for path, node in nodes.items()}
