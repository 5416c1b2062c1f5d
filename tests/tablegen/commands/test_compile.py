"""``tablegen compile`` in an empty folder for machine code."""

import subprocess

import pytest
from processes import TABLEGEN


@pytest.mark.study
def test_afterwards_nothing_is_compiled(monkeypatch, tmp_path):
    """A study, because it compiles for half a minute."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "kernels"))

    def compiled(*words):
        ended = subprocess.run([*TABLEGEN, *words], capture_output=True, text=True, check=True)
        return [line for line in ended.stderr.splitlines() if line.startswith("compil")]

    first = compiled("compile")
    assert sum(line.startswith("compiled simulate_batch in ") for line in first) == 1
    assert compiled("compile") == []
    simulate = ["simulate", "--pair", "kharaz-2001", "--alpha", "30", "--speed", "3", "--seed", "1"]
    assert compiled(*simulate, "--count", "10", "--output", tmp_path / "a.npz") == []
