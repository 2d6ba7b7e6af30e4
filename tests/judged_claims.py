"""Tests of claims, run as the build runs them: once for each reading of the ledger."""

from repro.judge.readings import open_questions
from repro.run.readings import in_every_reading
from tests.made_results import ROOT


def readings_of(judge, results):
    """The readings of a claim's test, of the questions that its mark names."""
    (mark,) = (mark for mark in judge.repro_marks if mark["kind"] == "claim")
    return in_every_reading(judge, results, open_questions(ROOT), mark["readings"])
