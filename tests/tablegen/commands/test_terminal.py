"""The shell completes options and names, and output has no control codes."""

import pytest

from tablegen.commands.main import main


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
