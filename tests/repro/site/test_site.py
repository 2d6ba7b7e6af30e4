"""From notebooks to the site: rendering only what changed, and nothing stale."""

import json
import re
from html.parser import HTMLParser
from pathlib import Path

import pytest

from repro.page.notebook import PageError
from repro.site import assemble
from repro.site.check import check_site
from repro.site.sphinx import build_site, without_source
from tests.sample_files import write
from tests.small_checkouts import (
    INPUT_HASH,
    ODD,
    PAGE,
    ROOT,
    SWEEP,
    odd_page,
    run,
    small_checkout,
    write_page,
)

PAGE_CODE = "ch02_sample/s5_page/page.py.html"
ORIGIN = {
    "code": f'<a href="../source/{SWEEP}">',
    "seed": "<dt>Seed</dt><dd>2009",
    "inputs": f"small.yaml <code>{INPUT_HASH}</code>",
    "versions": "Python 3.11.0, numpy 2.0",
    "trials": "2 of each of 1 condition<",
}


class Elements(HTMLParser):
    """Elements and text of a page: what a browser makes of it."""

    def __init__(self, text):
        super().__init__()
        self.found, self.alts, self.text = [], [], ""
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.found.append((tag, dict(attrs)))
        self.alts += [value for name, value in attrs if name == "alt"]

    def handle_data(self, data):
        self.text += data


def check_nothing_got_in(site):
    """Every odd name stands on its page as it is, and is nothing but text anywhere."""
    shown = Elements((site / "ch02_sample" / "s6_odd.html").read_text("utf-8"))
    text, alts = (" ".join(t.split()) for t in (shown.text, "\n".join(shown.alts)))
    for name in (" ".join(name.split()) for name in ODD):
        # Title, both paragraphs, caption, cell, a figure of its own; curled quotes.
        curled = name.replace('"', "\u201d").replace("'", "\u2019")
        assert max(text.count(name), text.count(curled)) >= 5, name
        assert name in alts
    for path in site.rglob("*.html"):
        for _, attrs in Elements(path.read_text("utf-8")).found:
            assert not [name for name in attrs if name.startswith("on")], path
            address = f"{attrs.get('href')} {attrs.get('src')}".lower()
            assert "javascript:" not in address, path
    # The index of the search is data; the script that shows its titles escapes them.
    script = (site / "_static" / "searchtools.js").read_text("utf-8")
    assert "linkEl.innerHTML = _escapeHTML(title)" in script
    book = json.loads((site / "notebooks/ch02_sample/s6_odd.ipynb").read_text("utf-8"))
    outputs = [o for cell in book["cells"] for o in cell.get("outputs", ())]
    pages = ["".join(o["data"].get("text/html", "")) for o in outputs]
    tags = {tag for page in pages for tag, _ in Elements(page).found}
    assert tags <= {"figure", "img", "figcaption", "table", "caption", "tr", "th", "td"}


def linked(path, begin="<body", end="</body>"):
    """Files that links of a page lead to, between the first two such texts."""
    part = path.read_text("utf-8").partition(begin)[2].partition(end)[0]
    found = re.findall(r'href="([^"#:]+)', part)
    return [(path.parent / name).resolve() for name in found]


def check_origin_is_two_clicks_away(site):
    """From a figure, and from the numbers of the text, by way of their list."""
    page = site / "ch02_sample" / "s5_page.html"
    from_figure = linked(page, '<p class="raxel-made', "</p>")
    (quoted,) = (p for p in linked(page) if p.parent.parent.name == "provenance")
    rows = quoted.read_text("utf-8").split("<tr>")[2:]
    numbers = [re.search(r"<td>(.*?)</td>", row)[1] for row in rows]
    assert numbers == ["0.1134 px (0.1110 to 0.1162)", "0.75"]
    for row, code in zip(rows, (SWEEP, PAGE_CODE), strict=True):
        assert f'href="../../source/{code}">' in row
        assert 'href="../../provenance/sweep.html">sweep<' in row
    origin = site.resolve() / "provenance" / "sweep.html"
    assert origin in from_figure
    assert origin in linked(quoted)
    text = origin.read_text("utf-8")
    assert {name for name, part in ORIGIN.items() if part not in text} == set()
    assert "some-machine" not in text


