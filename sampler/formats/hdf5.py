r"""Table files written and read as `sampler.formats.layout` describes them.

They are written by h5py, and read by `sampler.formats.hdf5_container`, which no file can hurt.

Everything that the layout says is checked before a file is written and after it is read, so that
the kernels may index without looking.

``content_sha256`` is the SHA-256 of the following bytes: for each dataset of the file in the
order of its path the text ``path dtype shape\n`` (dtype as numpy's ``dtype.str``, shape as JSON)
and its values in C order, then for each root attribute but itself, in the order of its name, the
text ``name value\n`` (value as JSON).
"""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from sampler.errors import InputError, TableError
from sampler.files import read_file, write_bytes
from sampler.formats import hdf5_checks as checks
from sampler.formats.bounds import QUANTILES
from sampler.formats.channels import CHANNELS, STATE, channels_for, has_works
from sampler.formats.checks import Array, Check
from sampler.formats.hdf5_attributes import (
    check_attributes,
    check_names,
    check_valid_speed,
    speeds_of,
)
from sampler.formats.hdf5_container import read_container
from sampler.formats.layout import (
    FIRST_VERSION,
    FORMAT,
    FORMAT_VERSION,
    GROUP,
    SECOND_VERSION,
    Dataset,
    layout_of,
)
from sampler.formats.table_shapes import check_shapes

#: Largest file that is read.
MOST_BYTES = 2**31


def _coerced(dataset: Dataset, values: Any) -> Array:
    """Values in the type of the file; refuses what would not survive the change."""
    target = np.dtype(dataset.dtype)
    array = np.asarray(values)
    if array.dtype.kind not in ("iu" if target.kind in "iu" else "f"):
        raise TableError(f"{dataset.path}: got {array.dtype.name}, allowed: {target.name}")
    if target.kind in "iu" and array.size:
        low, high = array.min(), array.max()
        if low < np.iinfo(target).min or high > np.iinfo(target).max:
            raise TableError(f"{dataset.path}: got {low} to {high}, allowed: {target.name}")
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
            raise TableError(f"{path}: {problem}")


def _check_ranges(quantiles: Array, marginals: tuple[str, ...]) -> None:
    """Quantiles within what is physical."""
    for k, name in enumerate(marginals):
        low, high = QUANTILES[name]
        part = quantiles[..., k, :]
        refused = (part <= low) | (part >= high)
        if refused.any():
            where = tuple(int(n) for n in np.argwhere(refused)[0])
            raise TableError(
                f"marginals/quantiles: of {name}: got {part[where]:.9g} at {list(where)}, "
                f"allowed: in ({low:g}, {high:g})"
            )


@dataclass(frozen=True, eq=False)
class TableContents:
    """Everything in a table file, checked when it is made.

    Attributes
    ----------
    datasets : mapping from path to array
        All of `DATASETS`, with a spin law also of `SPIN_DATASETS`, and no other; floating-point
        arrays are rounded to the file's type.
    pair, config, software_version : str
    seed : int
    variables, channels, processors : tuple of str
        See `ATTRIBUTES`; the file calls the variables of a state its components.
    speed_independent : bool
        Whether rebounds do not depend on the speed.
    valid_speed : tuple of two float, optional
        Speeds, m/s, between which the laws of the pair were measured.

    Raises
    ------
    TableError
        If anything is not as `DATASETS` and `ATTRIBUTES` say; names the dataset or attribute.
    """

    datasets: Mapping[str, Array]
    pair: str
    config: str
    seed: int
    software_version: str
    variables: tuple[str, ...] = STATE
    channels: tuple[str, ...] = CHANNELS[:6]
    speed_independent: bool = False
    processors: tuple[str, ...] = ()
    valid_speed: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        names = ("pair", "config", "software_version", "seed")
        check_attributes({name: getattr(self, name) for name in names}, self.processors)
        check_valid_speed(self.valid_speed)
        layout = layout_of(self.datasets)
        known = [dataset.path for dataset in layout]
        for path in self.datasets:
            if path not in known:
                raise TableError(f"{path}: is unknown, allowed: {', '.join(known)}")
        check_names(self.variables, self.channels)
        shapes = {path: np.shape(values) for path, values in self.datasets.items()}
        lengths = check_shapes(shapes)
        named = {
            "n_columns": self.variables,
            "n_channels": self.channels,
            "n_marginals": self.marginals,
        }
        for dim, held in named.items():
            if lengths[dim] != len(held):
                allowed = f"{len(held)}, one for each name"
                raise TableError(f"{dim}: got {lengths[dim]}, allowed: {allowed}")
        arrays = {d.path: _coerced(d, self.datasets[d.path]) for d in layout}
        _check_values(arrays)
        _check_ranges(arrays["marginals/quantiles"], self.marginals)
        object.__setattr__(self, "datasets", arrays)

    def __getitem__(self, path: str) -> Array:
        return self.datasets[path]

    @property
    def has_spin(self) -> bool:
        """Whether the table has a spin law."""
        return f"{GROUP}roots" in self.datasets

    @property
    def marginals(self) -> tuple[str, ...]:
        """Channels with quantile functions: those that the variables are made of."""
        needed = channels_for(self.variables)
        return tuple(name for name in self.channels if name in needed)

    @property
    def _version(self) -> tuple[int, int]:
        """Least minor version of the format that has all that is held."""
        if has_works(self.variables):
            return FORMAT_VERSION
        later = self.has_spin or self.valid_speed is not None
        return SECOND_VERSION if later else FIRST_VERSION

    @property
    def attributes(self) -> dict[str, Any]:
        """Root attributes of the file but the checksum."""
        optional: dict[str, Any] = {"speed_independent": 1} if self.speed_independent else {}
        if self.processors:
            optional["processors"] = "\n".join(self.processors)
        if self.valid_speed is not None:
            optional["valid_speed"] = "{:.17g} {:.17g}".format(*self.valid_speed)
        return optional | {
            "format": FORMAT,
            "format_version": list(self._version),
            "pair": self.pair,
            "config": self.config,
            "seed": self.seed,
            "software_version": self.software_version,
            "components": " ".join(self.variables),
            "channels": " ".join(self.channels),
        }

    @property
    def content_sha256(self) -> str:
        """Checksum of the contents, hexadecimal."""
        return content_sha256(self.datasets, self.attributes)


