"""`tablegen.progress`: a bar on a terminal, and lines in a log."""

from tablegen import progress


def work(shown=True):
    with progress.bar(shown, "piece", total=3, desc="fitting") as bar:
        for _ in range(3):
            bar.update()


def test_a_log_gets_lines_of_long_work_only(capsys, monkeypatch):
    work()
    assert capsys.readouterr().err == ""
    monkeypatch.setattr(progress, "INTERVAL", 0.0)
    work()
    log = capsys.readouterr().err
    assert all(line.startswith("tablegen: fitting: ") for line in log.splitlines())
    assert "1 of 3 pieces" in log
    assert "\r" not in log


def test_a_terminal_gets_a_bar(terminal, capsys):
    work()
    assert "100%" in capsys.readouterr().err
    work(shown=False)
    assert capsys.readouterr().err == ""
