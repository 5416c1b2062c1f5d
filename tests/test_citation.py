"""The citation file has what CFF 1.2.0 asks for, and says of the package what the package says."""

import re
import tomllib
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).resolve().parents[1]

#: Fields that the schema of CFF 1.2.0 demands of a file, and of a reference.
REQUIRED = {"cff-version", "message", "title", "authors"}
REQUIRED_OF_A_REFERENCE = {"type", "title", "authors"}


@pytest.fixture(scope="module")
def citation():
    return yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))


def test_has_the_fields_that_the_schema_demands(citation):
    assert citation.keys() >= REQUIRED
    assert citation["cff-version"] == "1.2.0"
    assert all(isinstance(citation[name], str) and citation[name] for name in ("message", "title"))
    for reference in citation["references"]:
        assert reference.keys() >= REQUIRED_OF_A_REFERENCE


def test_everybody_has_a_name(citation):
    people = citation["authors"] + [p for r in citation["references"] for p in r["authors"]]
    for person in people:
        assert set(person) in ({"name"}, {"family-names", "given-names"})


def test_agrees_with_the_package(citation):
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert citation["title"] == project["name"]
    assert citation["version"] == project["version"]
    assert citation["license"] == project["license"]
    assert citation["keywords"] == project["keywords"]
    assert [a["name"] for a in citation["authors"]] == [a["name"] for a in project["authors"]]


def test_cites_the_paper_of_the_model(citation):
    (paper,) = citation["references"]
    assert paper["type"] == "article"
    assert [author["family-names"] for author in paper["authors"]] == ["Panfilov", "Tsirkunov"]
    assert (paper["journal"], paper["year"]) == ("Technical Physics", 2022)
    assert re.fullmatch(r"10\.\d{4,9}/\S+", paper["doi"])
    # the issue stands in the DOI of this journal
    assert f".{paper['year']}.{int(paper['issue']):02d}." in paper["doi"]
