"""The page on the format lists what reader and writer follow."""

import format_page
import pytest
from format_page import PAGE, filled_page

from sampler.errors import InputError
from sampler.files import data_directory

COMMAND = "python tools/format_page.py"


@pytest.fixture
def page():
    return (data_directory() / PAGE).read_text(encoding="utf-8")


def test_is_up_to_date(page):
    assert filled_page(page) == page, f"{PAGE} is out of date: {COMMAND}"


@pytest.mark.parametrize("line", ["<!-- begin datasets -->\n", "<!-- end binary -->\n"])
def test_lost_and_doubled_markers_are_refused(page, line):
    name = line.split()[2]
    for broken in (page.replace(line, ""), page.replace(line, 2 * line)):
        with pytest.raises(
            InputError, match=f"{PAGE}: part '{name}' is not marked exactly once; write <!--"
        ):
            filled_page(broken)


def test_command_writes_the_page(page, tmp_path, monkeypatch):
    monkeypatch.setattr(format_page, "data_directory", lambda: tmp_path)
    (tmp_path / PAGE).write_text(page.replace("float32", "float16"), encoding="utf-8")
    format_page.main()
    assert (tmp_path / PAGE).read_text(encoding="utf-8") == page
    assert [path.name for path in tmp_path.iterdir()] == [PAGE]
