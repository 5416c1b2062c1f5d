"""The benchmark of draws on a device runs all that it times, here on a stand-in for one."""

import sys
from pathlib import Path

import bench_device
import numpy as np
import pytest

import sampler

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "embedding"))
import cupy_on_host

COUNT = 300


@pytest.mark.parametrize("dtype", ["float64", pytest.param("float32", marks=pytest.mark.study)])
def test_every_row_is_measured(dtype, tmp_path, monkeypatch, capsys):
    words = ["bench_device", "--count", str(COUNT), "--rounds", "2", "--dtype", dtype]
    monkeypatch.setattr(sys, "argv", words)
    with cupy_on_host.in_place_of_cupy(tmp_path):
        assert bench_device.main() == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line[:32].rstrip() for line in lines[1:]] == [
        *("gather, as a draw", "draw", "rebound"),
        *("gather, as a draw with spin", "draw with spin", "rebound with spin"),
    ]


def test_a_gather_reads_within_memory(tmp_path):
    """Threads read all over the memory, whose last piece belongs to it."""
    memory = np.random.default_rng(1).bytes(1024)
    with cupy_on_host.in_place_of_cupy(tmp_path) as cupy:
        out = bench_device.gather(cupy, memory, [1, 4, 60], 2, COUNT, "float64")()
    assert len(set(cupy.asnumpy(out)[:, 0])) > 50


def test_runs_are_those_of_the_table():
    table = sampler.load("corundum-steel")
    assert bench_device.runs_of_a_draw(table) == [1, 4, 6, *[1] * 6]
    # bytes of inputs, gates of groups and of experts, an expert, spans: 56, 368, 736, 320, 48
    assert bench_device.runs_of_a_spin_draw() == [4, 23, 46, 20, 3, *[1] * 6]


def test_without_a_gpu_it_says_so(monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "cupy", None)
    monkeypatch.setattr(sys, "argv", ["bench_device"])
    assert bench_device.main() == 2
    assert capsys.readouterr().err.startswith("to_device: CuPy is not installed, allowed after: ")
