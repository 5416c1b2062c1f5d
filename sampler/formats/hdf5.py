r"""Table files, read and written by h5py as `sampler.formats.layout` describes them.

Everything that the layout says is checked before a file is written and after it is read, so that a
draw may index without looking.

``content_sha256`` is the SHA-256 of the following bytes: for each dataset of the file in the
order of its path the text ``path dtype shape\n`` (dtype as numpy's ``dtype.str``, shape as JSON)
and its values in C order, then for each root attribute but itself, in the order of its name, the
text ``name value\n`` (value as JSON).
"""

import hashlib
import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from sampler.errors import InputError, TableError, shortened
from sampler.files import check_input, write_bytes
from sampler.formats import checks
from sampler.formats.bounds import (
    LEAST_INERTIA,
    LINE_CHARACTERS,
    N_OUTCOMES,
    N_OUTCOMES_WITH_WORKS,
    PAIR_BYTES,
    QUANTILES,
    SPEED,
    is_line,
    is_text,
)
from sampler.formats.channels import CHANNELS, STATE, VARIABLES, channels_for, has_works
from sampler.formats.checks import Array, Check
from sampler.formats.layout import (
    ATTRIBUTES,
    FIFTH_VERSION,
    FIRST_VERSION,
    FORMAT,
    FORMAT_VERSION,
    FOURTH_VERSION,
    GROUP,
    LAW_DATASETS,
    OPTIONAL_ATTRIBUTES,
    SECOND_VERSION,
    SPHERE_DATASETS,
    THIRD_VERSION,
    Dataset,
    layout_of,
)
from sampler.formats.table_shapes import check_shapes


def _shown(value: Any) -> str:
    """Write a given value short and in one line."""
    return repr(shortened(value)) if isinstance(value, str) else shortened(repr(value))


def _is_pair(value: str) -> bool:
    return is_line(value) and len(value.encode()) <= PAIR_BYTES


def _is_short_line(value: str) -> bool:
    return is_line(value) and len(value) <= LINE_CHARACTERS


def _is_seed(value: int) -> bool:
    return 0 <= value < 2**64


#: Which values of an attribute are allowed, besides those of its type.
_RULES: dict[str, Callable[[Any], bool]] = {
    "pair": _is_pair,
    "config": is_text,
    "software_version": _is_short_line,
    "seed": _is_seed,
}


def _check_attributes(given: dict[str, Any], processors: Sequence[str]) -> None:
    """Refuse attributes of another type, out of range, or with what controls a terminal.

    Parameters
    ----------
    given : dict
        ``pair``, ``config``, ``software_version`` and ``seed``.
    processors : sequence of str

    Raises
    ------
    TableError
    """
    for name, holds in _RULES.items():
        kind, meaning = ATTRIBUTES[name]
        # Not isinstance: True is an int, and would be written as another type.
        if type(given[name]) is not kind or not holds(given[name]):
            raise TableError(f"{name}: got {_shown(given[name])}, allowed: {meaning}")
    for processor in processors:
        if not processor or not _is_short_line(processor):
            meaning = OPTIONAL_ATTRIBUTES["processors"][1]
            raise TableError(f"processors: got {_shown(processor)}, allowed: {meaning}")


def _check_names(variables: tuple[str, ...], channels: tuple[str, ...]) -> None:
    """Refuse components and channels that are unknown, occur twice, or are not enough."""
    for name, given, known in (
        ("components", variables, VARIABLES),
        ("channels", channels, CHANNELS),
    ):
        if not given or not set(given) <= set(known) or len(set(given)) < len(given):
            got, allowed = _shown(" ".join(given)), f"some of {' '.join(known)}"
            raise TableError(f"{name}: got {got}, allowed: {allowed}")
    missing = [name for name in channels_for(variables) if name not in channels]
    if missing:
        raise TableError(f"channels: {' '.join(missing)} missing, allowed: all the components need")


def _check_units(path: str, given: Any, known: str) -> None:
    """Refuse units of a dataset other than its own; those that were left out mislead nobody.

    They do not count in the checksum.
    """
    if given is not None and not (isinstance(given, str) and given == known):
        raise TableError(f"{path}: units: got {_shown(given)}, allowed: {known!r}")


