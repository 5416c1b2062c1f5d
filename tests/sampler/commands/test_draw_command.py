"""``sampler draw``: what it writes, and one line for every kind of bad input."""

import subprocess
import sys
import warnings
from pathlib import Path

import numpy as np
import pytest
from spin_tables import with_spin_law

import sampler


@pytest.fixture
def words(table_path, tmp_path):
    """Arguments of a draw with flags changed; None leaves a flag out."""

    def change(table=table_path, **changes):
        flags = {"alpha": 30, "speed": 150, "count": 100, "seed": 1, "output": tmp_path / "out.npz"}
        given = {name: value for name, value in (flags | changes).items() if value is not None}
        return ["draw", table, *(w for name, v in given.items() for w in (f"--{name}", v))]

    return change


@pytest.fixture
def draw(call, words, tmp_path):
    """States of a draw, and what it says on standard error."""

    def run(**changes):
        ended = call("sampler", *words(**changes))
        assert (ended.status, ended.out) == (0, "")
        (path,) = tmp_path.iterdir()
        with np.load(path) as written:
            assert written.files == ["state", "columns"]
            assert list(written["columns"]) == ["u", "v", "w", "omega_x", "omega_y", "omega_z"]
            return written["state"], ended.err

    return run


@pytest.mark.parametrize("seed", [1, 2**64 - 1])
def test_states_are_those_of_the_table(draw, table, seed):
    state, said = draw(seed=seed)
    expected = table.sample(np.deg2rad(30.0), 150.0, seed=seed, index=range(100))
    np.testing.assert_array_equal(state, expected)
    assert said == ""


def test_equal_calls_give_equal_bytes_under_the_name_that_was_given(draw, tmp_path):
    written = []
    for name in ("a.npz", "states"):
        draw(output=tmp_path / name)
        written.append((tmp_path / name).read_bytes())
        (tmp_path / name).unlink()
    assert written[0] == written[1]


def test_outside_is_noted_or_refused(draw, refuse, words, tmp_path, table):
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # the note is enough
        state, note = draw(alpha=10)
    assert note.count("\n") == 1
    assert "10 deg, 150 m/s is outside the table (20 to 90 deg, 50 to 300 m/s)" in note
    expected = table.sample(np.deg2rad(20.0), 150.0, seed=1, index=range(100))
    np.testing.assert_array_equal(state, expected)
    line = refuse("sampler", *words(speed=301, outside="raise", output=tmp_path / "second.npz"))
    assert line == "--speed: got 301, allowed: 20 to 90 deg, 50 to 300 m/s"
    line = refuse("sampler", *words(speed=300.0001, outside="raise", output=tmp_path / "third.npz"))
    assert line == "--speed: got 300.0001, allowed: 20 to 90 deg, 50 to 300 m/s"


@pytest.mark.parametrize("flag", ["alpha", "speed", "count", "seed", "output"])
def test_what_is_left_out_is_named(refuse, words, flag):
    assert f"'--{flag}'" in refuse("sampler", *words(**{flag: None}))


@pytest.mark.parametrize(
    ("flag", "values"),
    {
        "alpha": ["0", "91", "nan", "steep"],
        "speed": ["-150", "0", "inf", "nan"],
        "count": ["0", "-3", "1.5", str(2**62)],
        "seed": ["-1", str(2**64)],
        "outside": ["ignore"],
    }.items(),
)
def test_flag_and_value_are_named(refuse, words, flag, values):
    for value in values:
        line = refuse("sampler", *words(**{flag: value}))
        assert f"'--{flag}': " in line
        assert f"'{value}'" in line


@pytest.mark.parametrize(
    ("changes", "named"),
    [
        ({"count": 2**40}, "not enough memory, allowed: a smaller count"),
        ({"speeed": "3"}, "--speeed"),
        ({"table": "quartz"}, "table: got 'quartz', allowed: a name"),
        ({"table": "none.h5"}, "table: got none.h5, allowed: a file that exists"),
        ({"output": "/none/out.npz"}, "'--output': got /none/out.npz, allowed: a file in"),
        ({"output": "/"}, "'--output': got /, a folder, allowed: a regular file"),
    ],
)
def test_bad_input_is_one_line(refuse, words, changes, named):
    assert named in refuse("sampler", *words(**changes))


def test_damaged_table(refuse, words, tmp_path, table_path):
    damaged = tmp_path / "damaged.h5"
    damaged.write_bytes(table_path.read_bytes()[:5000])
    assert "damaged.h5: cannot be read as HDF5" in refuse("sampler", *words(table=damaged))


@pytest.mark.parametrize(("arguments", "named"), [([], "command"), (["drew"], "draw")])
def test_no_command(refuse, arguments, named):
    assert named in refuse("sampler", *arguments)


def test_version(call):
    assert call("sampler", "--version").out.strip() == sampler.__version__


def test_exit_status_of_the_process(words, tmp_path):
    def run(alpha):
        command = [sys.executable, "-m", "sampler", *map(str, words(alpha=alpha))]
        return subprocess.run(command, capture_output=True, text=True, check=False)

    good, bad = run(45), run(91)
    assert (good.returncode, good.stdout, good.stderr) == (0, "", "")
    assert np.load(tmp_path / "out.npz")["state"].shape == (100, 6)
    assert (bad.returncode, bad.stderr.count("\n")) == (2, 1)


def test_folder_of_the_header(call, monkeypatch):
    monkeypatch.setenv("COLUMNS", "20")  # the path is not broken
    ended = call("sampler", "--include-dir")
    assert ended.status == 0
    assert (Path(ended.out.removesuffix("\n")) / "rebound_sampler.h").is_file()


def test_spin_is_that_of_the_table_in_python(call, refuse, tmp_path, contents, table_path):
    path, output = tmp_path / "spinning.h5", tmp_path / "a.npz"
    sampler.write_table(path, with_spin_law(contents))
    given = ["--alpha", 30, "--speed", 100, "--count", 20, "--seed", 3, "--output", output]
    spin = ["--spin", 0.1, 0, -0.8]
    assert call("sampler", "draw", path, *given, *spin).status == 0
    expected = sampler.load(path).sample(
        np.radians(30.0), 100.0, spin=(0.1, 0.0, -0.8), seed=3, index=range(20)
    )
    np.testing.assert_array_equal(np.load(output)["state"], expected)
    given[-1] = tmp_path / "b.npz"
    line = refuse("sampler", "draw", table_path, *given, *spin)
    assert line == "--spin: got one, allowed: none, for the table has no spin law"
    line = refuse("sampler", "draw", path, *given, "--spin", "nan", 0, 0)
    assert line.endswith("got 'nan', allowed: a number from -1e6 to 1e6")
    fast = ["--spin", 0, 0, 100]
    line = refuse("sampler", "draw", path, *given, *fast, "--outside", "raise")
    assert line.startswith("speed: got 8165.57816 at index 0, allowed: from 5 to 600 m/s of V")
    ended = call("sampler", "draw", path, *given, *fast)
    assert ended.status == 0
    assert "speed: got 8165.57" in ended.err
    assert ended.err.count("\n") == 1
