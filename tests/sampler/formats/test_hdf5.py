"""Table files: what is written is read again, and what is wrong is refused with the reason."""

import hashlib
import json
import time
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest
from refusals import refused
from synthetic_table import make_contents, make_datasets

from sampler import TableError
from sampler.files import find_table
from sampler.formats.channels import CHANNELS
from sampler.formats.hdf5 import read_table, sealed, write_table
from sampler.formats.layout import ATTRIBUTES, DATASETS, FILE_ATTRIBUTES

VECTORS = Path(__file__).resolve().parents[2] / "vectors"
QUANTILES, KNOTS, ANGLES = "marginals/quantiles", "marginals/variate_knots", "axes/alpha_coordinate"
CLASSES, ALIAS = "dependence/first_of_class", "dependence/alias_index"
REFLECTION, MEAN, FACTORS = (f"dependence/{name}" for name in ("reflection", "mean", "cholesky"))


def _all_datasets(file):
    paths = []
    file.visit(paths.append)
    return {path: file[path] for path in paths if isinstance(file[path], h5py.Dataset)}


def _checksum(file):
    """The checksum once more, from its description."""
    digest = hashlib.sha256()
    for path, node in sorted(_all_datasets(file).items()):
        values = node[()]
        digest.update(f"{path} {values.dtype.str} {json.dumps(list(values.shape))}\n".encode())
        digest.update(values.tobytes())
    for name in sorted(set(file.attrs) - {"content_sha256", "file_sha256"}):
        value = file.attrs[name]
        value = value if isinstance(value, str) else value.tolist()
        digest.update(f"{name} {json.dumps(value)}\n".encode())
    return digest.hexdigest()


def _edit(path, change, keep_checksum=False):
    with h5py.File(path, "r+") as file:
        change(file)
        if not keep_checksum:
            file.attrs["content_sha256"] = _checksum(file)
    path.write_bytes(sealed(path.read_bytes()))


@pytest.fixture
def file(tmp_path, contents):
    path = tmp_path / "t.h5"
    write_table(path, contents)
    return path


def test_round_trip(file, contents):
    read = read_table(file)
    assert set(read.datasets) == {dataset.path for dataset in DATASETS}
    for path, values in contents.datasets.items():
        np.testing.assert_array_equal(read[path], values)
        assert read[path].dtype == values.dtype
    assert read.attributes == contents.attributes
    assert read.seed == 2**64 - 1


def test_equal_contents_give_equal_bytes(file, tmp_path, contents):
    time.sleep(1.1)  # HDF5 keeps times in seconds: let the clock move on
    again = tmp_path / "another-name.h5"
    write_table(again, contents)
    assert again.read_bytes() == file.read_bytes()
    write_table(again, make_contents(seed=1))
    assert again.read_bytes() != file.read_bytes()


def test_file_describes_itself(file, contents):
    with h5py.File(file) as opened:
        assert set(opened.attrs) == {*FILE_ATTRIBUTES, *ATTRIBUTES} - {"valid_speed"}
        assert opened.attrs["format"] == "rebound-table"
        assert opened.attrs["format_version"].tolist() == [1, 0]
        assert opened.attrs["content_sha256"] == _checksum(opened) == contents.content_sha256
        for path, node in _all_datasets(opened).items():
            assert node.attrs["units"], path
            assert len(node.attrs["long_name"]) > 10, path


def test_axes_have_names_and_scales(file):
    """As readers of netCDF want them: scales in the group of a dataset, for all axes or none."""
    with h5py.File(file) as opened:
        scale_of = {}
        for dataset in DATASETS:
            node = opened[dataset.path]
            labels = [dim.label for dim in node.dims]
            assert labels == [dim if isinstance(dim, str) else "" for dim in dataset.dims]
            attached = [scale.name for dim in node.dims for scale in dim.values()]
            scale_of[dataset.path] = node.name if node.is_scale else "".join(attached)
        named = {path: scale[1:] for path, scale in scale_of.items() if scale}
    rest = ("speed", "sliced_wasserstein", "correlation_error", "auc")
    own = ("alpha_deg", "speed", "alpha_coordinate", "speed_coordinate")
    assert named == {
        **{f"axes/{name}": f"axes/{name}" for name in own},
        "marginals/variate_knots": "marginals/variate_knots",
        **{f"accuracy/{name}": "accuracy/alpha_deg" for name in ("alpha_deg", *rest)},
    }


def test_a_table_without_measured_accuracy(tmp_path):
    datasets = {k: x[:0] if k[:9] == "accuracy/" else x for k, x in make_datasets().items()}
    write_table(tmp_path / "t.h5", make_contents(datasets))
    assert read_table(tmp_path / "t.h5")["accuracy/ks"].shape == (0, 6)


