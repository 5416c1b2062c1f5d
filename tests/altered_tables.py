"""Tables whose numbers or attributes were altered and whose checksum was made right again.

Such a file says that it is whole, so a reader must judge its contents: it refuses the file in one
line, or draws finite states that leave the wall without a gain of energy.
"""

import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np

#: What may become of an altered table: refused in one line, or drawn as a table must be.
ACCEPTABLE = ("refused", "drawn")

#: Numbers that quantiles, factors, knots and coordinates are replaced by.
_FLOATS = (np.nan, np.inf, -np.inf, 0.0, -0.0, 1e300, -1e300, 1e-300, 5e-324, 1.7e308, 1e12, 1.0)

#: Attributes that are replaced, and by what.
_ATTRIBUTES: dict[str, tuple[Any, ...]] = {
    "pair": ("", "gold-\x1b[31mglass", "x" * 100_000, "a\nb", 3),
    "config": ("", "name = ", 'pair = "../../../etc/passwd"', "x" * 100_000),
    "seed": (-1, 2**64 - 1, 1.5, "one"),
    "components": ("", "u v", "w v u", "u u u u u u", "u v w omega_x omega_y omega_z q"),
    "channels": ("", "u_hat", "v u_hat w_hat omega_x omega_y omega_z"),
    "software_version": ("", "\x1b]0;x\x07", "9" * 100_000),
    "format_version": ([0, 0], [99, 1], [1], "1.0"),
    "speed_independent": (0, 1, 2, -1),
    "processors": ("", "\n", "a\x1b[2J"),
}

Values = np.ndarray


def _one(values: Values, rng: np.random.Generator) -> None:
    """One number becomes an odd one."""
    at = int(rng.integers(values.size))
    if values.dtype.kind == "f":
        with np.errstate(over="ignore"):  # in single precision
            values.flat[at] = rng.choice(_FLOATS)
    else:
        info = np.iinfo(values.dtype)
        values.flat[at] = rng.choice([info.min, info.max, 0, 1, info.max // 2])


def _flipped(values: Values, rng: np.random.Generator) -> None:
    """One bit of one number."""
    raw = values.reshape(-1).view(np.uint8)
    raw[rng.integers(raw.size)] ^= np.uint8(1 << int(rng.integers(8)))


def _scaled(values: Values, rng: np.random.Generator) -> None:
    """All numbers are multiplied."""
    factor = float(rng.choice([-1.0, 0.0, 0.5, 2.0, 1e-30, 1e30]))
    with np.errstate(all="ignore"), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        values[...] = (values * factor).astype(values.dtype)


def _shifted(values: Values, rng: np.random.Generator) -> None:
    """All numbers are moved by as much."""
    shift = float(rng.choice([1.0, -1.0, 1e6, 1e12, -1e12]))
    with np.errstate(all="ignore"), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        values[...] = (values + shift).astype(values.dtype)


def _rolled(values: Values, rng: np.random.Generator) -> None:
    """Numbers move along an axis."""
    values[...] = np.roll(values, 1, axis=int(rng.integers(values.ndim)))


def _blanked(values: Values, rng: np.random.Generator) -> None:
    """A block of numbers becomes 0, or NaN."""
    at, size = int(rng.integers(values.size)), int(rng.choice([2, 16, 256]))
    blank = np.nan if values.dtype.kind == "f" and rng.random() < 0.3 else 0
    values.reshape(-1)[at : at + size] = blank


def _shuffled(values: Values, rng: np.random.Generator) -> None:
    """A block of numbers in another order."""
    at, size = int(rng.integers(values.size)), int(rng.choice([2, 16, 256]))
    rng.shuffle(values.reshape(-1)[at : at + size])


_CHANGES: tuple[Callable[[Values, np.random.Generator], None], ...] = (
    *[_one] * 5,
    *[_flipped] * 4,
    _scaled,
    _shifted,
    _rolled,
    _blanked,
    _shuffled,
)


def _alter_dataset(file: h5py.File, paths: list[str], rng: np.random.Generator) -> None:
    node = file[paths[rng.integers(len(paths))]]
    values = np.ascontiguousarray(node[()])
    if values.size and values.ndim:
        _CHANGES[rng.integers(len(_CHANGES))](values, rng)
        node[...] = values


def _alter_attribute(file: h5py.File, rng: np.random.Generator) -> None:
    name = list(_ATTRIBUTES)[rng.integers(len(_ATTRIBUTES))]
    choices = _ATTRIBUTES[name]
    file.attrs[name] = choices[rng.integers(len(choices))]


def alter(path: Path, seed: int) -> None:
    """Alter a table file in place, once to three times, and make its checksum right."""
    from sampler.formats.hdf5 import content_sha256

    rng = np.random.default_rng(seed)
    with h5py.File(path, "r+") as file:
        paths: list[str] = []
        file.visititems(
            lambda name, node: paths.append(name) if isinstance(node, h5py.Dataset) else None
        )
        for _ in range(int(rng.choice([1, 1, 2, 3]))):
            if rng.random() < 0.15:
                _alter_attribute(file, rng)
            else:
                _alter_dataset(file, paths, rng)
        attributes = {name: _plain(value) for name, value in file.attrs.items()}
        datasets = {name: file[name][()] for name in paths}
        file.attrs["content_sha256"] = content_sha256(datasets, attributes)


def _plain(value: Any) -> Any:
    return value.tolist() if isinstance(value, np.generic | np.ndarray) else value


def problem_of(states: Values, columns: tuple[str, ...]) -> str:
    """Say what is wrong with drawn states; empty if nothing is."""
    if not np.isfinite(states).all():
        return "a state is not finite"
    column = {name: states[:, k] for k, name in enumerate(columns)}
    if "v" in column and not (column["v"] > 0.0).all():
        return "a particle does not leave"
    energy = sum((column[name] ** 2 for name in ("u", "v", "w") if name in column), np.zeros(1))
    return "energy is gained" if energy.max() > 1.0 + 1e-9 else ""


def judge(path: Path) -> tuple[str, str]:
    """Kind and detail of what becomes of an altered table: loaded, drawn from, exported."""
    import sampler
    from sampler.errors import TableError

    try:
        table = sampler.load(path)
    except TableError as error:
        line = str(error)
        tame = line.isprintable() and len(line) < 4000
        return ("refused" if tame else "raised"), repr(line)[:300]
    rng = np.random.default_rng(0)
    n = 512
    alpha1 = np.append(rng.uniform(1e-6, np.pi / 2, n), [1e-12, np.pi / 2])
    speed = np.append(np.exp(rng.uniform(-5.0, 12.0, n)), [5e-324, 1e150])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # draws outside of the table
        states = table.sample(alpha1, speed, seed=1, index=np.arange(n + 2))
    problem = problem_of(states, table.columns)
    if problem:
        return "wrong", problem
    return "drawn", ""