def _speeds_of(text: str | None) -> tuple[float, float] | None:
    """Two speeds, in m/s, of the attribute ``valid_speed``; None of none."""
    if text is None:
        return None
    meaning = OPTIONAL_ATTRIBUTES["valid_speed"][1]
    try:
        low, high = (float(word) for word in text.split())
    except ValueError:
        raise TableError(f"valid_speed: got {_shown(text)}, allowed: {meaning}") from None
    return low, high


def _check_valid_speed(speeds: tuple[float, float] | None) -> None:
    """Refuse speeds that are no range."""
    if speeds is not None and not 0.0 <= speeds[0] <= speeds[1] <= SPEED[1]:
        meaning = OPTIONAL_ATTRIBUTES["valid_speed"][1]
        raise TableError(f"valid_speed: got {_shown(speeds)}, allowed: {meaning}")


def _check_rotation(omega: str, least: float, later: bool) -> None:
    """Refuse what no angular velocity or moment of inertia is."""
    allowed = "'mean'" if later else "'mean', 'departure'"
    if not isinstance(omega, str) or omega not in (("mean",) if later else ("mean", "departure")):
        raise TableError(f"omega: got {_shown(omega)}, allowed: {allowed}")
    if type(least) is not float or not LEAST_INERTIA[0] <= least <= LEAST_INERTIA[1]:
        meaning = OPTIONAL_ATTRIBUTES["least_inertia"][1]
        raise TableError(f"least_inertia: got {_shown(least)}, allowed: {meaning}")


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
        Those of `layout_of`; floating-point arrays are rounded to the file's type.
    pair, config, software_version : str
    seed : int
    variables, channels, processors : tuple of str
        See `ATTRIBUTES`; the file calls the variables of a state its components.
    speed_independent : bool
        Whether rebounds do not depend on the speed.
    valid_speed : tuple of two float, optional
        Speeds, m/s, between which the laws of the pair were measured.
    omega : {"departure", "mean"}
        What the angular velocity of a state is: at departure, or the mean over free tumbling.
    least_inertia : float
        Smallest moment of inertia over m a^2 of any grain; 0: not known.

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
    omega: str = "departure"
    least_inertia: float = 0.0

    def __post_init__(self) -> None:
        names = ("pair", "config", "software_version", "seed")
        _check_attributes({name: getattr(self, name) for name in names}, self.processors)
        _check_valid_speed(self.valid_speed)
        _check_rotation(self.omega, self.least_inertia, "spin/shape_inertia" in self.datasets)
        layout = layout_of(self.datasets)
        known = [dataset.path for dataset in layout]
        for path in self.datasets:
            if path not in known:
                raise TableError(f"{path}: is unknown, allowed: {', '.join(known)}")
        _check_names(self.variables, self.channels)
        shapes = {path: np.shape(values) for path, values in self.datasets.items()}
        lengths = check_shapes(shapes)
        outcomes = N_OUTCOMES_WITH_WORKS if has_works(self.variables) else N_OUTCOMES
        named = {
            "n_columns": (len(self.variables), "one for each name"),
            "n_channels": (len(self.channels), "one for each name"),
            "n_marginals": (len(self.marginals), "one for each name"),
            "n_outcomes": (outcomes, "8 with works, else 6"),
            "n_spin_factors": (outcomes * (outcomes + 1) // 2, "lower triangles"),
        }
        for dim, (needed, why) in named.items():
            if lengths.get(dim, needed) != needed:
                raise TableError(f"{dim}: got {lengths[dim]}, allowed: {needed}, {why}")
        arrays = {d.path: _coerced(d, self.datasets[d.path]) for d in layout}
        _check_values(arrays)
        if not self.of_spheres:
            _check_ranges(arrays["marginals/quantiles"], self.marginals)
        object.__setattr__(self, "datasets", arrays)

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
    def less_spheres(self) -> bool:
        """Whether the outcomes of the spin law are less those of spheres."""
        return LAW_DATASETS[0].path in self.datasets

    @property
    def marginals(self) -> tuple[str, ...]:
        """Channels with quantile functions: those that the variables are made of."""
        needed = (*channels_for(self.variables), "normal_hat")
        return tuple(name for name in self.channels if name in needed)

    @property
    def _version(self) -> tuple[int, int]:
        """Least minor version of the format that has all that is held."""
        works = has_works(self.variables)
        lost = not works and "normal_hat" in self.channels
        if self.less_spheres:
            return FORMAT_VERSION
        if self.of_spheres or lost or (works and self.has_spin):
            return FIFTH_VERSION
        if self.omega == "mean" or self.least_inertia > 0.0:
            return FOURTH_VERSION
        if works:
            return THIRD_VERSION
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
        if self.omega != "departure":
            optional["omega"] = self.omega
        if self.least_inertia > 0.0:
            optional["least_inertia"] = self.least_inertia
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


def read_table(path: str | Path) -> TableContents:
    """Read a table file and check everything in it.

    Raises
    ------
    TableError
        If the file cannot be read, is no table, is newer than this reader, was changed since it
        was written, or holds anything that the layout forbids. The message names the file, what
        is wrong with it and what is allowed.
    """
    try:
        source = check_input("table", path)
        with h5py.File(source, "r") as file:
            attributes = _read_attributes(file)
            datasets = _read_datasets(file)
    except TableError as error:
        raise TableError(f"{path}: {error}") from None
    except InputError as error:
        raise TableError(str(error)) from None
    except (OSError, RuntimeError, KeyError, ValueError, TypeError) as error:  # h5py's
        reason = str(error).partition("\n")[0]
        raise TableError(f"{path}: is damaged, or no HDF5 file ({reason})") from error
    try:
        return _contents_of(attributes, datasets)
    except TableError as error:
        raise TableError(f"{path}: {error}") from None


def _contents_of(attributes: Mapping[str, Any], datasets: Mapping[str, Array]) -> TableContents:
    """Check what was read from a file."""
    if content_sha256(datasets, attributes) != attributes["content_sha256"]:
        raise TableError("content_sha256: the contents do not have this checksum")
    known = {dataset.path for dataset in layout_of(datasets)}
    processors = attributes.get("processors")
    return TableContents(
        datasets={name: values for name, values in datasets.items() if name in known},
        pair=attributes["pair"],
        config=attributes["config"],
        seed=attributes["seed"],
        software_version=attributes["software_version"],
        variables=tuple(attributes["components"].split()),
        channels=tuple(attributes["channels"].split()),
        speed_independent="speed_independent" in attributes,
        processors=() if processors is None else tuple(processors.split("\n")),
        valid_speed=_speeds_of(attributes.get("valid_speed")),
        omega=attributes.get("omega", "departure"),
        least_inertia=attributes.get("least_inertia", 0.0),
    )


def _read_attributes(file: h5py.File) -> dict[str, Any]:
    """Read the root attributes, after format and version were found to be ours."""
    values = {name: _plain(value) for name, value in file.attrs.items()}
    if values.get("format") != FORMAT:
        raise TableError(f'format: is not "{FORMAT}", so this is some other HDF5 file')
    version = values.get("format_version")
    if not (isinstance(version, list) and [type(v) for v in version] == [int, int]):
        raise TableError(f"format_version: got {_shown(version)}, allowed: two integers")
    if version[0] != FORMAT_VERSION[0]:
        raise TableError(
            f"format_version: got {version[0]}.{version[1]}, "
            f"allowed: {FORMAT_VERSION[0]}.x (a newer file needs a newer rebound-tables)"
        )
    for name, (kind, meaning) in {**ATTRIBUTES, **OPTIONAL_ATTRIBUTES}.items():
        if name not in values:
            if name in OPTIONAL_ATTRIBUTES:
                continue
            raise TableError(f"{name}: is missing, allowed: {meaning}")
        wrong = name == "speed_independent" and values[name] != 1
        if wrong or type(values[name]) is not kind:
            raise TableError(f"{name}: got {_shown(values[name])}, allowed: {meaning}")
    return values


def _plain(value: Any) -> Any:
    """Turn the value of an attribute into Python's own types."""
    return value.tolist() if isinstance(value, np.ndarray | np.generic) else value


def _read_datasets(file: h5py.File) -> dict[str, Array]:
    """Read all datasets; those of a later minor version count in the checksum."""
    found: dict[str, h5py.Dataset] = {}

    def keep(path: str, node: Any) -> None:
        if isinstance(node, h5py.Dataset):
            found[path] = node

    file.visititems(keep)
    check_shapes({path: node.shape for path, node in found.items()})
    for known in layout_of(found):
        node, allowed = found[known.path], np.dtype(known.dtype)
        if node.dtype.str != known.dtype:
            order = "big-endian " if node.dtype.str[0] == ">" else ""
            got = f"{order}{node.dtype.name}"
            raise TableError(f"{known.path}: got {got}, allowed: {allowed.name}")
        _check_units(known.path, _plain(node.attrs.get("units")), known.units)
    return {path: node[()] for path, node in found.items()}
