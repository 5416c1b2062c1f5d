"""The command line of the runtime, and how both programs end."""

import errno
import json
import subprocess
import sys
from pathlib import Path

import click
import numpy as np
import pytest
from spin_tables import with_spin_law

import sampler
from sampler.errors import InputError
from sampler.files import available, find_config, find_table
from sampler.formats.binary_layout import field_offset
from sampler.options import BAD_INPUT, FAILED, OUTPUT, TABLE, Command, Program, run_program

VECTORS = Path(__file__).resolve().parents[1] / "vectors"

both = pytest.mark.parametrize("program", ["sampler", "tablegen"])


# -- how programs end ------------------------------------------------------------------------------


def _run(error, capsys):
    """Run a program of one command that raises an error: status and standard error."""

    def work():
        raise error

    status = run_program(Program("prog", commands=[click.Command("work", callback=work)]), ["work"])
    return status, capsys.readouterr().err


@pytest.mark.parametrize(
    ("error", "status", "line"),
    [
        (InputError("x: got 1, allowed: 2"), BAD_INPUT, "error: x: got 1, allowed: 2"),
        (click.UsageError("no such thing"), BAD_INPUT, "error: no such thing"),
        (MemoryError(), BAD_INPUT, "error: not enough memory, allowed: a smaller count"),
        (KeyboardInterrupt(), 130, "interrupted"),
        (OSError(errno.ENOSPC, "No space left"), FAILED, "error: [Errno 28] No space left"),
    ],
)
def test_mistakes_of_users_are_one_line(capsys, error, status, line):
    ended, told = _run(error, capsys)
    assert ended == status
    assert told.strip().startswith(f"prog: {line}")
    assert told.strip().count("\n") == 0


def test_a_defect_keeps_its_traceback_and_is_no_missed_accuracy(capsys):
    status, told = _run(RuntimeError("odd"), capsys)
    assert status == FAILED == 3
    assert told.startswith("Traceback")
    assert told.splitlines()[-1].endswith("please report it; RuntimeError: odd")


def test_lines_are_short_and_obey_no_terminal(capsys):
    error = InputError("pair: got '\x1b[2J\x07evil\x85name" + 10**6 * "x" + "'")
    status, told = _run(error, capsys)
    assert status == BAD_INPUT
    assert told.startswith("prog: error: pair: got '\\x1b[2J\\x07evil name")
    assert len(told) < 5000
    assert all(c.isprintable() for c in told[:-1])


def test_an_output_is_no_input(tmp_path, capsys):
    @click.command("work", cls=Command, epilog="")
    @click.argument("table", type=TABLE)
    @click.option("--output", type=OUTPUT)
    @click.option("--json", "json_file", type=OUTPUT)
    def work(table, output, json_file):
        click.echo("done")

    program, path = Program("prog", commands=[work]), tmp_path / "t.h5"
    path.write_bytes(b"kept")
    for words, named in (
        (["--output", tmp_path / "." / "t.h5"], "--output: got"),
        (["--output", tmp_path / "a", "--json", tmp_path / "a"], "--json: got"),
    ):
        assert run_program(program, ["work", str(path), *map(str, words)]) == BAD_INPUT
        assert named in capsys.readouterr().err
    assert run_program(program, ["work", str(path), "--output", str(tmp_path / "b")]) == 0
    assert path.read_bytes() == b"kept"


@both
def test_unknown_commands_and_options_are_one_line(program, refuse):
    assert "COMMAND: got 'lost', allowed: " in refuse(program, "lost")
    assert "--jsn" in refuse(program, "list", "--jsn")


# -- draw ------------------------------------------------------------------------------------------


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
    """States of a draw, and its notes on standard error."""

    def run(**changes):
        ended = call("sampler", *words(**changes))
        assert (ended.status, ended.out) == (0, "")
        with np.load(tmp_path / "out.npz") as written:
            assert list(written["columns"]) == ["u", "v", "w", "omega_x", "omega_y", "omega_z"]
            return written["state"], ended.err

    return run


@pytest.mark.parametrize("seed", [1, 2**64 - 1])
def test_states_are_those_of_the_table(draw, table, seed):
    state, said = draw(seed=seed)
    expected = table.sample(np.deg2rad(30.0), 150.0, seed=seed, index=range(100))
    np.testing.assert_array_equal(state, expected)
    assert said == ""


def test_outside_is_noted_or_refused(draw, refuse, words, tmp_path, table):
    state, note = draw(alpha=10)
    assert "--alpha: got an impact at 10 deg, 150 m/s, allowed: 20 to 90 deg, 50 to 300" in note
    expected = table.sample(table.alpha_range[0], 150.0, seed=1, index=range(100))
    np.testing.assert_array_equal(state, expected)
    (tmp_path / "out.npz").unlink()
    line = refuse("sampler", *words(speed=300.0001, outside="raise"))
    said = "--speed: got an impact at 30 deg, 300.0001 m/s, allowed: 20 to 90 deg, 50 to 300 m/s, "
    assert line == f"{said}the range of the table made-up"


