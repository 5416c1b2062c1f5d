"""The benchmark of direct rebounds times the same rebounds in each way."""

import sys

import bench_direct
import pytest


@pytest.mark.study(
    reason="compiles loops of its own for a minute; what they call is tested elsewhere"
)
def test_all_ways_are_timed(monkeypatch, capsys):
    arguments = ["bench_direct.py", "--conditions", "3", "--particles", "20", "--rounds", "1"]
    monkeypatch.setattr(sys, "argv", arguments)
    bench_direct.main()
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 8
    assert all(line.endswith("million a second") for line in lines)
    assert [line[:12] for line in lines[::4]] == ["without spin", "with spin   "]
