"""Public names are those of the stubs, and each can be imported."""

import ast
import importlib

import pytest
from documents import ROOT

every_package = pytest.mark.parametrize("name", ["sampler", "tablegen"])


@every_package
def test_names_of_the_stub_are_found_where_it_says(name):
    package = importlib.import_module(name)
    stub = ast.parse((ROOT / name / "__init__.pyi").read_text(encoding="utf-8"))
    stubbed = {alias.name: node.module for node in stub.body for alias in node.names}
    assert sorted(stubbed) == sorted(package.__all__)
    for public, module in stubbed.items():
        value = getattr(importlib.import_module(f"{name}.{module}"), public)
        assert getattr(package, public) is value