@pytest.mark.parametrize(
    ("text", "pair"),
    [
        # longer than the 64 kB that HDF5 allows for an attribute stored in place
        ("# a comment\n" * 20_000, "made-up"),
        # no control characters, but what people paste into comments
        ('name = "a"\t# 5\xa0m/s, \u2264 90\xb0\r\n', "\u00e4" * 63),
    ],
)
def test_names_and_texts_that_can_be_shown(tmp_path, text, pair):
    write_table(tmp_path / "t.h5", make_contents(config=text, pair=pair))
    read = read_table(tmp_path / "t.h5")
    assert (read.config, read.pair) == (text, pair)


def test_later_minor_version_with_a_further_dataset(file):
    def change(opened):
        opened.attrs["format_version"] = [1, 7]
        opened["dependence/later"] = np.arange(3.0)

    _edit(file, change)
    assert "dependence/later" not in read_table(file).datasets
    _edit(file, lambda opened: opened["dependence/later"].write_direct(np.ones(3)), True)
    with pytest.raises(TableError, match="content_sha256"):
        read_table(file)


def _attribute(name, value):
    return lambda file: file.attrs.__setitem__(name, value)


def _value(path, where, value):
    return lambda file: file[path].__setitem__(where, value)


def _replace(path, change):
    def edit(file):
        values = change(file[path][()])
        del file[path]
        file[path] = values

    return edit


def _group_for_dataset(file):
    del file["axes/speed"]
    file.create_group("axes/speed")


#: Changes of a file by what is refused then.
REFUSED = {
    "format_version": [_attribute("format_version", version) for version in ([0, 1], [2, 0], 1)],
    "pair": [
        lambda file: file.attrs.__delitem__("pair"),
        *(_attribute("pair", text) for text in ("a\x1b[2Jb", "x" * 10**5)),
    ],
    "variables": [_attribute("variables", "u heat")],
    "channels": [_attribute("channels", " ".join(CHANNELS[:5]))],
    "n_channels": [
        _attribute("channels", " ".join(CHANNELS[:7])),
        _replace(MEAN, lambda x: x[..., :5]),
    ],
    "seed": [_attribute("seed", -1)],
    "config": [_attribute("config", "x = 1 # \x1b[2J")],
    "speed_independent": [_attribute("speed_independent", 2)],
    "valid_speed": [_attribute("valid_speed", x) for x in ([9.0, 5.0], "50 300")],
    "least_inertia": [_attribute("least_inertia", 0.7)],
    QUANTILES: [
        lambda file: file.__delitem__(QUANTILES),
        *(_replace(QUANTILES, lambda q, t=t: q.astype(t)) for t in (float, ">f4")),
        _replace(QUANTILES, lambda q: q[:2]),
        _replace(QUANTILES, lambda q: np.concatenate((q[..., 1::-1], q[..., 2:]), -1)),
        _value(QUANTILES, (0, 0, 0, 2, 64), np.inf),
    ],
    f"{QUANTILES}: of v": [_value(QUANTILES, (0,) * 5, 0.0)],
    KNOTS: [_value(KNOTS, 3, -3.0), _replace(KNOTS, lambda x: 1e7 * x)],
    "axes/speed": [
        _group_for_dataset,
        *(_value("axes/speed", *change) for change in ((0, -5.0), (1, 50.0))),
        lambda file: file["axes/speed"].attrs.__setitem__("units", "km h-1"),
    ],
    "axes/speed_span": [
        _value("axes/speed_span", 1, 299.0),
        _value("axes/speed_span", slice(None), [-1.7e308, 1.7e308]),
    ],
    "axes/alpha_deg": [
        _value("axes/alpha_deg", *change) for change in ((0, 0.0), (1, 20.0 + 1e-12))
    ],
    ANGLES: [
        _value(ANGLES, -1, 1.9),
        _replace(ANGLES, lambda x: x[:1]),
        _replace(ANGLES, lambda x: x + 1e12),
        _replace(ANGLES, lambda x: np.where(np.arange(x.size) < 100, x / 1e9, x)),
    ],
    CLASSES: [_value(CLASSES, *change) for change in (((0, 1, 0), 1), ((2, 0, 1), 6))],
    ALIAS: [_value(ALIAS, (1, 1, 2), 5)],
    REFLECTION: [_replace(REFLECTION, lambda x: x[0]), _value(REFLECTION, (0,) * 3, 4097)],
    FACTORS: [_replace(FACTORS, lambda x: x[..., :20])],
    f"{FACTORS}: diagonals": [_value(FACTORS, (0, 1, 2, 9), 0)],
    "accuracy/ks": [_value("accuracy/ks", (1, 2), 1.2)],
}


@pytest.mark.parametrize(
    ("field", "change"), [(field, change) for field in REFUSED for change in REFUSED[field]]
)
def test_wrong_contents_are_refused(file, field, change):
    _edit(file, change)
    line = refused(file, read_table, file)
    assert line.startswith(f"{file}: {field}: ")


