"""The link checker finds each kind of fault, and passes a good site."""

import pytest

from repro.site.check import check_site

GOOD = """<!doctype html><html><head><link rel="stylesheet" href="_static/s.css?v=1">
<link rel="canonical" href="https://example.org/"></head><body><h1 id="top-title">x</h1>
<a href="sub/other.html#there">a</a> <a href="#top-title">b</a> <a href="#">c</a>
<a href="https://example.org/far">outside</a> <a href="mailto:a@b.c">m</a>
<img src="data:image/png;base64,AA==" alt="dot"> <img src="a%20b.png" alt="">
<svg><use href="#top-title"></use></svg></body></html>"""


@pytest.fixture
def site(tmp_path):
    (tmp_path / "sub").mkdir()
    (tmp_path / "_static").mkdir()
    (tmp_path / "index.html").write_text(GOOD)
    (tmp_path / "sub" / "other.html").write_text(
        '<p id="there">y</p><a href="../index.html#top-title">back</a>'
    )
    (tmp_path / "_static" / "s.css").write_text(
        "/* url(https://example.org/in-a-comment.png) */ p {background: url(d.png)}"
    )
    (tmp_path / "_static" / "d.png").write_bytes(b"")
    (tmp_path / "a b.png").write_bytes(b"")
    return tmp_path


def test_valid_site_has_no_problem(site):
    assert check_site(site) == []


@pytest.mark.parametrize(
    ("html", "complaint"),
    [
        ('<a href="gone.html">x</a>', "gone.html: no such file"),
        ('<a href="index.html#gone">x</a>', "index.html#gone: no such anchor"),
        ('<a href="sub/other.html#gone">x</a>', "other.html#gone: no such anchor"),
        ('<a href="#gone">x</a>', "#gone: no such anchor"),
        ('<a href="sub/">x</a>', "sub/: is a folder"),
        ('<a href="/index.html">x</a>', "starts at the root"),
        ('<a href="../../etc/hosts">x</a>', "leads out of the site"),
        ('<a href="file:///etc/hosts">x</a>', "unknown scheme"),
        ('<a href="javascript:alert(1)">x</a>', "code or content in an address"),
        ('<a href="data:text/html,x">x</a>', "code or content in an address"),
        ('<iframe src="javascript:x" title="y"></iframe>', "code or content"),
        ("<svg onload=alert(1)>", "svg with onload"),
        ('<img src="a%20b.png">', "image without alt text"),
        ('<img src="gone.png" alt="">', "gone.png: no such file"),
        ('<img srcset="gone.png 2x" src="a%20b.png" alt="">', "gone.png: no such file"),
        ('<script src="https://example.org/x.js"></script>', "from a host"),
        ('<script src="//example.org/x.js"></script>', "from a host"),
        ('<link rel="stylesheet" href="https://example.org/x.css">', "from a host"),
        ('<link rel="preconnect" href="https://example.org">', "from a host"),
        ('<iframe title="x" src="http://example.org"></iframe>', "from a host"),
        ('<iframe title="x" data-src="//example.org/s"></iframe>', "from a host"),
        ('<iframe title="x" data-src="gone.html"></iframe>', "gone.html: no such file"),
        ('<iframe src="index.html"></iframe>', "frame without a title"),
        ('<figure><img src="a%20b.png" alt=" "></figure>', "empty alt text"),
        ("<script>fetch('https://example.org/x.json')</script>", "from a host"),
        ("<script>import 'https://example.org/x.js'</script>", "from a host"),
        ('<script>picture.src = "//example.org/x.png"</script>', "from a host"),
        ('<p style="background: url(https://example.org/x.png)">x</p>', "from a host"),
        ("<style>@import 'https://example.org/x.css';</style>", "from a host"),
    ],
)
def test_faults_are_named_with_position(site, html, complaint):
    (site / "bad.html").write_text(f"<html><body>\n{html}\n</body></html>")
    problems = check_site(site)
    assert len(problems) == 1
    assert str(problems[0]).startswith("bad.html:2: ")
    assert complaint in problems[0].text


def test_style_sheets_are_read(site):
    (site / "_static" / "s.css").write_text("@font-face {src: url('gone.woff2')}")
    assert [p.text for p in check_site(site)] == ["link gone.woff2: no such file"]


def test_folder_without_pages_is_a_problem(tmp_path):
    assert "no HTML page" in check_site(tmp_path)[0].text
