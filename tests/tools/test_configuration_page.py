"""The reference of the configuration lists each field of the records, and is up to date."""

import configuration_page
import pytest
from configuration_page import MEANINGS, PAGE, TABLES, filled_page

from sampler.files import data_directory
from tablegen.config.config import Config

COMMAND = "python tools/configuration_page.py"


@pytest.fixture
def page():
    return (data_directory() / PAGE).read_text(encoding="utf-8")


def test_is_up_to_date(page):
    assert filled_page(page) == page, f"{PAGE} is out of date: {COMMAND}"


def test_each_record_has_a_table():
    records = {"Config", *Config.model_json_schema()["$defs"]}
    assert {name for names in TABLES.values() for name in names} == records


def test_a_field_without_a_meaning_is_noticed(page, monkeypatch):
    monkeypatch.setitem(MEANINGS, "TableSettings", {"seed": ("", "seed of the random numbers")})
    with pytest.raises(KeyError, match="samples_per_node"):
        filled_page(page)


def test_a_meaning_without_a_field_is_noticed(page, monkeypatch):
    monkeypatch.setitem(MEANINGS, "ModelSettings", MEANINGS["ModelSettings"] | {"lost": ("", "")})
    with pytest.raises(ValueError, match="ModelSettings has no field lost"):
        filled_page(page)


def test_the_command_writes_the_page(page, tmp_path, monkeypatch):
    monkeypatch.setattr(configuration_page, "data_directory", lambda: tmp_path)
    (tmp_path / PAGE).write_text(page.replace("0.045", "0.054"), encoding="utf-8")
    configuration_page.main()
    assert (tmp_path / PAGE).read_text(encoding="utf-8") == page
