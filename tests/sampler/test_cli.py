"""The command line of the runtime, and how both programs end."""

import errno
import json
import os
import shlex
import subprocess
import sys
from pathlib import Path

import click
import numpy as np
import pytest
from spin_tables import with_spin_law

import sampler
from sampler.cli import main
from sampler.errors import InputError
from sampler.files import available, find_config, find_table, write_text
from sampler.options import (
    BAD_INPUT,
    FAILED,
    NO_READER,
    OUTPUT,
    TABLE,
    Command,
    Named,
    Program,
    output,
    overwrite,
    run_program,
)

VECTORS = Path(__file__).resolve().parents[1] / "vectors"

HOSTILE = f"x: '\x1b[2J\x07a\x85b{10**6 * 'x'}'"

both = pytest.mark.parametrize("program", ["sampler", "tablegen"])


# -- how programs end ------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("error", "status", "line"),
    [
        (InputError("x", 1, "2"), BAD_INPUT, "error: x: got 1, allowed: 2"),
        (click.UsageError("no such thing"), BAD_INPUT, "error: no such thing"),
        (MemoryError(), BAD_INPUT, "error: there is not enough memory; ask for "),
        (KeyboardInterrupt(), 130, "interrupted"),
        (
            OSError(errno.ENOSPC, "No space left on device"),
            FAILED,
            "error: cannot write to standard output: No space left on device",
        ),
        (OSError(errno.EDQUOT, "Quota", "a/file"), BAD_INPUT, "error: a/file: Quota"),
        (ConnectionError("the scheduler is gone"), FAILED, "error: the scheduler is gone"),
        # a defect keeps its traceback, and is no missed accuracy
        (RuntimeError("odd"), FAILED, "error: "),
        # lines are short and obey no terminal
        (InputError(HOSTILE), BAD_INPUT, r"error: x: '\x1b[2J\x07a\x85b"),
    ],
)
def test_how_a_program_ends(capsys, error, status, line):
    def work():
        raise error

    program = Program("prog", commands=[click.Command("work", callback=work)])
    assert run_program(program, ["work"]) == status
    *before, line_written = capsys.readouterr().err.strip().splitlines()
    assert line_written.startswith(f"prog: {line}")
    assert line_written.endswith("not of your input; RuntimeError: odd") == bool(before)
    assert [text for text in before if text.startswith("Traceback")] == before[:1]
    assert bool(before) == isinstance(error, RuntimeError)
    assert len(line_written) < 5000
    assert line_written.isprintable()


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
        (["--output", tmp_path / "." / "t.h5"], "--output: "),
        (["--output", tmp_path / "a", "--json", tmp_path / "a"], "--json: "),
    ):
        assert run_program(program, ["work", str(path), *map(str, words)]) == BAD_INPUT
        assert named in capsys.readouterr().err
    assert run_program(program, ["work", str(path), "--output", str(tmp_path / "b")]) == 0
    assert path.read_bytes() == b"kept"


@pytest.mark.parametrize(
    ("argument", "source", "named"),
    [
        ("measurements", "", "--measured"),
        ("seed", "", "--seed"),
        ("seed", "a.toml", "a.toml: seed"),  # a field of a file
        ("table", "", "table"),  # typed without a flag
        ("output", "", "--output"),
    ],
)
def test_an_error_names_the_option_as_it_was_typed(capsys, argument, source, named):
    @click.command("work", cls=Command, epilog="")
    @click.argument("table", type=TABLE)
    @click.option("--measured", type=Named(".csv"))
    @click.option("--seed")
    @click.option("--output", type=OUTPUT)
    @click.option("--json", "json_file", type=OUTPUT)
    def work(**_):
        raise InputError(argument, 1, "2", source=source)

    assert run_program(Program("prog", commands=[work]), ["work", "t.h5"]) == BAD_INPUT
    assert capsys.readouterr().err == f"prog: error: {named}: got 1, allowed: 2\n"


