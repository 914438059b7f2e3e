"""Settings of Sphinx for the site of the docs."""

import sys
from importlib import metadata
from pathlib import Path

from pygments.lexers.special import TextLexer
from sphinx.application import Sphinx

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE.parents[1]), str(HERE.parent / "support")]  # for `tests.site` and `doc_pages`

project = "fieldrig"
release = metadata.version("fieldrig")
html_title = f"fieldrig {release}"
author = "the authors of fieldrig"
extensions = ["myst_parser"]
root_doc = "index"
nitpicky = True

myst_heading_anchors = 4
myst_heading_slug_func = "doc_pages.anchor"
"""Anchors are those of GitHub, which the tests of the pages check as well."""

html_theme = "furo"
html_static_path = [str(HERE / "static")]
html_favicon = str(HERE.parents[1] / "page/fieldrig_page/static/icon.svg")
html_css_files = ["site.css"]
html_js_files = ["site.js"]
html_copy_source = False
html_use_index = False
html_show_sphinx = False
html_show_copyright = False


def setup(app: Sphinx) -> None:
    """Name lexers for the languages of the pages that Pygments doesn't know."""
    from tests.site.structured_text import StructuredText

    for name in ("iecst", "st"):
        app.add_lexer(name, StructuredText)
    app.add_lexer("pam", TextLexer)
