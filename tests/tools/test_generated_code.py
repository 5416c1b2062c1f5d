"""C header and Fortran module hold the constants of the one description."""

import runpy

import generated_code
import pytest
from generated_code import PARTS, generated

from sampler.errors import InputError
from sampler.files import include_directory

COMMAND = "python tools/generated_code.py"


def text_of(name):
    return (include_directory() / name).read_text(encoding="utf-8")


@pytest.mark.parametrize("name", PARTS)
def test_is_up_to_date(name):
    assert generated(name, text_of(name)) == text_of(name), f"{name} is out of date: {COMMAND}"


def test_the_header_is_put_together_from_its_sections():
    build = runpy.run_path(str(include_directory() / "build.py"))
    command = "python sampler/c/build.py"
    assert text_of("rebound_sampler.h") == build["header"](), f"it is out of date: {command}"


@pytest.mark.parametrize("name", PARTS)
def test_a_lost_mark_is_refused(name):
    part = next(iter(PARTS[name]))
    with pytest.raises(InputError, match=f"part '{part}' is not marked exactly once; write "):
        generated(name, text_of(name).replace(f"end {part}", ""))


def test_command_writes_the_files(tmp_path, monkeypatch):
    current = {name: text_of(name) for name in PARTS}
    monkeypatch.setattr(generated_code, "include_directory", lambda: tmp_path / "c")
    for name, text in current.items():
        path = (tmp_path / "c" / name).resolve()
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text.replace("-28", "-29").replace("2u", "3u"), encoding="utf-8")
    generated_code.main()
    assert {name: (tmp_path / "c" / name).read_text() for name in PARTS} == current