def test_an_error_names_the_option_of_its_output(tmp_path, capsys):
    """Two outputs, of which the second has no folder any more at the end."""

    @click.command("work", cls=Command, epilog="")
    @click.option("--output", type=OUTPUT)
    @click.option("--json", "json_file", type=OUTPUT)
    def work(output, json_file):
        json_file.parent.rmdir()
        write_text(output, "text")
        write_text(json_file, "text")

    (tmp_path / "b").mkdir()
    words = ["work", "--output", str(tmp_path / "a"), "--json", str(tmp_path / "b" / "c")]
    assert run_program(Program("prog", commands=[work]), words) == BAD_INPUT
    assert "prog: error: --json: cannot write" in capsys.readouterr().err


def test_an_option_is_given_once(capsys):
    words = "draw corundum-steel --alpha 30 --speed 9 --count 1 --seed 1 --output a.npz --seed 2"
    assert main(words.split()) == BAD_INPUT
    assert capsys.readouterr().err == "sampler: error: --seed: is given twice; give it once\n"


@pytest.mark.parametrize(
    ("redirection", "status", "error"),
    [
        (">&-", FAILED, "Bad file descriptor\n"),
        (
            "<&- >&-",
            FAILED,
            "Bad file descriptor\n",
        ),
        (
            ">/dev/full",
            FAILED,
            "No space left on device\n",
        ),
        (">&- 2>&-", FAILED, ""),
        ("| true", NO_READER, ""),
        ("2>&1 | true", NO_READER, ""),
    ],
)
def test_standard_output_that_takes_nothing(redirection, status, error):
    """What is printed is lost, which is neither success nor a missed accuracy."""
    command = f"'{sys.executable}' -c 'import time; time.sleep(0.2); from sampler.cli import main; "
    command += f'import sys; sys.exit(main(["--version"]))\' {redirection}; exit ${{PIPESTATUS[0]}}'
    done = subprocess.run(["bash", "-c", command], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (status, "")
    line = "sampler: error: cannot write to standard output: "
    assert done.stderr == (line + error if error else "")


def test_standard_error_that_takes_nothing_changes_no_result(words):
    for redirection in ("2>&-", "2>/dev/full"):
        given = shlex.join([sys.executable, "-m", "sampler", *map(str, words(alpha=0.01))])
        assert subprocess.run(["bash", "-c", f"{given} {redirection}"], check=False).returncode == 0
        bad = shlex.join([sys.executable, "-m", "sampler", *map(str, words(alpha=91))])
        assert subprocess.run(["bash", "-c", f"{bad} {redirection}"], check=False).returncode == 2


def test_a_working_folder_that_is_gone(tmp_path):
    """Names of the package need no folder; a relative output names its option."""
    gone = tmp_path / "gone"
    for words, status, error in (
        ("list", 0, ""),
        (
            "export kharaz-2001 --output a.rbt",
            2,
            "--output: cannot write a.rbt: the ",
        ),
        ("export none.h5 --output /tmp/a.rbt", 2, "table: there is no file none.h5"),
    ):
        gone.mkdir()
        command = f"cd {gone}; rmdir {gone}; exec '{sys.executable}' -P -m sampler {words}"
        done = subprocess.run(
            ["bash", "-c", command],
            capture_output=True,
            text=True,
            check=False,
            env=os.environ | {"PYTHONPATH": str(Path(sampler.__file__).parents[1])},
        )
        assert done.returncode == status
        assert done.stderr.removeprefix("sampler: error: ").startswith(error)


def test_an_output_has_its_suffix_and_is_kept(tmp_path, capsys):
    @click.command("work", cls=Command, epilog="")
    @output("T.h5", ".h5")
    @overwrite
    def work(output):
        click.echo("done")

    program, path = Program("prog", commands=[work]), tmp_path / "t.h5"
    path.write_bytes(b"kept")
    other = tmp_path / "t.txt"
    for named, sentence in (
        (path, f"--output: {path} exists; give a new name, or --overwrite"),
        (other, f"--output: got {other}, allowed: a name that ends in .h5"),
    ):
        assert run_program(program, ["work", "--output", str(named)]) == BAD_INPUT
        assert capsys.readouterr().err == f"prog: error: {sentence}\n"
    assert run_program(program, ["work", "--output", str(path), "--overwrite"]) == 0


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
        given = [f"--{name}={x}" for name, x in (flags | changes).items() if x is not None]
        spin = ["--spin", *changes["spin"]] if "spin" in changes else []
        return ["draw", table, *(word for word in given if word[:6] != "--spin"), *spin]

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
    state, warning = draw(seed=seed)
    expected = table.sample(np.deg2rad(30.0), 150.0, seed=seed, index=range(100))
    np.testing.assert_array_equal(state, expected)
    assert warning == ""


def test_outside_is_noted_or_refused(draw, refuse, words, tmp_path, table):
    state, note = draw(alpha=10)
    sentence = (
        "got an impact at {}, allowed: 20 to 90 deg, 50 to 300 m/s, the range of the table made"
    )
    assert f"--alpha: {sentence.format('10 deg, 150 m/s')}" in note
    expected = table.sample(np.radians(table.alpha_nodes_deg[0]), 150.0, seed=1, index=range(100))
    np.testing.assert_array_equal(state, expected)
    (tmp_path / "out.npz").unlink()
    line = refuse("sampler", *words(speed=300.0001, outside="raise"))
    assert line.startswith(f"--speed: {sentence.format('30 deg, 300.0001 m/s')}")


@pytest.mark.parametrize(
    ("flag", "values"),
    {
        "alpha": (None, 91, "nan"),
        "speed": (0,),
        "count": (0,),
        "seed": (-1, 2**64),
        "output": ("out.csv", "none/out.npz"),
        "table": ("quartz", VECTORS / "full.txt"),
    }.items(),
)
def test_bad_input_of_draw_is_one_line(refuse, words, flag, values):
    for value in values:
        assert str(flag if value is None else value) in refuse("sampler", *words(**{flag: value}))


def test_spin_is_that_of_the_table_in_python(draw, words, refuse, tmp_path, contents):
    spinning, spin = with_spin_law(contents), (0.1, -0.2, -0.8)
    sampler.write_table(tmp_path / "spin.h5", spinning)
    keys = {"seed": 1, "index": range(100), "hit": 0}
    expected = sampler.Table(spinning).sample(np.deg2rad(30.0), 150.0, spin=spin, **keys)
    np.testing.assert_array_equal(draw(table=tmp_path / "spin.h5", spin=spin)[0], expected)
    (tmp_path / "out.npz").unlink()
    line = refuse("sampler", *words(spin=spin))
    assert line.startswith("--spin: the table made-up has no spin law; leave it out")


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


@both
def test_the_list_names_everything(call, program):
    listed = call(program, "list").out
    for name in (*available(".h5"), *available(".toml"), *available(".csv")):
        assert f"\n  {name} " in listed


def test_the_list_in_json_says_what_the_files_say(call):
    catalogue = json.loads(call("sampler", "list", "--json").out)
    assert sorted(catalogue["tables"]) == available(".h5")
    assert sorted([*catalogue["pairs"], *catalogue["scenes"]]) == available(".toml")
    for name, facts in catalogue["tables"].items():
        table = sampler.load(name)
        assert facts["pair"] == table.pair
        assert facts["variables"] == list(table.columns)
        assert facts["covers"] == str(table.covered)
        assert (facts["speed"] is None) == table.speed_independent
        assert facts["bytes"] == find_table(name).stat().st_size
    assert catalogue["scenes"]["no-spin"]["domain"] == {"variables": ["u", "v"]}


def test_your_own_files_beside_them_are_listed(monkeypatch, tmp_path, call):
    (tmp_path / "mine.toml").write_bytes(find_config("no-spin").read_bytes())
    monkeypatch.setattr("sampler.files.data_directory", lambda: tmp_path)
    assert "  mine  pair corundum-steel, u v\n" in call("sampler", "list").out


def test_version_and_folder_of_the_header(call):
    assert call("sampler", "--version").out.strip() == sampler.__version__
    folder = Path(call("sampler", "--include-dir").out.strip())
    assert (folder / "rebound_sampler.h").is_file()
