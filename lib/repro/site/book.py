"""`make pdf`: the chapters of a built site as one document, printed by Chromium.

Every page of a chapter is one folder below the site, so one page at that depth can
contain all articles: links to figures remain valid, and figures remain vectors.
"""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

BROWSERS = ("chromium", "chromium-browser", "google-chrome")
# The time is for formulas, which MathJax sets in the browser.
OPTIONS = (
    "--headless",
    "--no-sandbox",
    "--no-pdf-header-footer",
    "--generate-pdf-document-outline",
    "--virtual-time-budget=600000",
)
ARTICLE = re.compile(r"<article.*?</article>", re.DOTALL)
# Only pages with formulas have the scripts for them.
MATHS = re.compile(r"<script(?:>window.MathJax| [^>]*/tex-).*?</script>")
STYLE = """<style>
@page { size: A4; margin: 18mm 16mm; }
body { font-size: 10pt; } article { break-before: page; }
h1, h2, h3 { break-after: avoid; } figure, tr, pre { break-inside: avoid; }
.headerlink, button { display: none; } mjx-container g { stroke: none; }
</style>"""


def book(site: Path) -> str:
    """Return one HTML page: contents, then the articles of all chapters and
    appendices."""
    chapters = [*sorted(site.glob("ch[0-9]*")), *sorted(site.glob("appendix_*"))]
    contents, articles, maths = [], [], {}
    for chapter in chapters:
        index = ARTICLE.search((chapter / "index.html").read_text("utf-8"))[0]
        names = dict.fromkeys(re.findall(r'href="([\w.-]+\.html)"', index))
        for name in ("index.html", *names):
            page = (chapter / name).read_text("utf-8")
            maths |= dict.fromkeys(MATHS.findall(page))
            article = ARTICLE.search(page)[0]
            title = re.search(r"<h1>(.*?)<a ", article)[1]
            if name == "index.html":
                title = f"<b>{title}</b>"
                article = article.replace("<details", "<details open")
            place = f"{chapter.name}-{name.removesuffix('.html')}"
            contents.append(f'<li><a href="#{place}">{title}</a></li>')
            articles.append(article.replace("<article", f'<article id="{place}"', 1))
    head = re.search(r"<head>.*?</head>", page, re.DOTALL)[0] + STYLE
    body = f"<body><h1>Raxel</h1><ul>{''.join(contents)}</ul>{''.join(articles)}</body>"
    return f"<!doctype html><html>{head}{''.join(maths)}{body}</html>"


def main(site: Path, out: Path) -> str:
    """Print the book of ``site`` to ``out``; return what is missing, or nothing."""
    browser = next(filter(None, map(shutil.which, BROWSERS)), None)
    if not (site / "index.html").is_file():
        return f"no {site} yet: make report (or quick)"
    if not browser:
        return f"no browser to print with: install Chromium ({' or '.join(BROWSERS)})"
    with TemporaryDirectory(dir=site) as folder:
        page = Path(folder) / "book.html"
        page.write_text(book(site), "utf-8")
        files = f"--user-data-dir={folder}/user", f"--print-to-pdf={out.resolve()}"
        order = [browser, *OPTIONS, *files, page]
        done = subprocess.run(order, check=False, capture_output=True, text=True)
    return "" if done.returncode == 0 else done.stderr[-500:]


if __name__ == "__main__":
    sys.exit(main(*map(Path, sys.argv[1:])) or 0)
