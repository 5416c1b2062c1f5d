"""Comfort at a terminal: completion in three shells, and no control codes where none belong."""

import shutil
import subprocess

import pytest

from tablegen.commands.main import main

SHELLS = ("bash", "zsh", "fish")


@pytest.fixture
def answered(monkeypatch, capsys):
    """What the program prints for a shell, as its environment asks."""

    def run(instruction, **environment):
        monkeypatch.setenv("_TABLEGEN_COMPLETE", instruction)
        for name, value in environment.items():
            monkeypatch.setenv(name, value)
        with pytest.raises(SystemExit) as ended:
            main([])
        assert ended.value.code in (None, 0)
        return capsys.readouterr().out

    return run


@pytest.mark.parametrize("shell", SHELLS)
def test_source_is_a_script_of_the_shell(shell, answered, tmp_path):
    source = answered(f"{shell}_source")
    assert f"_TABLEGEN_COMPLETE={shell}_complete" in source
    script = tmp_path / "completion"
    script.write_text(source)
    if program := shutil.which(shell):
        subprocess.run([program, "-n", str(script)], check=True)
        if shell == "bash":
            words = [program, "-c", f". {script} && complete -p tablegen"]
            told = subprocess.run(words, capture_output=True, text=True, check=True).stdout
            assert "_tablegen_completion" in told


# fish names the word itself, not its place
@pytest.mark.parametrize(("shell", "word"), [("bash", "1"), ("zsh", "1"), ("fish", "ins")])
def test_commands_are_completed(shell, word, answered):
    told = answered(f"{shell}_complete", COMP_WORDS="tablegen ins", COMP_CWORD=word)
    assert "inspect" in told
    assert "validate" not in told


def test_output_has_no_control_codes(run, tiny, monkeypatch):
    # even where the environment asks programs for colours
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("CLICOLOR_FORCE", "1")
    for words in (
        ("--help",),
        ("validate", "--help"),
        ("inspect", tiny.path),
        ("validate", tiny.path, "--conditions", 1, "--samples", 1000),
        ("inspect", "no-such-table"),
        ("no-such-command",),
    ):
        ended = run(*words)
        assert ended.out + ended.err
        assert "\x1b" not in ended.out + ended.err


@pytest.mark.parametrize(
    ("line", "names"),
    [
        ("tablegen validate --cond", {"--conditions"}),
        ("tablegen inspect corundum-s", {"corundum-steel", "corundum-steel-compact"}),
        ("tablegen generate de", {"demo"}),
        ("tablegen prune corundum-steel --scene pl", {"plane-flow"}),
        ("tablegen simulate --pair fo", {"forder-1998"}),
    ],
)
def test_options_and_names_are_completed_and_so_are_files(line, names, answered):
    words = line.split()
    told = answered("bash_complete", COMP_WORDS=line, COMP_CWORD=str(len(words) - 1)).split()
    file = {f"file,{words[-1]}"} - {"file,--cond"}
    assert set(told) == {*(f"plain,{name}" for name in names), *file}