@pytest.mark.parametrize(
    ("changes", "named"),
    [
        ({"alpha": None}, "'--alpha'"),
        ({"alpha": 91}, "'--alpha': got '91', allowed: above 0 and up to 90"),
        ({"alpha": "nan"}, "'--alpha': got 'nan'"),
        ({"speed": 0}, "'--speed': got '0'"),
        ({"count": 0}, "'--count': got '0'"),
        ({"seed": -1}, "'--seed': got '-1'"),
        ({"seed": 2**64}, "'--seed': got"),
        ({"output": "out.csv"}, "'--output': got out.csv, allowed: a name in .npz"),
        ({"output": "none/out.npz"}, "'--output': got none/out.npz, allowed: a file in a folder"),
        ({"table": "quartz"}, "table: got 'quartz', allowed: a name"),
        ({"table": VECTORS / "full.txt"}, "full.txt: is damaged, or no HDF5 file"),
    ],
)
def test_bad_input_of_draw_is_one_line(refuse, words, changes, named):
    assert named in refuse("sampler", *words(**changes))


def test_spin_is_that_of_the_table_in_python(call, refuse, tmp_path, contents, table_path):
    path, output = tmp_path / "spin.h5", tmp_path / "a.npz"
    spinning = with_spin_law(contents)
    sampler.write_table(path, spinning)
    given = ["--alpha", 30, "--speed", 150, "--count", 20, "--seed", 1, "--output", output]
    spin = ["--spin", 0.1, -0.2, -0.8]
    assert call("sampler", "draw", path, *given, *spin).status == 0
    expected = sampler.Table(spinning).sample(
        np.deg2rad(30.0), 150.0, spin=spin[1:], seed=1, index=range(20), hit=0
    )
    np.testing.assert_array_equal(np.load(output)["state"], expected)
    line = refuse("sampler", "draw", table_path, *given, *spin)
    assert line == "--spin: is given, but the table made-up has no spin law: leave it out"


def test_the_process_ends_with_the_status(words):
    for changes, status in (({}, 0), ({"alpha": 91}, 2)):
        given = [sys.executable, "-m", "sampler", *map(str, words(**changes))]
        done = subprocess.run(given, capture_output=True, text=True, check=False)
        assert (done.returncode, done.stderr.count("\n")) == (status, status // 2)


# -- export and list -------------------------------------------------------------------------------


@both
@pytest.mark.parametrize("name", ["full", "plane"])
def test_an_export_has_the_known_bytes_and_replaces_an_older_one(call, tmp_path, program, name):
    output = tmp_path / "t.rbt"
    output.write_bytes(b"older")
    ended = call(program, "export", VECTORS / f"{name}.h5", "--output", output)
    assert (ended.status, ended.err) == (0, "")
    assert ended.out == f"{output}: {output.stat().st_size / 1e6:.2f} MB, made-up\n"
    # the very bytes, whatever the processor
    assert output.read_bytes() == (VECTORS / f"{name}.rbt").read_bytes()
    assert [path.name for path in tmp_path.iterdir()] == ["t.rbt"]


def test_an_export_of_a_shipped_table_by_name(call, tmp_path):
    image = tmp_path / "t.rbt"
    assert call("sampler", "export", "corundum-steel-compact", "--output", image).status == 0
    assert image.read_bytes()[field_offset("pair") :].startswith(b"corundum-steel\0")


@both
def test_the_list_names_everything(call, program):
    kinds, found = ("tables", "pairs", "scenes", "measurements"), {}
    for line in call(program, "list").out.splitlines():
        if line in kinds:
            names = found[line] = {}
        else:
            name, _, text = line.strip().partition(" ")
            names[name] = text.strip()
    assert tuple(found) == kinds
    assert sorted(found["tables"]) == available(".h5")
    assert sorted([*found["pairs"], *found["scenes"]]) == available(".toml")
    assert sorted(found["measurements"]) == available(".csv")
    assert found["tables"]["corundum-steel"].startswith(
        "0.5 to 90 deg, 5 to 300 m/s, spin to 10, u v"
    )
    assert found["pairs"]["corundum-steel"] == "synthetic corundum on steel St3"


def test_the_list_in_json_says_what_the_files_say(call):
    found = json.loads(call("sampler", "list", "--json").out)
    for name, facts in found["tables"].items():
        table = sampler.load(name)
        assert facts["pair"] == table.pair
        assert facts["components"] == list(table.columns)
        assert facts["covers"] == str(table.covered)
        assert (facts["speed"] is None) == table.speed_independent
        assert facts["bytes"] == find_table(name).stat().st_size
    assert found["scenes"]["no-spin"]["domain"] == {"components": ["u", "v"]}


def test_your_own_files_beside_them_are_listed(monkeypatch, tmp_path, call):
    (tmp_path / "mine.toml").write_bytes(find_config("no-spin").read_bytes())
    monkeypatch.setattr("sampler.files.data_directory", lambda: tmp_path)
    assert "  mine  pair corundum-steel, u v\n" in call("sampler", "list").out


def test_version_and_folder_of_the_header(call):
    assert call("sampler", "--version").out.strip() == sampler.__version__
    folder = Path(call("sampler", "--include-dir").out.strip())
    assert (folder / "rebound_sampler.h").is_file()
