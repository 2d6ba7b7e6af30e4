"""Tests of claims, run as the build runs them: once for each reading of the ledger."""

import re

from repro.judge.readings import open_questions
from repro.run.judging import in_every_reading
from tests.made_results import ROOT, as_planned


def readings_of(judge, results):
    """The readings of a claim's test, of the questions that its mark names."""
    (mark,) = (mark for mark in judge.repro_marks if mark["kind"] == "claim")
    return in_every_reading(judge, results, open_questions(ROOT), mark["readings"])


def verdicts(judge, results):
    """(verdict of the primary reading, those of all others together)."""
    first, *others = [reading.verdict for reading in readings_of(judge, results)]
    return first, set(others)


def assert_verdicts(judge, true, false=(), turned=()):
    """A claim is reproduced on true results, differs on false ones, and is undecided
    on those that some level of the sweep turns."""
    assert verdicts(judge, true) == ("reproduced", {"reproduced"})
    for results in false:
        assert verdicts(judge, results) == ("differs", {"differs"})
    for results in turned:
        assert verdicts(judge, results) == ("undecided", {"reproduced"})


def of_rejected(judge, results):
    """{(verdict, how many of how many runs were rejected, verdict with these as
    misses)} of all readings; of one that tells of none, the verdict alone."""
    pattern = r"(\d+ of \d+) runs rejected, which as misses give: ([a-z ]+)"
    return {
        (
            one.verdict,
            *(found.groups() if (found := re.search(pattern, one.reason)) else ()),
        )
        for one in readings_of(judge, results)
    }


def readings(judge, experiment, values):
    """The readings of a claim on an experiment `as_planned`."""
    return readings_of(judge, {experiment: as_planned(experiment, values)})


def verdict(judge, experiment, values):
    """The verdict of a claim that has one reading, on an experiment `as_planned`."""
    (reading,) = readings(judge, experiment, values)
    return reading.verdict
