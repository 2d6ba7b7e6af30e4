"""A changed test of a claim requires a note in `changed`."""

from textwrap import dedent

import pytest

from repro.judge.ledger import FOLDER, LedgerError
from repro.run import recorded
from tests.sample_files import write
from tests.small_checkouts import ROOT

JUDGE = "chapters/ch01_one/s1_page/claims.py"
FILES = {
    "chapters/ch01_one/s1_page/page.py": "",
    "chapters/ch01_one/s1_page/results.py": "BOUND = 2\n",
    JUDGE: """
        from chapters.ch01_one.s1_page.results import BOUND
        from repro.judge.statistics import median_interval
        from repro.run.marks import claim
        from repro.run.outcomes import Reading

        @claim("c1_low", needs=("sweep",), evidence="synthetic", readings=("noise",))
        def judge_low(results, options):
            "The test."
            return Reading.of(median_interval(results["sweep"]).below(BOUND), 1)
        """,
    "lib/repro/judge/statistics.py": "def median_interval(x):\n    return x\n",
    "data/published/claims.yaml": """
        claims:
        - id: c1_low
          test: The error is
            low.
          changed: The bound was 3.
        - id: c1_unjudged
          test: Of a chapter that is not built.
        """,
    "data/published/settings.yaml": """
        readings:
        - id: noise
          options: [px, mm]
          primary: px
        """,
    "data/published/recorded.yaml": "recorded: []\n",
}
CLAIMS = "data/published/claims.yaml"
SETTINGS = "data/published/settings.yaml"


@pytest.fixture
def checkout(tmp_path):
    for name, text in FILES.items():
        write(tmp_path / name, dedent(text))
    return tmp_path


def replace(checkout, name, old, new):
    text = (checkout / name).read_text()
    assert old in text
    (checkout / name).write_text(text.replace(old, new))


def test_claim_tests_match_recorded_hashes():
    assert recorded.faults(ROOT) == []


def test_all_judged_claims_can_be_recorded():
    now = recorded.tests_now(ROOT)
    assert {"c2_crossover", "c4_sd_smaller"} <= now.keys()
    assert len({one["judge"] for one in now.values()}) > 100


def test_empty_record_has_no_faults(checkout):
    assert recorded.faults(checkout) == []
    assert recorded.record(checkout) == []
    assert list(recorded.recorded(checkout)) == ["c1_low"]
    assert recorded.faults(checkout) == []


ALTERED = {
    "its text": (CLAIMS, "low.\n", "lower.\n"),
    "its readings": (SETTINGS, "primary: px", "primary: mm"),
    "its judge": ("chapters/ch01_one/s1_page/results.py", "2", "3"),
}


NOTES = {
    "of one claim": ("was 3.", "was 3. Then it was altered again."),
    "of all claims": (
        "claims:",
        "rewritten: Names, with every outcome the same.\nclaims:",
    ),
}


@pytest.mark.parametrize("output", NOTES)
@pytest.mark.parametrize("part", ALTERED)
def test_changed_test_requires_changed_note(checkout, part, output):
    recorded.record(checkout)
    before = (checkout / FOLDER / recorded.NAME).read_text()
    replace(checkout, *ALTERED[part])
    line = f"claims.yaml: c1_low: its test changed ({part}), but `changed` did not; "
    (found,) = recorded.faults(checkout)
    assert found.startswith(line)
    assert recorded.record(checkout) == [found]
    assert (checkout / FOLDER / recorded.NAME).read_text() == before

    replace(checkout, CLAIMS, *NOTES[output])
    (found,) = recorded.faults(checkout)
    assert found.endswith("not the test of today; run make recorded")
    assert recorded.record(checkout) == []
    assert recorded.faults(checkout) == []


@pytest.mark.parametrize(
    ("name", "old", "new"),
    [
        (JUDGE, "The test.", "What is asked."),
        (CLAIMS, "The error is\n", "The error\n"),
        (SETTINGS, "[px, mm]", "[mm, px]"),
        ("lib/repro/judge/statistics.py", "return x", "return x + 1"),
    ],
)
def test_irrelevant_changes_need_no_note(checkout, name, old, new):
    recorded.record(checkout)
    if name == CLAIMS:
        replace(checkout, CLAIMS, "    low.", "    is low.")
    replace(checkout, name, old, new)
    assert recorded.faults(checkout) == []


def test_library_module_may_move(checkout):
    recorded.record(checkout)
    replace(checkout, JUDGE, "repro.judge.statistics", "repro.judge.medians")
    assert recorded.faults(checkout) == []


def test_missing_and_superfluous_entries_are_named(checkout):
    recorded.record(checkout)
    replace(checkout, JUDGE, "c1_low", "c1_unjudged")
    assert [line.split(";")[0] for line in recorded.faults(checkout)] == [
        "recorded.yaml: c1_low: not the test of today",
        "recorded.yaml: c1_unjudged: not the test of today",
    ]
    assert recorded.record(checkout) == []
    assert list(recorded.recorded(checkout)) == ["c1_unjudged"]


def test_damaged_record_is_one_line(checkout):
    (checkout / FOLDER / recorded.NAME).write_text("recorded: [{id: c1_low}]\n")
    with pytest.raises(LedgerError, match=r"^recorded.yaml: recorded.c1_low.test: key"):
        recorded.faults(checkout)
    (checkout / FOLDER / recorded.NAME).unlink()
    with pytest.raises(LedgerError, match="restore it from git"):
        recorded.faults(checkout)
