"""The number of processors is counted in one place, and is what the system grants."""

import ast
import os
from pathlib import Path

import pytest

from sampler.compilation import processors as module
from sampler.compilation.processors import processors

ROOT = Path(__file__).resolve().parents[3]
COUNTS = {"cpu_count", "process_cpu_count", "sched_getaffinity"}


@pytest.fixture
def three_of_eight(monkeypatch, tmp_path):
    """Machine of eight processors that grants three, without a quota."""
    monkeypatch.delattr(os, "process_cpu_count", raising=False)
    monkeypatch.setattr(os, "cpu_count", lambda: 8)
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {1, 5, 7}, raising=False)
    monkeypatch.setattr(module, "_QUOTA", tmp_path / "cpu.max")
    return tmp_path / "cpu.max"


def test_those_granted(three_of_eight):
    assert processors() == 3


def test_all_where_no_part_is_granted(three_of_eight, monkeypatch):
    monkeypatch.delattr(os, "sched_getaffinity")
    assert processors() == 8


def test_newer_python_counts_itself(three_of_eight, monkeypatch):
    monkeypatch.setattr(os, "process_cpu_count", lambda: 2, raising=False)
    assert processors() == 2


@pytest.mark.parametrize(
    ("quota", "count"),
    [
        ("max 100000\n", 3),
        ("200000 100000\n", 2),
        ("150000 100000\n", 2),
        ("1000 100000\n", 1),
        ("900000 100000\n", 3),
    ],
)
def test_quota_of_a_container(three_of_eight, quota, count):
    three_of_eight.write_text(quota)
    assert processors() == count


def _counts(path):
    tree = ast.parse(path.read_text(encoding="utf-8"))
    names = {node.attr for node in ast.walk(tree) if isinstance(node, ast.Attribute)}
    return names & COUNTS


def test_no_other_module_counts():
    files = [
        path for part in ("sampler", "tablegen", "docs") for path in (ROOT / part).rglob("*.py")
    ]
    files += [*ROOT.glob("tests/benchmarks/*.py"), *ROOT.glob("tests/examples/**/*.py")]
    assert len(files) > 100
    assert [path.name for path in files if _counts(path)] == ["processors.py"]


def test_commands_use_those_granted(three_of_eight):
    from tablegen.evidence.machine import machine
    from tablegen.simulation.simulate import check_run

    assert check_run(1, 1, 0, None) == 3
    assert machine()["cores"] == 3