def content_sha256(datasets: Mapping[str, Array], attributes: Mapping[str, Any]) -> str:
    """Checksum of datasets by path and of root attributes; see the head of this module."""
    digest = hashlib.sha256()
    for path in sorted(datasets):
        values = np.ascontiguousarray(datasets[path])
        shape = json.dumps(list(datasets[path].shape))
        digest.update(f"{path} {values.dtype.str} {shape}\n".encode())
        digest.update(values.data if values.size else b"")
    for name in sorted(attributes):
        if name != "content_sha256":
            digest.update(f"{name} {json.dumps(attributes[name])}\n".encode())
    return digest.hexdigest()


def write_table(path: str | Path, contents: TableContents) -> None:
    """Write a table file, whole or not at all; raises `InputError` if that cannot be.

    Equal contents give equal bytes: nothing in the file tells when or where it was written. A file
    of that name is replaced.
    """
    write_bytes(path, _file_image(contents))


def _file_image(contents: TableContents) -> bytes:
    """Bytes of a table file, made in memory: HDF5 crashes the process where a disk is full."""
    with h5py.File("table", "w", driver="core", backing_store=False, libver="earliest") as file:
        layout = layout_of(contents.datasets)
        for dataset in layout:
            _write_dataset(file, dataset, contents[dataset.path])
        _name_axes(file, layout)
        for name, value in contents.attributes.items():
            # An unsigned type only where it is needed: the seed may exceed int64.
            file.attrs[name] = np.uint64(value) if name == "seed" else value
        file.attrs["content_sha256"] = contents.content_sha256
        file.flush()
        return bytes(file.id.get_file_image())


def _write_dataset(file: h5py.File, dataset: Dataset, values: Array) -> None:
    storage: dict[str, Any] = {"track_times": False}
    if dataset.compressed:
        # One chunk for each angle: few enough to open fast, small enough to stay in the cache.
        storage |= {"chunks": (1, *values.shape[1:]), "shuffle": True}
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


def _bytes_of(source: Path) -> bytes:
    """Bytes of a file, once and for all: nothing that happens to it later is seen."""
    try:
        return read_file("table", source, MOST_BYTES)
    except InputError as error:
        raise TableError(str(error)) from error


def read_table(path: str | Path) -> TableContents:
    """Read a table file and check everything in it.

    Raises
    ------
    TableError
        If the file cannot be read, is no table, is newer than this reader, was changed since it
        was written, or holds anything that the layout forbids. The message names the file, what
        is wrong with it and what is allowed.
    """
    source = Path(path)
    whole = _bytes_of(source)
    try:
        attributes, datasets = read_container(whole)
        if content_sha256(datasets, attributes) != attributes["content_sha256"]:
            raise TableError("content_sha256: the contents do not have this checksum")
        known = {dataset.path for dataset in layout_of(datasets)}
        return TableContents(
            datasets={name: values for name, values in datasets.items() if name in known},
            pair=attributes["pair"],
            config=attributes["config"],
            seed=attributes["seed"],
            software_version=attributes["software_version"],
            variables=tuple(attributes["components"].split()),
            channels=tuple(attributes["channels"].split()),
            speed_independent="speed_independent" in attributes,
            processors=tuple(attributes["processors"].split("\n"))
            if "processors" in attributes
            else (),
            valid_speed=speeds_of(attributes.get("valid_speed")),
        )
    except TableError as error:
        raise TableError(f"{source}: {error}") from error.__cause__