@pytest.mark.parametrize("change", [_value(MEAN, (0, 0, 0, 0), 1), _attribute("pair", "another")])
def test_changes_are_seen_by_the_checksum(file, change):
    _edit(file, change, keep_checksum=True)
    with pytest.raises(
        TableError, match="content_sha256: the file has changed since it was written"
    ):
        read_table(file)


def test_units_that_were_left_out_mislead_nobody(file, contents):
    _edit(file, lambda opened: opened["axes/speed"].attrs.__delitem__("units"))
    assert read_table(file).content_sha256 == contents.content_sha256


def test_the_bytes_have_a_checksum(file):
    image = file.read_bytes()
    with h5py.File(file) as opened:
        digits = opened.attrs["file_sha256"]
    assert image.count(digits) == 1
    assert hashlib.sha256(image.replace(digits, b"0" * 64)).hexdigest().encode() == digits


def test_a_file_that_another_program_opens_is_kept_and_one_that_it_changes_is_refused(file):
    with h5py.File(file, "r+"):
        pass
    read_table(file)
    with h5py.File(file, "r+") as opened:
        opened["axes/speed"].attrs["remark"] = "mine"
    line = refused(f"{file}: file_sha256", read_table, file)
    assert "the file has changed since it was written" in line


@pytest.mark.parametrize("size", [64, 512])
@pytest.mark.parametrize("value", [0x00, 0xFF])
def test_damaged_blocks(file, size, value):
    """Blocks near the front, which HDF5 reads as its own, once hung it; and some of the rest."""
    whole = file.read_bytes()
    front = range(0, 8192, size)
    rest = range(8192, len(whole), len(whole) // 20 // size * size)
    for first in (*front, *rest):
        damaged = bytearray(whole)
        damaged[first : first + size] = bytes([value]) * len(damaged[first : first + size])
        if damaged == whole:
            continue
        file.write_bytes(damaged)
        begin = time.monotonic()
        assert "\n" not in refused(str(file), read_table, file)
        assert time.monotonic() - begin < 1.0


def test_truncated_files(file, tmp_path):
    """Some lengths fail on opening, some on reading; each gives one line, none gives a table."""
    whole = file.read_bytes()
    cut = tmp_path / "cut.h5"
    for length in np.linspace(0, len(whole) - 1, 40).astype(int):
        cut.write_bytes(whole[:length])
        with pytest.raises(TableError) as refusal:
            read_table(cut)
        assert "\n" not in str(refusal.value)


def test_foreign_files(tmp_path):
    refused("table", read_table, tmp_path / "none.h5")
    with pytest.raises(TableError, match="this is a binary table"):
        read_table(VECTORS / "full.rbt")
    text = tmp_path / "text.h5"
    text.write_text("not a table\n")
    with pytest.raises(TableError, match="this is no HDF5 file"):
        read_table(text)
    with h5py.File(tmp_path / "other.h5", "w") as other:
        other["temperature"] = np.arange(5)
        other.attrs["format"] = "other"
    with pytest.raises(
        TableError,
        match="the file is damaged, or no rebound table",
    ):
        read_table(tmp_path / "other.h5")


@pytest.mark.parametrize(
    ("field", "values"),
    [
        (QUANTILES, None),
        ("x/y", np.ones(3)),
        *(("axes/speed", np.array(values)) for values in ([1, 2, 3], [True, False, True])),
        (ALIAS, np.full((3, 3, 5), 65541)),
        *((MEAN, np.full((3, 3, 5, 6), value)) for value in (-32769, 0.5)),
        ("accuracy/auc", np.full(2, np.inf)),
        # Below 1 in double precision, 1 in single.
        (f"{QUANTILES}: of v", 1.0 - 1e-12),
        *(("seed", value) for value in (-1, 2**64, 1.0, True)),
        *(("pair", value) for value in (3, "a\0b")),
    ],
)
def test_contents_are_checked_before_they_are_written(field, values):
    datasets, attributes = make_datasets(), {}
    if "/" not in field:
        attributes[field] = values
    elif field.endswith("of v"):
        datasets[QUANTILES][0, 0, 0, 0, -1] = values
    else:
        datasets[field] = values
    datasets = {path: values for path, values in datasets.items() if values is not None}
    refused(field, make_contents, datasets, **attributes)


@pytest.mark.parametrize(
    ("at", "value"), [(0, 0.1), (1, 5.0), (4, -1.0), (4, 4.0), (7, 90.0), (8, 2.5), (11, 0.1)]
)
def test_wrong_laws_of_contact_are_refused(at, value):
    spheres = read_table(find_table("kharaz-2001"))
    laws = spheres["sphere/laws"].copy()
    laws[at] = value
    refused("sphere/laws", replace, spheres, datasets=spheres.datasets | {"sphere/laws": laws})
