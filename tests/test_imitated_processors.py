"""Imitated processors are really others: what `tests/processors.py` claims to switch."""

import json
import os
import platform
import subprocess
import sys

import processors
import pytest
from documents import ROOT

needs_avx2 = pytest.mark.skipif(
    processors.IMITATED in os.environ
    or platform.machine() not in ("x86_64", "AMD64")
    or not any(name in ("AVX2", "X86_V3") for name in processors.numpy_features()),
    reason="needs an x86-64 processor with AVX2, as it is",
)


def seen_as(name):
    """What a process sees that runs as on another processor."""
    script = [sys.executable, str(ROOT / "tests" / "processors.py"), name]
    ended = subprocess.run(
        [*script, *script[:2], "seen"], capture_output=True, text=True, timeout=120, check=True
    )
    return json.loads(ended.stdout)


@needs_avx2
@pytest.mark.parametrize("name", processors.SETTINGS)
def test_libraries_see_another_processor(name):
    here, there = processors.seen(), seen_as(name)
    assert processors.unswitched(name, there) == []
    if name != "avx2":
        # what has no switch would show here: as on this processor
        assert set(processors.unswitched(name, here)) == {"numpy", "blas", "numba"}
    if platform.libc_ver()[0] == "glibc":
        # AVX2 and AVX-512 processors use the same functions of the C library
        assert (there["libm"] != here["libm"]) == (name == "no-fma")


@needs_avx2
def test_kernels_of_two_processors_lie_in_one_cache(tmp_path):
    """The second process must not run the machine code of the first, nor lose it."""
    source = tmp_path / "cached.py"
    imported = "from tablegen.model.jit import kernel"
    source.write_text(f"{imported}\n@kernel\ndef f(x):\n    return x + 1.0\n")
    script = (
        "import cached; cached.f(1.0); stats = cached.f.stats;"
        "print(sum(stats.cache_hits.values()), sum(stats.cache_misses.values()))"
    )

    def run(*before):
        words = [*before, sys.executable, "-c", script]
        paths = os.pathsep.join([str(tmp_path), str(ROOT)])
        added = {"NUMBA_CACHE_DIR": str(tmp_path / "cache"), "PYTHONPATH": paths}
        ended = subprocess.run(
            words, env=os.environ | added, cwd=tmp_path, capture_output=True, text=True, check=True
        )
        return ended.stdout.strip()

    imitating = sys.executable, str(ROOT / "tests" / "processors.py"), "avx2"
    assert [run(), run(*imitating), run(), run(*imitating)] == ["0 1", "0 1", "1 0", "1 0"]


@pytest.mark.processor
@pytest.mark.skipif(processors.IMITATED not in os.environ, reason="runs as on this processor")
def test_this_run_is_as_on_the_processor_that_it_names():
    assert processors.unswitched(os.environ[processors.IMITATED], processors.seen()) == []


@pytest.mark.parametrize(
    ("words", "line"),
    [
        (["avx3", "true"], "usage: "),
        (["avx2"], "usage: "),
        (["avx2", "no-such-program"], "COMMAND: got no-such-program, allowed: "),
    ],
)
def test_wrong_words_are_refused(words, line):
    with pytest.raises(SystemExit, match=line):
        processors.main(words)
