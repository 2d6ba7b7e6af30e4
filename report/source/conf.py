"""Sphinx settings of the report. `make report` builds it; nothing here runs a page."""

import json
import re
from importlib import metadata
from importlib.util import find_spec
from pathlib import Path

from docutils import nodes

HERE = Path(__file__).parent
SITE = json.loads((HERE / "site.json").read_text("utf-8"))

project = "Raxel"
author = "the Raxel authors"
project_copyright = "the Raxel authors"
language = "en"

extensions = ["myst_nb", "sphinx_design", "sphinxcontrib.bibtex"]
extensions += ["repro.site.codes", "repro.site.each_page"]
extensions += ["repro.site.library"]
exclude_patterns = ["_extra", "_templates", "_static"]
templates_path = ["_templates"]
nitpicky = True

# Pages arrive executed: a changed page file must never hide behind a stale cache.
nb_execution_mode = "off"
nb_render_markdown_format = "myst"
# A cell offers MyST for this site and HTML for a notebook.
nb_mime_priority_overrides = [("html", "text/markdown", 0)]

myst_enable_extensions = [
    "amsmath",
    "attrs_inline",
    "colon_fence",
    "deflist",
    "dollarmath",
    "html_image",
]
myst_heading_anchors = 3
myst_dmath_double_inline = True

bibtex_bibfiles = ["references.bib"]
bibtex_default_style = "unsrt"
bibtex_reference_style = "author_year"

# One file of MathJax, with glyphs as drawn paths. The package's own extension copies
# all 24 MB and takes the variant with web fonts, which Firefox blocks on file://.
mathjax = Path(find_spec("sphinx-mathjax-offline").submodule_search_locations[0])
mathjax_path = "tex-svg-full.js"
# The menu would offer to fetch speech rules from a host.
mathjax3_config = {"options": {"enableMenu": False}}

# Quotation marks become round, but -- is part of an option's name, never a dash.
smartquotes_action = "qe"

html_search_scorer = str(HERE / "search.js")

html_theme = "furo"
html_title = "Raxel"
html_static_path = ["_static", str(mathjax / "static" / "mathjax" / mathjax_path)]
html_js_files = [("scenes.js", {"defer": "defer"})]
html_css_files = [
    "report.css",
    "artefacts.css",
    "scoreboard.css",
    "scoreboard_narrow.css",
]
html_extra_path = ["_extra"]
html_copy_source = False
html_show_sourcelink = False
html_permalinks_icon = "#"
html_use_index = False
html_domain_indices = False
html_context = {"raxel": SITE}
html_theme_options = {
    "announcement": (
        "Quick build: few trials, no verdicts. Sentences describe the full build."
        if SITE["effort"] == "quick"
        else ""
    ),
    "light_css_variables": {
        "color-brand-primary": "#00527f",
        "color-brand-content": "#00629b",
        "color-brand-visited": "#5b3d8a",
    },
    "dark_css_variables": {
        "color-brand-primary": "#7cc7f2",
        "color-brand-content": "#7cc7f2",
        "color-brand-visited": "#c3a6f0",
    },
}


def keep_tag_outside(app, doctree):
    """Let an equation have both several lines (or a matrix) and a thesis number.

    Sphinx wraps what has a line break in `split`, where MathJax allows no \\tag.
    """
    for block in doctree.findall(nodes.math_block):
        text = block.astext()
        tag = re.search(r"\\tag\{[^{}]*\}", text)
        if tag and r"\\" in text and not text.lstrip().startswith(r"\begin{equation"):
            lines = text.replace(tag[0], "").strip()
            whole = rf"\begin{{split}}{lines}\end{{split}}{tag[0]}"
            block[:] = [nodes.Text(rf"\begin{{equation}}{whole}\end{{equation}}")]
            block["no-wrap"] = True


def setup(app):
    """Connect the handler; read every page anew when this file or a tool changed."""
    tools = [f"{t} {metadata.version(t)}" for t in ("sphinx", "myst-nb", "furo")]
    key = [*tools, Path(__file__).read_text("utf-8")]
    app.add_config_value("raxel_key", "\n".join(key), "env")
    app.connect("doctree-read", keep_tag_outside)