def test_only_changed_pages_are_rendered(tmp_path, monkeypatch):
    base = small_checkout(tmp_path)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PYTHONPATH", str(ROOT / "lib"))
    book = Path("report/build/quick/pages/ch02_sample/s5_page.ipynb")
    source, site = Path("report/build/quick/source"), Path("report/site-quick")

    def build():
        boards = (base / "scoreboard.md", base / "scoreboard.json")
        assemble.assemble(tmp_path, "quick", [book, odd], *boards, source)
        return build_site(source, site)

    run(write_page(tmp_path, PAGE).relative_to(tmp_path), book)
    odd = book.with_stem("s6_odd")
    run(odd_page(tmp_path, base).relative_to(tmp_path), odd)
    build()
    check_nothing_got_in(site)
    check_origin_is_two_clicks_away(site)
    assert check_site(site) == []
    text = (site / "ch02_sample" / "s5_page.html").read_text("utf-8")
    assert re.search(r'<img[^>]*class="[^"]*raxel-lines', text)
    assert "command line" not in text
    assert "data-raxel-about" not in text
    for part in (
        "The value is 0.1134 px (0.1110 to 0.1162); half of it is 0.75 px.",
        "<strong>Fig. 2.3.</strong> Residual against noise",
        'alt="Fig. 2.3 Residual against noise sigma."',
        'id="fig_2_3"',
        'id="table_2_1"',
        "1.235",
        "<code>make fig_2_3 EFFORT=quick</code>",
        'href="../errata.html#E-2.10">E-2.10</a>',
        'href="../scoreboard.html#fig_2_3">comparison</a>',
        "The library computes the same.",
        r"\end{split}\tag{2.11}\end{equation}",
        'data-src="../figures/fig_2_3.html"',
        "section 2.5.1 (Experiments with Synthetic Data, from p. 43)",
        "<b>(b)</b>: x: field of view (deg), 30..150; y: distortion",
        "@phdthesis{dunne2009,",
        'href="../source/ch02_sample/s5_page/page.py.html#half_of"',
    ):
        assert part in text
    reference = (site / "api" / "errors.html").read_text("utf-8")
    assert 'id="raxel.errors.InputError"' in reference
    assert 'href="../source/raxel/errors.py.html#InputError"' in reference
    index = (site / "index.html").read_text("utf-8")
    assert "<strong>3</strong> rows" in index
    assert "<strong>1</strong> differs" in index
    for name in (
        "scoreboard.json",
        "figures/fig_2_3.svg",
        "figures/fig_2_3.png",
        "figures/fig_2_3.csv",
        "figures/fig_2_3.html",
        "figures/table_2_1.csv",
        "source/ch02_sample/s5_page/page.py.html",
        "source/raxel/rays/lines.py.html",
        "api/index.html",
        "results/sweep.json",
        "notebooks/ch02_sample/s5_page.ipynb",
        "source/ch02_sample/s5_page/page.py",
    ):
        assert (site / name).is_file(), name

    sentence = book.read_text("utf-8").replace("The value is", "The number is")
    book.write_text(sentence, "utf-8")
    before = pages_of(site)
    build()
    after = pages_of(site)
    # The pages before and after it link to it with its first sentence.
    names = ("index", "s5_page", "s6_odd")
    assert {name for name in after if after[name] != before[name]} == {
        f"ch02_sample/{name}.html" for name in names
    }


def pages_of(site):
    """Every HTML page by name, without the stamps that Sphinx puts on style sheets."""
    texts = {
        path.relative_to(site).as_posix(): path.read_text("utf-8")
        for path in site.rglob("*.html")
    }
    return {name: re.sub(r"\?v=\w+", "", text) for name, text in texts.items()}


def test_warning_fails_site_repeatedly(tmp_path):
    source, site = tmp_path / "build" / "source", tmp_path / "site"
    source.mkdir(parents=True)
    (source / "conf.py").write_text('project = "x"\nhtml_theme = "basic"\n')
    (source / "index.rst").write_text("Title\n=====\n\nSee :doc:`nowhere`.\n")
    for _attempt in range(2):
        with pytest.raises(PageError, match=r"^site: index\.rst:4: WARNING"):
            build_site(source, site)
    assert not site.exists()


def test_killed_run_leaves_no_page_done(tmp_path, monkeypatch):
    state = tmp_path / "doctrees" / "environment.pickle"
    state.parent.mkdir()
    state.touch()
    there = []

    def killed(*_, **__):
        there.append(state.exists())
        raise SystemExit(143)

    monkeypatch.setattr("subprocess.run", killed)
    for _ in range(2):
        with pytest.raises(SystemExit):
            build_site(tmp_path / "source", tmp_path / "site")
    assert there == [True, False]


def test_files_without_source_are_removed(tmp_path):
    source, built = tmp_path / "source", tmp_path / "html"
    kept = {
        "source": ("index.md", "ch02/one.ipynb", "_extra/sets/a/b.html"),
        "html": ("index.html", "ch02/one.html", "search.html", "sets/a/b.html"),
    }
    gone = ("ch02/two.html", "sets/c/b.html", "_images/a.svg")
    for folder, names in (("source", kept["source"]), ("html", kept["html"] + gone)):
        for name in names:
            write(tmp_path / folder / name, "x")
    assert sorted(without_source(source, built)) == sorted(gone)


def test_dimmed_images_are_not_inverted():
    styles = (ROOT / "report" / "source" / "_static" / "report.css").read_text("utf-8")
    dimmed = re.findall(r"([^{}]+)\{\s*filter: brightness", styles)
    turned = re.findall(r"([^{}]+)\{\s*filter: invert", styles)
    assert len(dimmed) == len(turned) == 2
    for selector in ",".join(dimmed).split(","):
        assert selector.strip().endswith(":not(.raxel-lines)"), selector
    assert all(".raxel-lines" in selector for selector in turned)
