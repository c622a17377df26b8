# SPDX-License-Identifier: GPL-2.0-or-later
"""Sphinx settings of the manual. `scripts/docs` builds it; the pages are read on a Git host as well.

The source folder is the root of the project, so that links from one page to another are the same on both.
"""

import csv
import importlib.util
import inspect
import os
import sys
from pathlib import Path

from sphinx.util.docutils import SphinxDirective

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "doc"))

import docstrings  # noqa: E402
import verificationPictures  # noqa: E402
import yade_mpm  # noqa: E402
from yade_mpm.scene import tables  # noqa: E402

project = "yade-mpm"
author = copyright = "The yade-mpm developers"
version = release = yade_mpm.__version__
root_doc = "doc/index"
include_patterns = ["doc/**", "CHANGELOG.md", "CONTRIBUTING.md", "README.md", "SECURITY.md"]
exclude_patterns = ["build", "results", "dist", "tests", "pkg", "py", "scripts", "**/__pycache__"]

extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx.ext.mathjax"]
suppress_warnings = ["config.cache"]

# Formulas: the site has MathJax in one file and needs no network.
mathjaxFolder = importlib.util.find_spec("sphinx-mathjax-offline").submodule_search_locations[0]
mathjax_path = "tex-svg.js"

# Pages
myst_enable_extensions = ["dollarmath", "deflist", "attrs_inline"]
myst_heading_anchors = 4  # links to headings, by the names that a Git host gives them
myst_links_external_new_tab = False

# Notebooks: the pages with {code-cell} in them. `scripts/docs` executes them, the default test does not.
os.environ.pop("MPLBACKEND", None)  # kernels draw into the page
nb_execution_mode = os.environ.get("MPM_NOTEBOOKS", "cache")
nb_execution_cache_path = str(ROOT / "build" / "docs" / "cache")
nb_execution_in_temp = True
nb_execution_raise_on_error = True
nb_execution_timeout = 300  # s for one cell
nb_merge_streams = True

# Reference, from the docstrings
autodoc_member_order = "bysource"
autodoc_typehints = "none"
autodoc_default_options = {"members": True, "exclude-members": ", ".join(docstrings.HIDDEN)}
napoleon_google_docstring = False
napoleon_use_ivar = True
napoleon_use_rtype = False
default_role = "py:obj"
python_maximum_signature_line_length = 80

# Looks
html_theme = "furo"
html_title = f"yade-mpm {release}"
html_show_sourcelink = False
html_copy_source = False
html_static_path = [f"{mathjaxFolder}/static/mathjax/{mathjax_path}", "site.css"]
html_css_files = ["site.css"]
html_extra_path = ["_site"]  # index.html of the whole, which leads to doc/index.html


class Public(SphinxDirective):
    """`.. public:: yade_mpm.diagnostics`: the reference of every public name of a module."""

    required_arguments = 1

    def run(self):
        lines = []
        for name, thing in docstrings.publicNames(self.arguments[0]):
            lines += [f".. auto{'class' if inspect.isclass(thing) else 'function'}:: {name}", ""]
        return self.parse_text_to_nodes("\n".join(lines))


class Verification(SphinxDirective):
    """`{verification}`: the records of the verification tests as a table, with links to their pictures."""

    def run(self):
        records = ROOT / "doc" / "explanation" / "verification.csv"
        self.env.note_dependency(str(records))
        drawn = {module.__name__ for module in verificationPictures.PICTURES}
        heads = ("What", "Reference", "Error", "Tolerance", "Order", "Runs", "Picture", "Test")
        lines = [heads, ["---"] * len(heads)]
        rows = list(csv.DictReader(records.open(newline="")))
        for row in rows:
            file = Path(row["test"].partition("::")[0]).stem
            link = f'<a href="#{file}">picture</a>' if file in drawn else ""
            stated = (row[name] for name in ("what", "reference", "error", "tolerance", "order", "runs"))
            lines.append([*stated, link, f"`{file}`"])
        table = "\n".join(f"| {' | '.join(cells)} |" for cells in lines)
        days = sorted({row["day"] for row in rows} - {""})
        return self.parse_text_to_nodes(f"{table}\n\nMeasured from {days[0]} to {days[-1]}.")


class CheckpointArrays(SphinxDirective):
    """`{checkpoint-arrays}`: what the arrays of a checkpoint must be, as `checkTables` asks for it."""

    def run(self):
        lines = ["| array | one row for each of the | numbers | content |", "|---|---|---|---|"]
        for name, table in tables.DECLARED.items():
            limits = [] if table.least is None else [f"from {table.least}"]
            if table.end is not None:
                limits += [f"below {'2^53' if table.end == tables.MOST_ID else 'the number of ' + table.end}"]
            numbers = ", ".join([*limits, *([table.rule] if table.rule else [])]) or "any"
            lines.append(f"| `{name}` | {table.rows} | {numbers} | {table.text} |")
        return self.parse_text_to_nodes("\n".join(lines))


def setup(app):
    app.add_directive("public", Public)
    app.add_directive("verification", Verification)
    app.add_directive("checkpoint-arrays", CheckpointArrays)
    app.connect("autodoc-process-docstring", docstrings.process, priority=400)  # before napoleon
