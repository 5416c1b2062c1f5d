"""The line with the software that results depend on."""

import numpy as np

import sampler
from tablegen.tasks.software import software


def test_names_what_decides_bits():
    line = software()
    assert "\n" not in line
    for words in (f"rebound-tables {sampler.__version__}", f"numpy {np.__version__}", "numba "):
        assert words in line


def test_changes_with_the_sources(monkeypatch, tmp_path):
    from tablegen.tasks import software as module

    def line_with(text):
        (tmp_path / "kernel.py").write_text(text)
        monkeypatch.setattr(module.sampler, "__file__", str(tmp_path / "__init__.py"))
        module._sources.cache_clear()
        return module.software()

    try:
        assert line_with("a = 1\n") == line_with("a = 1\n")
        assert line_with("a = 1\n") != line_with("a = 2\n")
    finally:
        module._sources.cache_clear()
