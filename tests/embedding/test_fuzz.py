"""Coverage-guided fuzzing of the image reader, where clang with libFuzzer is installed."""

import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest
import toolchain
from sampler.formats.image import write_binary_table
from small_tables import plane
from spin_tables import with_spin_law

HERE = Path(__file__).resolve().parent
VECTORS = HERE.parent / "vectors"
IMAGES = ("all-eight", "works", "normal-velocity", "plane", "pruned")
LONGEST = 16384
FLAGS = ["-g", "-fsanitize=fuzzer,address,undefined", "-fno-sanitize-recover=all"]


def build_fuzzer(folder, header=toolchain.INCLUDE / "rebound_sampler.h", level="-O2"):
    """Build the fuzzer with a header, or skip where there is no libFuzzer."""
    shutil.copy(header, folder / "rebound_sampler.h")
    clang = toolchain.require("clang")
    source = folder / "fuzz_reader.c"
    shutil.copy(HERE / "fuzz_reader.c", source)
    command = [clang, "-std=gnu11", level, *FLAGS, str(source), "-o", str(folder / "fuzz"), "-lm"]
    run = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
    if "clang_rt.fuzzer" in run.stderr:
        pytest.skip("clang without libFuzzer on this machine (Debian: libclang-rt-14-dev)")
    assert run.returncode == 0, run.stderr
    return folder / "fuzz"


def fuzz(program, folder, seconds, seed=1):
    """Run for a time; status and what was printed."""
    corpus = folder / "corpus"
    corpus.mkdir()
    images = [VECTORS / f"{name}.rbt" for name in IMAGES]
    images.append(folder / "spin.rbt")
    write_binary_table(images[-1], with_spin_law(plane(), codes=(1, 6), depth=1))
    shutil.copy(images[0], corpus)
    for image in (1, 4):
        (corpus / f"edits{image}").write_bytes(bytes([image, *range(33)]))
    limits = [f"-max_len={LONGEST}", f"-max_total_time={seconds}", f"-seed={seed}"]
    command = [str(program), *limits, "-print_final_stats=1", str(corpus)]
    return subprocess.run(
        command,
        cwd=folder,
        capture_output=True,
        text=True,
        errors="replace",
        timeout=seconds + 120,
        check=False,
        env=os.environ | {"RBT_FUZZ_IMAGES": " ".join(map(str, images))},
    )


def executions(run):
    return int(re.search(r"stat::number_of_executed_units:\s+(\d+)", run.stderr)[1])


def test_nothing_found_in_five_seconds(tmp_path):
    # the optimiser would take five times as long as the search
    run = fuzz(build_fuzzer(tmp_path, level="-O0"), tmp_path, 5)
    assert run.returncode == 0, run.stderr[-3000:]
    assert executions(run) > 0


@pytest.mark.study
def test_nothing_found_in_ten_minutes(tmp_path, capsys):
    run = fuzz(build_fuzzer(tmp_path), tmp_path, 600, seed=2)
    assert run.returncode == 0, run.stderr[-3000:]
    with capsys.disabled():
        print(f"\n{executions(run)} images tried")


@pytest.mark.study
@pytest.mark.parametrize(
    "check",
    [
        "(table->alias[k] & 0xffffu) < header->n_components",
        "span[1] >= 0.0",
        "law->node_axis[k] <= RBTI_SQUARE",
        "child >= -law->n_leaves",
    ],
)
def test_a_check_that_is_missing_is_found(check, tmp_path):
    text = (toolchain.INCLUDE / "rebound_sampler.h").read_text()
    assert text.count(check) == 1
    (tmp_path / "broken.h").write_text(text.replace(check, "1"))
    run = fuzz(build_fuzzer(tmp_path, tmp_path / "broken.h"), tmp_path, 300)
    assert run.returncode != 0
