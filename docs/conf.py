"""Settings of the site that `make docs` builds with Sphinx from docs/ and reports/.

Sphinx reads from the root of the repository, so that links between pages are those that work in a
listing of the files, too.
"""

import sys
from pathlib import Path

DOCS = Path(__file__).parent
sys.path.insert(0, str(DOCS))

import refdem  # noqa: E402

project = "refdem"
author = "The refdem developers"
version = refdem.__version__
release = version
root_doc = "docs/index"

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.viewcode",
    "extension.pages",
    "extension.formulas",
    "extension.reference",
    "extension.accessible",
]
include_patterns = [
    "docs/*.md",
    "docs/**/*.md",
    "docs/**/*.ipynb",
    "reports/manual/*.md",
    "reports/gallery/gallery.md",
    "reports/bench.md",
    "reports/field/index.md",
    "reports/findings.md",
    "reports/mutants.md",
    "reports/resolution.md",
    "reports/stress.md",
    "CONTRIBUTING.md",
    "CHANGELOG.md",
    "SECURITY.md",
    "CODE_OF_CONDUCT.md",
]
# Folders that are not walked through.
exclude_patterns = [".*", "build", "paper", "dist", "refdem", "tests", "validation", "reports/site"]
source_suffix = {".md": "markdown", ".ipynb": "notebook"}

myst_enable_extensions = ["colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 4
# Tables and figures of generated pages begin at the level that suits them.
suppress_warnings = ["myst.header"]

html_theme = "furo"
html_title = "refdem"
html_show_sourcelink = False
html_copy_source = False
html_show_sphinx = False
html_show_copyright = False
# Two hyphens are an option.
smartquotes = False
templates_path = ["templates"]
html_additional_pages = {"index": "to_docs.html"}
# What the search shows beside a page would be fetched, which a browser refuses to a page from disk:
# static/excerpts.js takes it from a script instead.
html_show_search_summary = False
html_static_path = ["static"]
html_css_files = ["site.css"]
# Every word of code has a contrast of at least 4.5 with what is behind it.
pygments_style = "a11y-high-contrast-light"
pygments_dark_style = "a11y-high-contrast-dark"

# Single backticks of docstrings are code.
default_role = "code"
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_typehints_format = "short"
python_use_unqualified_type_names = True
# Names in annotations: those of other packages, and those of refdem that have no page of their own.
nitpick_ignore_regex = [("py:.*", ".*")]
