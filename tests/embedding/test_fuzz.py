"""Coverage-guided fuzzing of the image reader, where clang with libFuzzer is installed."""

import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest
import toolchain
from known_vectors import TABLES, VECTORS

pytestmark = pytest.mark.study
FLAGS = ["-g", "-O2", "-fsanitize=fuzzer,address,undefined", "-fno-sanitize-recover=all"]


def fuzz(folder, seconds, header):
    """Build the fuzzer with a header and run it for a time."""
    (folder / "rebound_sampler.h").write_text(header)
    source = Path(__file__).resolve().with_name("fuzz_reader.c")
    command = [toolchain.require("clang"), "-std=gnu11", *FLAGS, f"-I{folder}", source, "-lm"]
    built = subprocess.run([*command, "-o", folder / "fuzz"], capture_output=True, text=True)
    if "clang_rt.fuzzer" in built.stderr:
        pytest.skip("clang without libFuzzer on this machine (Debian: libclang-rt-14-dev)")
    assert built.returncode == 0, built.stderr
    corpus = folder / "corpus"
    corpus.mkdir()
    images = [str(VECTORS / f"{name}.rbt") for name in TABLES]
    for number in range(len(images)):
        (corpus / f"edits{number}").write_bytes(bytes([number, *range(33)]))
    shutil.copy(images[0], corpus)
    limits = ["-max_len=16384", f"-max_total_time={seconds}", "-seed=1", "-print_final_stats=1"]
    return subprocess.run(
        [folder / "fuzz", *limits, corpus],
        capture_output=True,
        text=True,
        errors="replace",
        timeout=seconds + 120,
        env=os.environ | {"RBT_FUZZ_IMAGES": " ".join(images)},
    )


def header():
    return (toolchain.INCLUDE / "rebound_sampler.h").read_text(encoding="utf-8")


def test_nothing_is_found(tmp_path):
    run = fuzz(tmp_path, 300, header())
    assert run.returncode == 0, run.stderr[-3000:]
    tried = int(re.search(r"stat::number_of_executed_units:\s+(\d+)", run.stderr)[1])
    print(f"{tried} images tried")
    assert tried > 1000


def test_a_check_that_is_missing_is_found(tmp_path):
    text, check = header(), "(table->alias[k] & 0xffffu) < components"
    assert text.count(check) == 1
    assert fuzz(tmp_path, 300, text.replace(check, "1")).returncode != 0
