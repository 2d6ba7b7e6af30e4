"""Chapter 6 and the first screen of the scoreboard follow the verdicts of a build."""

import re

from chapters.ch06_conclusions.s1_what_held import report
from repro.judge import ledger, scoreboard
from repro.page.reader import show_part
from repro.run.jobs import Size
from repro.site import scoreboard as board_page
from repro.workflow.plan import BuildPlan
from tests.scoreboard_rows import ROOT, row

STATEMENTS = scoreboard.read_statements(ROOT)
DIFFERS = {"verdict": "differs", "regenerated": -20.4}
QUICK = {"effort": "quick", "verdict": "quick", "firmness": None, "agree": None}


def board(**changed):
    """Every claim of the thesis, reproduced unless stated otherwise, and one row of
    each other kind."""
    rows = [row(kind, kind=kind) for kind in ("artefact", "number", "section")]
    for name, entry in ledger.load(ROOT).claims.items():
        of_claim = {"words": entry["statement"], "chapter": entry["section"][0]}
        rows.append(row(name, **of_claim | changed.get(name, {})))
    return scoreboard.checked(rows)


def named(monkeypatch, rows):
    values = {}
    monkeypatch.setattr(report, "value", values.__setitem__)
    report.name_values(rows, scoreboard.concluded(STATEMENTS, rows))
    return values


def test_prose_follows_verdicts(monkeypatch):
    found = named(monkeypatch, board(c3_beats_opencv=DIFFERS, c5_sfm=DIFFERS))
    count = found["claims"]
    assert (
        found.items()
        >= {
            "claims.verdicts": f"{count - 2} reproduced, 2 differ",
            "synthetic": f"{count - 2} of {count}",
            "goals.verdicts": "3 reproduced, 2 differ",
            "goal_chessboards": "differs, 1 of 2 claims",
        }.items()
    )
    found = named(monkeypatch, [one | QUICK for one in board()])
    assert (
        found.items()
        >= {
            "goals.verdicts": "no verdicts in a quick build",
            "goal_chessboards": "quick, – of 2 claims",
        }.items()
    )


def test_figure_counts_every_row():
    rows = board(c4_t41_order={"verdict": "undecided"})
    shown = show_part("verdicts", *report.bars_of(rows)).html
    counts = re.findall(r'flex-grow: (\d+)"[^>]*title="(\d+) (\w+)"', shown)
    assert sum(int(count) for count, *_ in counts) == len(rows)
    assert "chapter=4&amp;kind=claim&amp;verdict=undecided" in shown


def test_goal_shows_its_claims_and_the_leading_value():
    goals = scoreboard.concluded(STATEMENTS[:2], board(c3_beats_opencv=DIFFERS))
    shown = show_part("statements", goals).html
    first, second = re.findall(r"<tr id=.*?</tr>", shown, re.S)
    assert 'data-verdict="differs"' in first
    assert re.search(r"1 of 2 reproduced.*lead in success rate is\s+-20.4", first, re.S)
    assert 'data-verdict="reproduced"' in second


def test_first_screen_of_scoreboard_answers_in_ten_lines():
    page = board_page.page(board(c3_beats_opencv=DIFFERS), STATEMENTS)
    screen = page[page.index("<p><b>Of 233 claims:") : page.index("Every artefact")]
    leading = [one["leading"]["claim"] for one in STATEMENTS if "leading" in one]
    assert all(f'href="#{claim}"' in screen for claim in leading)
    assert screen.count("rx-differs") == 1
    text = re.sub(r"<[^>]+>", "", re.sub(r"</(li|p)>", "\n", screen))
    answers = [" ".join(line.split()) for line in text.split("\n") if line.strip()]
    assert len(answers) == 1 + len(leading) == 6
    # A line of the board has 120 characters on a screen of 1280 px.
    assert sum(1 + len(answer) // 120 for answer in answers) <= 10


def test_pages_of_verdicts_depend_on_scoreboard():
    tasks = BuildPlan(ROOT, Size("quick")).tasks.values()
    pages = [task.name for task in tasks if "scoreboard" in task.needs]
    pages.remove("site")
    assert [page.split("/")[1] for page in pages] == ["ch06_conclusions"] * 2
