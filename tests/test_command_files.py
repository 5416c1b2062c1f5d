"""Files of all commands: an output is a file, and neither an input nor another output."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import click
import pytest
from command_lines import PROGRAMS
from special_files import KINDS, make_special

from sampler.commands.file_types import FileType, OutputFile
from sampler.commands.options import Command

VECTORS = Path(__file__).resolve().parent / "vectors"

COMMANDS = [(name, c) for name, cli in PROGRAMS.items() for c in cli.commands.values()]

WRITTEN = {"--output", "--json", "--html", "--statistics", "--picture"}
READ = {"table", "pair", "config", "--pair", "--scene", "--beside", "--particle", "--stability"}
READ |= {"--measured"}

#: Options that are written to and are no file: a folder.
FOLDERS = {("figures", "output")}

#: What a command needs beside its files.
KEYS = ("--alpha", 40, "--speed", 90, "--count", 5, "--seed", 1)
SIMULATE = ("simulate", "--pair", "corundum-steel", *KEYS)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Working folder with a table, a configuration of two files and a mesh."""
    monkeypatch.chdir(tmp_path)
    shutil.copy(VECTORS / "full.h5", "t.h5")
    Path("link.h5").symlink_to("t.h5")
    os.link("t.h5", "other-name.h5")
    Path("scene.toml").write_text('name = "scene"\npair = "pair.toml"\n')
    Path("pair.toml").write_text('[[population.meshes]]\nfile = "grain.stl"\n')
    Path("grain.stl").write_text("")
    return tmp_path


@pytest.mark.parametrize(("program", "command"), COMMANDS, ids=lambda x: getattr(x, "name", x))
def test_every_command_tells_its_files_apart(program, command):
    assert isinstance(command, Command)
    for param in command.params:
        if param.type.name == "boolean" or (command.name, param.name) in FOLDERS:
            continue
        assert not isinstance(param.type, click.Path | click.File)
        if set(param.opts) & WRITTEN:
            assert isinstance(param.type, OutputFile)
        if set(param.opts) & READ:
            assert isinstance(param.type, FileType)
            assert not isinstance(param.type, OutputFile)


@pytest.mark.parametrize(
    ("words", "flag", "same"),
    [
        (("tablegen export t.h5", "--output t.h5"), "--output", "table"),
        (("sampler export t.h5", "--output ./none/../link.h5"), "--output", "table"),
        (("sampler export link.h5", "--output t.h5"), "--output", "table"),
        (("tablegen validate t.h5", "--json other-name.h5"), "--json", "table"),
        (("tablegen validate t.h5", "--json v --html ./v"), "--html", "--json"),
        (("tablegen report t.h5", "--beside link.h5 --json link.h5"), "--json", "table"),
        (("tablegen report compact", "--beside t.h5 --html t.h5"), "--html", "--beside"),
        (("tablegen report t.h5", "--stability s --json s"), "--json", "--stability"),
        (("tablegen prune t.h5", "--dimension 2 --output t.h5"), "--output", "table"),
        (("tablegen prune t.h5", "--scene scene.toml --output pair.toml"), "--output", "--scene"),
        (("tablegen generate scene.toml", "--output scene.toml"), "--output", "config"),
        (("tablegen generate scene.toml", "--output pair.toml"), "--output", "config"),
        (("tablegen generate scene.toml", "--output grain.stl"), "--output", "config"),
        (("tablegen stability scene.toml", "--json scene.toml"), "--json", "pair"),
    ],
)
def test_an_output_is_no_input_and_no_other_output(folder, refuse, words, flag, same):
    (folder / "none").mkdir()
    program, *rest = " ".join(words).split()
    line = refuse(program, *rest)
    given = rest[rest.index(flag) + 1]
    assert line == f"{flag}: got {Path(given)}, the same file as {same}, allowed: another"


@pytest.mark.parametrize(
    ("words", "same"),
    [
        (("--particle", "grain.stl", "--output", "grain.stl"), "--particle"),
        (("--shape", "prism", "--output", "new", "--statistics", "none/../new"), "--output"),
    ],
)
def test_files_of_a_simulation(folder, refuse, words, same):
    (folder / "none").mkdir()
    assert f"the same file as {same}, allowed: another" in refuse("tablegen", *SIMULATE, *words)


def test_an_output_is_not_where_the_program_prints(folder):
    words = [sys.executable, "-m", "tablegen", "validate", "t.h5", "--json"]
    # not that of the system, which a failing test of the superuser would replace
    Path("own-link").symlink_to("/proc/self/fd/1")
    with open("printed.txt", "w") as printed:
        ended = [
            subprocess.run([*words, name], stdout=printed, stderr=subprocess.PIPE, text=True)
            for name in ("printed.txt", "own-link")
        ]
    assert [(e.returncode, e.stderr.count("\n")) for e in ended] == [(2, 1)] * 2
    for each in ended:
        assert "the same file as standard output, allowed: another" in each.stderr
    assert Path("printed.txt").read_text() == ""


@pytest.mark.parametrize("kind", KINDS)
def test_outputs_that_are_no_files(folder, refuse, kind):
    path, word = make_special(folder, kind)
    before = os.stat(path)
    allowed = f"got {path}, a {word}, allowed: a regular file or a new one"
    for words in (("export", "t.h5", "--output"), ("validate", "t.h5", "--html")):
        assert allowed in refuse("tablegen", *words, path)
    assert "'--output': got -, allowed: a file name" in refuse(
        "sampler", "draw", "t.h5", *KEYS, "--output", "-"
    )
    assert os.stat(path) == before


@pytest.mark.parametrize("kind", KINDS)
def test_inputs_that_are_no_files(folder, refuse, kind):
    path, word = make_special(folder, kind)
    end = path.with_name("special.stl") if kind != "device" else folder / "special.stl"
    end.symlink_to(path)
    Path("pair.toml").write_text(Path("pair.toml").read_text().replace("grain", "special"))
    output = ("--output", "new")
    for words, what in (
        (("inspect", path), "table"),
        (("generate", path, *output), "configuration"),
        ((*SIMULATE[:2], path, *KEYS, "--shape", "prism", *output), "--pair"),
        ((*SIMULATE, "--particle", end, *output), "particle"),
        (("generate", "pair.toml", *output), "pair.toml: population.meshes[0].file"),
        (("report", "t.h5", "--stability", path), "--stability"),
    ):
        line = refuse("tablegen", *words)
        assert line.startswith(f"{what}: got ")
        assert f", a {word}, allowed: " in line


def test_a_folder_of_figures(folder, refuse):
    place = folder / "figures"
    place.mkdir()
    os.mkfifo(place / "figure-03.svg")
    words = ("figures", "t.h5", "--count", 1000, "--output", place)
    assert "figure-03.svg, a pipe, allowed" in refuse("tablegen", *words)
    (place / "figure-03.svg").unlink()
    (place / "laws.json").symlink_to("../t.h5")
    assert "laws.json, which is also read, allowed: another file" in refuse("tablegen", *words)
    (folder / "lost").symlink_to("none/there")
    line = refuse("tablegen", *words[:-1], folder / "lost")
    assert "allowed: a file in a folder that exists" in line
