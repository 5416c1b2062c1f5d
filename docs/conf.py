"""Documentation site: the pages of this repository, where they are.

pip install ".[docs]" && sphinx-build -W -c docs . site
"""

import click
from sphinx.application import Sphinx

from sampler.version import __version__

project = "rebound-tables"
release = version = __version__
html_title = f"{project} {release}"
root_doc = "docs/index"
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx_click"]
include_patterns = ["*.md", "docs/*.md", "sampler/**.md", "tablegen/**.md", "tables/*.md"]
myst_heading_anchors = 4
autodoc_member_order = "bysource"
autodoc_default_options = {"exclude-members": "model_config, model_post_init"}
# docstrings give the types; numpy's, written out, take ten lines a function
autodoc_typehints = "none"
default_role = "py:obj"
# fields of a record stand in its docstring or at the field
napoleon_use_ivar = True
# several records have a field of the same name
suppress_warnings = ["ref.python"]
html_theme = "furo"
html_copy_source = html_show_copyright = html_use_index = html_domain_indices = False
html_static_path = html_css_files = ["site.css"]


def _examples_as_code(app: Sphinx, context: click.Context, lines: list[str]) -> None:
    """Show the examples at the end of a command's help as a block of code."""
    first = next((i for i, line in enumerate(lines) if "Examples:" in line), None)
    if first is None:
        return
    for i, line in enumerate(lines):
        # sphinx-click begins each line of a text that keeps its line breaks so
        lines[i] = line.removeprefix("| ").rstrip()
    end = next((i for i, line in enumerate(lines) if i > first and not line), len(lines))
    # commands that both programs have leave the name of the program open
    program = context.command_path.split()[0]
    code = [f"   {line.strip().replace('PROGRAM', program)}" for line in lines[first + 1 : end]]
    lines[first:end] = ["Examples:", "", ".. code-block:: console", "", *code, ""]


def setup(app: Sphinx) -> None:
    """Connect the handler above."""
    app.connect("sphinx-click-process-epilog", _examples_as_code)
