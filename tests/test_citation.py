"""The citation file has what CFF 1.2.0 asks for, and says of the package what the package says."""

import tomllib

import pytest
import yaml
from documents import ROOT

CITATION = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]


def test_has_the_fields_that_the_schema_demands():
    assert CITATION["cff-version"] == "1.2.0"
    assert CITATION["message"]
    for work in (CITATION, *CITATION["references"]):
        assert work["title"]
        for person in work["authors"]:
            assert set(person) in ({"name"}, {"family-names", "given-names"})


@pytest.mark.parametrize("field", ["version", "license", "keywords"])
def test_agrees_with_the_package(field):
    assert CITATION[field] == PROJECT[field]
    assert CITATION["title"] == PROJECT["name"]
    assert [a["name"] for a in CITATION["authors"]] == [a["name"] for a in PROJECT["authors"]]


def test_cites_the_paper_of_the_model():
    (paper,) = CITATION["references"]
    assert (paper["type"], paper["journal"]) == ("article", "Technical Physics")
    assert paper["year"] == 2022
    assert [author["family-names"] for author in paper["authors"]] == ["Panfilov", "Tsirkunov"]
    # the issue stands in the DOI of this journal
    assert f".{paper['year']}.{int(paper['issue']):02d}." in paper["doi"]
