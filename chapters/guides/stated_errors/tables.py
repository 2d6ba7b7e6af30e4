"""Stated errors beside errors that happened: a table for each part of the record."""

import re

from chapters.guides.stated_errors.results import RECORD_RUN, rows_of
from repro.run.columns import in_columns
from repro.run.experiment import table
from repro.run.outcomes import Table

NEEDS = ("ext_stated_record",)


def _part(results, name):
    """The table of one part, captioned as its measurement words it."""
    record = results[RECORD_RUN]
    rows = rows_of(record, name)
    what, date = (record.settings[f"{name}.{key}"] for key in ("what", "date"))
    # Words of a message are no Markdown.
    texts = tuple(head for head in ("Told",) if head in rows[0])
    for row in rows:
        row |= {head: _start(row[head]) for head in texts}
    caption = f"{what[0].upper()}{what[1:].rstrip('.')}. A record of {date}."
    return Table(in_columns(rows), caption, texts=texts)


def _start(message):
    """What a message says, without its numbers and advice; "" for none."""
    return re.split("[:;,]", re.sub(r" \([^)]*\)", "", message or ""))[0]


@table("ext_stated_corners", needs=NEEDS, evidence="rendered")
def corners(results):
    """Errors of corners over their stated standard deviations."""
    return _part(results, "corners")


@table("ext_stated_boards", needs=NEEDS, evidence="rendered")
def boards(results):
    """Boards found, right, wrong and refused."""
    return _part(results, "boards")


@table("ext_stated_decoding", needs=NEEDS, evidence="rendered")
def decoding(results):
    """Errors of decoded places behind monitors with a gamma."""
    return _part(results, "decoding")


@table("ext_stated_decoding_hard", needs=NEEDS, evidence="rendered")
def decoding_hard(results):
    """Errors of decoded places where noise is not white, light drifts, mirrors bend."""
    return _part(results, "decoding_hard")


@table("ext_stated_calibration", needs=NEEDS, evidence="rendered")
def calibration(results):
    """Errors of calibrations, and what is said where their assumptions fail."""
    return _part(results, "calibration")


@table("ext_stated_tables", needs=NEEDS, evidence="rendered")
def tables_of_rays(results):
    """Halves of photographs compared for tables of rays."""
    return _part(results, "tables")


@table("ext_stated_pupil", needs=NEEDS, evidence="rendered")
def pupil(results):
    """Whether a pupil is said to move."""
    return _part(results, "pupil")


@table("ext_stated_readers", needs=NEEDS, evidence="rendered")
def readers(results):
    """What became of damaged files."""
    return _part(results, "readers")
