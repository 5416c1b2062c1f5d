"""Damaged tables are refused in one line, or read with all that they held."""

import time
from collections import Counter
from pathlib import Path

import pytest
from damaged_tables import ACCEPTABLE, mutated, read_damaged

TABLES = sorted((Path(__file__).resolve().parents[2] / "vectors").glob("*.h5"))

#: A reader that is slow, crashes, hangs and fails, each at a file of its own.
BAD_READER = """
import os, signal, sys, time
for seed in range(int(sys.argv[1]), int(sys.argv[2])):
    print(seed, "begun", flush=True)
    if seed == 1:
        os.kill(os.getpid(), signal.SIGSEGV)
    if seed == 3:
        time.sleep(60.0)
    print(seed, "raised ZeroDivisionError: oh" if seed == 4 else "same", flush=True)
"""


def _tried(seeds, seconds):
    """Try files for a time; how often each outcome came."""
    kinds = Counter()
    for outcome in read_damaged(TABLES, seeds, until=time.monotonic() + seconds):
        assert outcome.kind in ACCEPTABLE, outcome
        kinds[outcome.kind] += 1
    return kinds


def test_nothing_found_in_four_seconds():
    kinds = _tried(range(100_000), 4.0)
    assert kinds["refused"] > 10
    assert kinds["same"] > 10


@pytest.mark.study
def test_nothing_found_in_ten_minutes(capsys):
    kinds = _tried(range(10**6, 10**8), 600.0)
    with capsys.disabled():
        print(f"\n{kinds.total()} tables tried: {dict(kinds)}")


def test_bad_readers_are_found_and_those_after_them_are_read(tmp_path):
    program = tmp_path / "reader.py"
    program.write_text(BAD_READER)
    outcomes = list(read_damaged(TABLES, range(6), limit=0.5, program=str(program)))
    assert [outcome.seed for outcome in outcomes] == list(range(6))
    assert [outcome.kind for outcome in outcomes] == [
        "same",
        "died",
        "same",
        "hung",
        "raised",
        "same",
    ]
    assert outcomes[1].detail == "status -11"
    assert outcomes[4].detail == "ZeroDivisionError: oh"


def test_changes_are_those_of_the_seed_and_hit_everywhere():
    whole = TABLES[0].read_bytes()
    assert mutated(whole, 3) == mutated(whole, 3) != whole
    damaged = [mutated(whole, seed) for seed in range(300)]
    assert len(set(damaged)) > 280
    firsts = [
        next((k for k, (a, b) in enumerate(zip(whole, data, strict=False)) if a != b), len(data))
        for data in damaged
    ]
    assert min(firsts) < 2000 < 20000 < max(firsts)
