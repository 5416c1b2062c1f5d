"""The shell completes options and names, and output has no control codes."""

import os
import subprocess
import sys

import numpy as np
import pytest
from refusals import refused as refused_call

from sampler.options import NO_READER
from tablegen.commands.joint_picture import Source, joint_picture
from tablegen.commands.main import main
from tablegen.presentation import require_matplotlib


@pytest.fixture
def answered(monkeypatch, capsys):
    """Return the completions that the program prints for a shell."""

    def run(line):
        monkeypatch.setenv("_TABLEGEN_COMPLETE", "bash_complete")
        monkeypatch.setenv("COMP_WORDS", line)
        monkeypatch.setenv("COMP_CWORD", str(len(line.split()) - 1))
        with pytest.raises(SystemExit) as ended:
            main([])
        assert ended.value.code in (None, 0)
        return capsys.readouterr().out.split()

    return run


def test_output_has_no_control_codes(run, tiny, monkeypatch):
    # even where the environment asks programs for colours
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("CLICOLOR_FORCE", "1")
    for words in (("--help",), ("inspect", tiny.path), ("no-such-command",)):
        ended = run(*words)
        assert ended.out + ended.err
        assert "\x1b" not in ended.out + ended.err


@pytest.mark.parametrize(
    ("line", "names"),
    [
        ("tablegen ins", {"inspect"}),
        ("tablegen validate --cond", {"--conditions"}),
        ("tablegen inspect forder", {"forder-1998"}),
        ("tablegen generate de", {"demo"}),
        ("tablegen prune corundum-steel --scene pl", {"plane-flow"}),
        ("tablegen simulate --pair fo", {"forder-1998"}),
    ],
)
def test_options_and_names_are_completed_and_so_are_files(line, names, answered):
    file = {f"file,{line.split()[-1]}"} - {"file,--cond", "file,ins"}
    assert set(answered(line)) == {*(f"plain,{name}" for name in names), *file}


class BrokenPipe:
    """Standard output whose reader has gone."""

    encoding = "utf-8"

    def write(self, text):
        raise BrokenPipeError

    def flush(self):
        pass


@pytest.mark.usefixtures("quick_classifier")
def test_results_are_written_before_they_are_printed(tiny, tmp_path, monkeypatch):
    output = tmp_path / "results.json"
    for words in (
        ("validate", tiny.path, "--conditions", 1, "--samples", 4000, "--seed", 1),
        ("compare", "corundum-steel", "--measured", "kharaz-2001", "--count", 20),
    ):
        with monkeypatch.context() as patch:
            patch.setattr("sys.stdout", BrokenPipe())
            assert main([*map(str, words), "--quiet", "--json", str(output)]) == NO_READER
        assert output.stat().st_size > 1000
        output.unlink()


@pytest.mark.parametrize("module", ["sampler.numba", "tablegen.model.jit"])
def test_numba_must_compile(module):
    words = [sys.executable, "-c", f"import {module}"]
    environment = os.environ | {"NUMBA_DISABLE_JIT": "1"}
    done = subprocess.run(words, capture_output=True, text=True, check=False, env=environment)
    assert "InputError: NUMBA_DISABLE_JIT: is set, and " in done.stderr.splitlines()[-1]


def test_pictures_do_not_depend_on_the_settings_of_matplotlib():
    matplotlib = pytest.importorskip("matplotlib")
    source = Source("direct simulation", np.random.default_rng(1).normal(size=(500, 6)))
    pictures = []
    for settings in ({}, {"text.usetex": True, "savefig.bbox": "tight", "figure.dpi": 7}):
        with matplotlib.rc_context(settings):
            pictures.append(joint_picture([source, source], "a.png", "title"))
    assert pictures[0] == pictures[1]


def test_the_backend_of_a_notebook_is_not_used():
    pytest.importorskip("matplotlib")
    script = "from tablegen.presentation import require_matplotlib as r; r('--picture')"
    environment = os.environ | {"MPLBACKEND": "module://nobody.knows"}
    subprocess.run([sys.executable, "-c", script], check=True, env=environment)


def test_a_matplotlib_that_cannot_be_imported(monkeypatch):
    pytest.importorskip("matplotlib")
    monkeypatch.setenv("MPLBACKEND", "svg")  # restored after the test
    for error, problem in ((ImportError(), "is not installed"), (ValueError("x"), "ValueError: x")):

        class Broken:
            def find_spec(self, name, *_, error=error):
                if name == "matplotlib":
                    raise error

        with monkeypatch.context() as patch:
            patch.delitem(sys.modules, "matplotlib")
            patch.setattr(sys, "meta_path", [Broken(), *sys.meta_path])
            assert problem in refused_call("--picture", require_matplotlib, "--picture")
