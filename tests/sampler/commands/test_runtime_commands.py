"""``sampler draw``: what it writes, and one line for every kind of bad input."""

import subprocess
import sys
import warnings
from pathlib import Path

import numpy as np
import pytest

import sampler
from sampler.commands.main import main


@pytest.fixture
def draw(table_path, tmp_path):
    """Run ``sampler draw`` with flags changed; None leaves a flag out."""

    def run(**changes):
        flags = {
            "table": str(table_path),
            "alpha": "30",
            "speed": "150",
            "count": "100",
            "seed": "1",
            "output": str(tmp_path / "out.npz"),
        }
        flags |= changes
        argv = ["draw", flags.pop("table")]
        for name, value in flags.items():
            argv += [] if value is None else [f"--{name}", value]
        return main(argv)

    return run


def test_output(draw, table, tmp_path, capsys):
    assert draw() == 0
    with np.load(tmp_path / "out.npz") as written:
        assert written.files == ["state", "columns"]
        assert tuple(written["columns"]) == table.columns
        expected = table.sample(np.deg2rad(30.0), 150.0, seed=1, index=range(100))
        np.testing.assert_array_equal(written["state"], expected)
    assert capsys.readouterr() == ("", "")
    assert [path.name for path in tmp_path.iterdir()] == ["out.npz"]


def test_output_keeps_the_name_it_was_given(draw, tmp_path):
    assert draw(output=str(tmp_path / "states")) == 0
    assert np.load(tmp_path / "states")["state"].shape == (100, 6)


def test_equal_calls_give_equal_bytes(draw, tmp_path):
    for name in ("a.npz", "b.npz"):
        assert draw(output=str(tmp_path / name)) == 0
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()


def test_largest_seed(draw, tmp_path, table):
    assert draw(seed=str(2**64 - 1), count="1") == 0
    expected = table.sample(np.deg2rad(30.0), 150.0, seed=2**64 - 1, index=[0])
    np.testing.assert_array_equal(np.load(tmp_path / "out.npz")["state"], expected)


def test_outside_is_noted_or_refused(draw, tmp_path, capsys, table):
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # the note is enough
        assert draw(alpha="10") == 0
    note = capsys.readouterr().err
    assert note.count("\n") == 1
    assert "10 deg, 150 m/s is outside the table (20 to 90 deg, 50 to 300 m/s)" in note
    expected = table.sample(np.deg2rad(20.0), 150.0, seed=1, index=range(100))
    np.testing.assert_array_equal(np.load(tmp_path / "out.npz")["state"], expected)
    assert draw(speed="301", outside="raise", output=str(tmp_path / "second.npz")) == 2
    assert "--speed: got 301, allowed: 20 to 90 deg, 50 to 300 m/s" in capsys.readouterr().err
    assert not (tmp_path / "second.npz").exists()


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"alpha": "0"}, "argument --alpha: got '0', allowed: degrees above 0, at most 90"),
        ({"alpha": "91"}, "argument --alpha: got '91', allowed"),
        ({"alpha": "nan"}, "argument --alpha: got 'nan', allowed"),
        ({"alpha": "steep"}, "argument --alpha: got 'steep', allowed"),
        ({"alpha": None}, "required: --alpha"),
        ({"speed": "-150"}, "argument --speed: got '-150', allowed: m/s above 0, finite"),
        ({"speed": "0"}, "argument --speed: got '0', allowed"),
        ({"speed": "inf"}, "argument --speed: got 'inf', allowed"),
        ({"speed": "nan"}, "argument --speed: got 'nan', allowed"),
        ({"count": "0"}, "argument --count: got '0', allowed: a whole number from 1"),
        ({"count": "-3"}, "argument --count: got '-3', allowed"),
        ({"count": "1.5"}, "argument --count: got '1.5', allowed"),
        ({"count": str(10**15)}, "argument --count: got 1000000000000000, allowed: as many"),
        ({"count": str(2**62)}, f"argument --count: got {2**62}, allowed: as many"),
        ({"seed": "-1"}, "argument --seed: got '-1', allowed: a whole number from 0"),
        ({"seed": str(2**64)}, "argument --seed: got '18446744073709551616', allowed"),
        ({"outside": "ignore"}, "argument --outside: invalid choice: 'ignore'"),
        ({"speeed": "3"}, "unrecognized arguments: --speeed 3"),
        ({"table": "quartz"}, "table: got 'quartz', allowed: a name"),
        ({"table": "none.h5"}, "table: got none.h5, allowed: a file that exists"),
        ({"output": "/none/out.npz"}, "argument --output: got /none/out.npz, allowed: a file in"),
        ({"output": "/"}, "argument --output: got /, a folder, allowed: a file name"),
    ],
)
def test_bad_input_is_one_line_and_status_two(draw, tmp_path, capsys, changes, message):
    assert draw(**changes) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("sampler: error: ")
    assert message in err
    assert err.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_damaged_table(draw, tmp_path, table_path, capsys):
    damaged = tmp_path / "damaged.h5"
    damaged.write_bytes(table_path.read_bytes()[:5000])
    assert draw(table=str(damaged)) == 2
    err = capsys.readouterr().err
    assert "damaged.h5: cannot be read as HDF5" in err
    assert err.count("\n") == 1
    assert list(tmp_path.iterdir()) == [damaged]


def test_no_command(capsys):
    assert main([]) == 2
    assert capsys.readouterr().err == (
        "sampler: error: the following arguments are required: COMMAND\n"
    )
    assert main(["drew"]) == 2
    assert "'draw'" in capsys.readouterr().err


@pytest.mark.parametrize("argv", [["--help"], ["draw", "--help"]])
def test_help_has_examples(argv, capsys):
    with pytest.raises(SystemExit) as stop:
        main(argv)
    assert stop.value.code == 0
    assert "sampler draw corundum-steel --alpha 30" in capsys.readouterr().out


def test_version(capsys):
    with pytest.raises(SystemExit) as stop:
        main(["--version"])
    assert stop.value.code == 0
    assert capsys.readouterr().out.strip() == sampler.__version__


def test_exit_status_of_the_process(table_path, tmp_path):
    command = [sys.executable, "-m", "sampler", "draw", str(table_path), "--speed", "100"]
    command += ["--count", "10", "--seed", "1", "--output", str(tmp_path / "out.npz"), "--alpha"]
    good = subprocess.run([*command, "45"], capture_output=True, text=True, check=False)
    assert (good.returncode, good.stdout, good.stderr) == (0, "", "")
    assert np.load(tmp_path / "out.npz")["state"].shape == (10, 6)
    bad = subprocess.run([*command, "91"], capture_output=True, text=True, check=False)
    assert bad.returncode == 2
    assert bad.stderr.count("\n") == 1


def test_folder_of_the_header(capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "20")
    with pytest.raises(SystemExit) as ended:
        main(["--include-dir"])
    assert ended.value.code == 0
    folder = Path(capsys.readouterr().out.removesuffix("\n"))
    assert (folder / "rebound_sampler.h").is_file()
