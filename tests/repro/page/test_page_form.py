"""Pages of the thesis have one form: order, few findings and numbers, plain words."""

import re
from collections import Counter
from pathlib import Path

import pytest

from repro.run.discover import page_files, page_id

ROOT = Path(__file__).resolve().parents[3]
HEADINGS = (
    "Terms",
    "What the thesis claims",
    "Model",
    "Experiment",
    "Discussion",
    "Summary",
    "Compared with the published numbers",
    "Try it yourself",
)
FINDINGS, WORDS, NUMBERS = 4, 40, 3
GLUE = re.compile(r"\{glue:text\}`[^`]*`")
MAX_SENTENCE = 30
PLAIN = re.compile(
    r"\b(told|nobody|somebody|whoever|hangs? on|stands?|kept[- ]out|left open|"
    r"forete(ll|lls)|foretold|reckon(s|ed)?|mend(s|ed)?|harm|refuse[sd]?|beside|"
    r"aslant|half a turn|in silence|pictures?|bench|laboratory|ledger|lamp|seeds?)\b"
    r"|\b(is|are) none\b|\bask(s|ed)? for\b"
    r"|\bbefore (a|an|the) (camera|mirror|lens|monitor|board)\b"
    r"|\b(boards?|photographs?|views|data|images?|pixels?) (say|tell|ask|know)s?\b",
    re.I,
)

PAGES = {
    page_id(ROOT, path): path
    for path in page_files(ROOT)
    if page_id(ROOT, path).startswith(("ch0", "appendix"))
}


def markdown_of(path: Path) -> list[str]:
    """Text of each Markdown cell of a page."""
    cells = re.split(r"^# %%", path.read_text("utf-8"), flags=re.M)
    return [
        re.sub(r"^# ?", "", cell.partition("\n")[2], flags=re.M)
        for cell in cells
        if cell.startswith(" [markdown]")
    ]


def prose_of(path: Path) -> str:
    """The page's text without formulas, links' targets, code and numbers."""
    text = "\n\n".join(markdown_of(path))
    text = re.sub(r"\$\$.*?\$\$", " ", text, flags=re.S)
    text = GLUE.sub("9", text)
    text = re.sub(r"\$[^$]*\$", "x", text)
    text = re.sub(r"`[^`]*`", "code", text)
    return re.sub(r"\]\([^)]*\)", "]", text)


def findings_of(path: Path) -> list[str]:
    """The findings of a page, each without its mark."""
    text = "\n\n".join(markdown_of(path))
    found = re.search(r"\*\*Findings\.\*\*.*?\n\n(.*?)(?=\n\n(?!\d)|\Z)", text, re.S)
    assert found, "no **Findings.**"
    return [part for part in re.split(r"^\d\. ", found[1], flags=re.M) if part.strip()]


def long_sentences(text: str) -> list[str]:
    """Sentences of more words than a reader takes in at once."""
    lines = [part for part in text.split("\n\n") if not part.lstrip().startswith("|")]
    sentences = [
        sentence
        for line in lines
        for item in re.split(r"^(?:- |\d\. )", line, flags=re.M)
        for sentence in re.split(r"(?<=[.?!:])\s+", item)
    ]
    return [s for s in sentences if len(s.split()) > MAX_SENTENCE]


@pytest.mark.parametrize("name", PAGES)
def test_page_has_its_parts_in_order(name):
    text = "\n\n".join(markdown_of(PAGES[name]))
    marks = (
        "**Question.**",
        "**Findings.**",
        "| thesis |",
        *(f"\n## {h}" for h in HEADINGS),
    )
    places = [text.find(mark) for mark in marks]
    missing = [mark for mark, place in zip(marks, places, strict=True) if place < 0]
    assert not missing
    assert places == sorted(places)


@pytest.mark.parametrize("name", PAGES)
def test_findings_are_few_and_short(name):
    findings = findings_of(PAGES[name])
    assert len(findings) <= FINDINGS
    for finding in findings:
        assert len(GLUE.sub("9", finding).split()) <= WORDS, finding
        assert len(GLUE.findall(finding)) <= NUMBERS, finding


@pytest.mark.parametrize("name", PAGES)
def test_page_is_written_in_plain_words(name):
    text = prose_of(PAGES[name])
    assert not Counter(found[0].lower() for found in PLAIN.finditer(text))
    assert not long_sentences(text)


def test_titles_are_unique():
    titles = Counter(
        re.search(r"^# (.*)$", "\n".join(markdown_of(path)), re.M)[1]
        for path in page_files(ROOT)
    )
    assert not [title for title, count in titles.items() if count > 1 or "?" in title]
