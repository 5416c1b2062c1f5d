"""C header and Fortran module hold the constants of the one description."""

import pytest

from sampler.errors import CODES, Code, InputError
from sampler.files import include_directory
from sampler.formats import generated_code
from sampler.formats.generated_code import PARTS, generated

COMMAND = "python -m sampler.formats.generated_code"


def text_of(name):
    return (include_directory() / name).read_text(encoding="utf-8")


@pytest.mark.parametrize("name", PARTS)
def test_is_up_to_date(name):
    assert generated(name, text_of(name)) == text_of(name), f"{name} is out of date: {COMMAND}"


@pytest.mark.parametrize("name", PARTS)
def test_a_new_code_would_be_missed(name, monkeypatch):
    monkeypatch.setattr(generated_code, "CODES", (*CODES, Code("ERR_NEW", -99, "new")))
    assert "RBT_ERR_NEW" in generated(name, text_of(name))


@pytest.mark.parametrize("name", PARTS)
def test_a_lost_mark_is_refused(name):
    broken = text_of(name).replace("end constants", "")
    with pytest.raises(InputError, match="part 'constants' is not marked, allowed: "):
        generated(name, broken)


def test_command_writes_the_files(tmp_path, monkeypatch):
    (tmp_path / "c").mkdir()
    (tmp_path / "fortran").mkdir()
    current = {name: text_of(name) for name in PARTS}
    monkeypatch.setattr(generated_code, "include_directory", lambda: tmp_path / "c")
    for name, text in current.items():
        (tmp_path / "c" / name).write_text(text.replace("-28", "-29"), encoding="utf-8")
    generated_code.main()
    assert {name: (tmp_path / "c" / name).read_text() for name in PARTS} == current
