"""`make pdf`: the chapters as one page, and one line where something is missing."""

import re

from repro.site import book

MATHS = (
    "<script>window.MathJax = {}</script><script src='../_static/tex-a.js'></script>"
)
PAGE = """<html><head><style>b</style>
</head><body><article><h1>{0}<a href="#">#</a></h1>{1}</article></body></html>"""
PAGES = {
    "index.html": ("Start", ""),
    "ch02_b/index.html": ("Two", '<a href="s2.html">2.2</a> <a href="s1.html">2.1</a>'),
    "ch02_b/s1.html": ("2.1", f'<img src="../figures/a.svg">{MATHS}'),
    "ch02_b/s2.html": ("2.2", ""),
    "ch01_a/index.html": ("One", '<a href="../scoreboard.html">all rows</a>'),
    "guides/index.html": ("Guides", ""),
    "appendix_a/index.html": ("Appendix", ""),
}


def built(site):
    for name, (title, text) in PAGES.items():
        (site / name).parent.mkdir(exist_ok=True)
        (site / name).write_text(PAGE.format(title, text))


def test_book_has_chapter_pages_in_order(tmp_path):
    built(tmp_path)
    text = book.book(tmp_path)
    titles = re.findall(r"<h1>(\w[\w.]*)<a", text)
    assert titles == ["One", "Two", "2.2", "2.1", "Appendix"]
    targets = re.findall(r'<li><a href="#([^"]+)">', text)
    assert targets == re.findall(r'<article id="([^"]+)"', text)
    assert '<img src="../figures/a.svg">' in text
    assert "<style>b</style>" in text
    assert MATHS in text.partition("<body>")[0]


def test_missing_site_or_browser_is_one_line(tmp_path, monkeypatch):
    out = tmp_path / "book.pdf"
    assert book.main(tmp_path, out).endswith("make report (or quick)")
    built(tmp_path)
    monkeypatch.setenv("PATH", "")
    assert "install Chromium" in book.main(tmp_path, out)
    assert not out.exists()
