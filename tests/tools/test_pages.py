"""The references of the format and of the configuration are those of the code."""

import configuration_page
import format_page
import pytest

from sampler.errors import InputError
from sampler.files import data_directory
from tablegen.config.config import Config

#: Programs that write a page, each with something on its page.
PROGRAMS = {format_page: "float32", configuration_page: "0.045"}


def page_of(program):
    return (data_directory() / program.PAGE).read_text(encoding="utf-8")


@pytest.fixture(params=PROGRAMS, ids=lambda program: program.__name__)
def program(request):
    return request.param


def test_is_up_to_date(program):
    page, command = page_of(program), f"python tools/{program.__name__}.py"
    assert program.filled_page(page) == page, f"{program.PAGE} is out of date: {command}"


def test_command_writes_the_page(program, tmp_path, monkeypatch):
    page, written = page_of(program), tmp_path / program.PAGE
    monkeypatch.setattr(program, "data_directory", lambda: tmp_path)
    changed = page.replace(PROGRAMS[program], "float16")
    assert changed != page
    written.write_text(changed, encoding="utf-8")
    program.main()
    assert written.read_text(encoding="utf-8") == page
    assert list(tmp_path.iterdir()) == [written]


@pytest.mark.parametrize("line", ["<!-- begin datasets -->\n", "<!-- end binary -->\n"])
def test_lost_and_doubled_markers_are_refused(line):
    page, name = page_of(format_page), line.split()[2]
    for broken in (page.replace(line, ""), page.replace(line, 2 * line)):
        message = f"{format_page.PAGE}: part '{name}' is not marked exactly once; write <!--"
        with pytest.raises(InputError, match=message):
            format_page.filled_page(broken)


def test_each_record_has_a_table():
    records = {"Config", *Config.model_json_schema()["$defs"]}
    tables = configuration_page.TABLES.values()
    assert {name for names in tables for name in names} == records


def test_a_field_without_a_meaning_is_noticed(monkeypatch):
    seed = {"seed": ("", "seed of the random numbers")}
    monkeypatch.setitem(configuration_page.MEANINGS, "TableSettings", seed)
    with pytest.raises(KeyError, match="samples_per_node"):
        configuration_page.filled_page(page_of(configuration_page))


def test_a_meaning_without_a_field_is_noticed(monkeypatch):
    meanings = configuration_page.MEANINGS
    monkeypatch.setitem(meanings, "ModelSettings", meanings["ModelSettings"] | {"lost": ("", "")})
    with pytest.raises(ValueError, match="ModelSettings has no field lost"):
        configuration_page.filled_page(page_of(configuration_page))
