"""Rows of the scoreboard, and its page as a reader sees it."""

from html.parser import HTMLParser
from pathlib import Path

ROOT = Path(__file__).parents[1]
SECTION = "ch02_general_camera_model/s5_1_synthetic_data"
READING = {
    "reading": {"noise": "px"},
    "verdict": "reproduced",
    "regenerated": 0.98,
    "interval": [0.95, 1.02],
    "unit": "",
    "reason": "slope",
    "few_seeds": False,
}


def row(identifier, **changed):
    """A row of the board with a claim's fields."""
    return {
        "id": identifier,
        "kind": "claim",
        "chapter": 2,
        "words": "It grows.",
        "conditions": "",
        "verdict": "reproduced",
        "firmness": "all readings",
        "agree": [1, 1],
        "few_seeds": False,
        "evidence": "synthetic",
        "effort": "full",
        "published": "It grows.",
        "regenerated": 0.98123,
        "interval": [0.951, 1.022],
        "ratio": None,
        "unit": "",
        "reason": "slope in range",
        "test": "Slope >= 0.9.",
        "changed": "",
        "variants": [],
        "page": f"{SECTION}.html",
        "source": f"source/{SECTION}/claims.py.html#one",
        "data": ["results/sweep.json", "figures/fig_2_3.csv", "figures/fig_2_3.svg"],
    } | changed


def variant(option, **changed):
    """Another reading of the text."""
    taken = {key: READING[key] for key in ("verdict", "regenerated", "interval")}
    return {**taken, "reading": {"noise_unit": option}, "reason": "", **changed}


class Board(HTMLParser):
    """Rows (attributes, text) of the tables with a data-verdict, and every tag."""

    def __init__(self, text):
        super().__init__()
        self.rows, self.tags, self.links, self._open = [], [], [], False
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.links += [v for k, v in attrs if k == "href"]
        if tag == "tr":
            self._open = "data-verdict" in dict(attrs)
            if self._open:
                self.rows.append([dict(attrs), ""])

    def handle_data(self, data):
        if self._open:
            self.rows[-1][1] += data
