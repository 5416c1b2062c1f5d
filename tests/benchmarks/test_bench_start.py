"""The benchmark of first use times programs with and without what the first run left."""

import sys

import bench_start


def test_first_and_later_runs_are_told_apart(monkeypatch):
    marks = "from pathlib import Path; p = Path('been-here')"
    work = "p.touch() if p.exists() else (p.touch(), sum(range(10**7)))"
    monkeypatch.setitem(bench_start.PROGRAMS, "made up", (sys.executable, "-c", f"{marks}; {work}"))
    name, first, again = bench_start.row("made up", 1).rsplit(maxsplit=2)
    assert name == "made up"
    assert float(first) > float(again) > 0.0


def test_a_program_of_ours_runs_with_a_cache_of_its_own():
    assert bench_start.row("tablegen inspect", 1).startswith("tablegen inspect ")
