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


def _indented_lines_as_code(app: Sphinx, context: click.Context, lines: list[str]) -> None:
    """Show the indented lines at the end of a command's help as blocks of code."""
    # commands that both programs have leave the name of the program open
    program = context.command_path.split()[0]
    shown: list[str] = []
    in_code = False
    for line in lines:
        # sphinx-click begins each line of a text that keeps its line breaks with a bar
        text = line.removeprefix("| ").rstrip().replace("PROGRAM", program)
        if text.startswith("  ") != in_code:
            in_code = not in_code
            shown += ["", ".. code-block:: text", ""] if in_code else [""]
        shown.append(f"   {text}" if in_code else text)
    lines[:] = [*shown, ""]


def setup(app: Sphinx) -> None:
    """Connect the handler above."""
    app.connect("sphinx-click-process-epilog", _indented_lines_as_code)
