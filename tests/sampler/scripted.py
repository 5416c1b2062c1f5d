"""The library once more, drawing from random words that a test gives."""

import ctypes
import sys
from pathlib import Path

import numpy as np
import pytest

from sampler.files import include_directory
from sampler.library import Conditions, OpenTable

sys.path.insert(0, str(include_directory()))
import build

_NAME = "RBTI_INLINE RBT_DEVICE void rbti_fill_words("
_ARGUMENTS = (
    "size_t m, uint32_t block, uint64_t seed, const uint64_t *index, const uint32_t *hit, "
    "size_t count, uint32_t *words)"
)
_SCRIPTED = f"""
uint32_t scripted[12];
{_NAME}{_ARGUMENTS}
{{
    (void)seed; (void)index; (void)hit; (void)count;
    for (size_t k = 0; k < 4 * m; k++)
        words[k] = scripted[4 * block + k / m];
}}
"""


def build_scripted(folder: Path) -> ctypes.CDLL:
    """Compile the header with words from the array ``scripted``; skips without a compiler."""
    if not build.compiler():
        pytest.skip("no C compiler on this machine")
    header = (include_directory() / "rebound_sampler.h").read_text(encoding="utf-8")
    begin = header.index(_NAME)
    end = header.index("\n}\n", begin) + 3
    source, library = folder / "scripted.h", folder / "scripted.so"
    source.write_text(header[:begin] + _SCRIPTED + header[end:], encoding="utf-8")
    with pytest.MonkeyPatch.context() as patch:
        # the bits are those of the library; gcc optimises nothing, as under its sanitizer, which
        # takes a twentieth of the time
        patch.setenv("CFLAGS", "-O0 -D__SANITIZE_ADDRESS__")
        build.build(library, source)
    return ctypes.CDLL(str(library))


class Scripted:
    """Draws of a table from scripted words: code and state."""

    def __init__(self, library: ctypes.CDLL, table: OpenTable) -> None:
        self._library, self._table = library, table
        self._words = (ctypes.c_uint32 * 12).in_dll(library, "scripted")

    def draw(self, alpha1, speed, words):
        """Draw from eight words of channels, which are numbers 0 to 7 and 9 of the blocks."""
        self._words[:] = [int(word) for word in words[:8]] + [0] * 4
        index, hit, state = np.zeros(1, np.uint64), np.zeros(1, np.uint32), np.empty(6)
        given = np.array([alpha1]), np.array([speed]), index, hit
        at = dict(
            zip(("alpha1", "speed", "index", "hit"), (x.ctypes.data for x in given), strict=True)
        )
        address = ctypes.c_void_p(state.ctypes.data)
        record, table = Conditions(**at), ctypes.c_void_p(self._table.handle)
        one, seed = ctypes.c_size_t(1), ctypes.c_uint64(0)
        code = self._library.rbt_sample(table, one, ctypes.byref(record), seed, address, None)
        return code, state
