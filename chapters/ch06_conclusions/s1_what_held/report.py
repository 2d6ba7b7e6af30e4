"""Verdicts of the build, as words of the page and as bars of its figure."""

from collections import Counter

from repro.page import value

EVIDENCE = ("analytic", "synthetic", "rendered")
CONTRIBUTIONS = ("major contribution", "minor contribution")
PANELS = ("claim", "artefact", "number", "section")


def of_kind(found, *kinds):
    """Return the rows or statements of these kinds."""
    return [one for one in found if one["kind"] in kinds]


def name_values(rows, statements):
    """Name counts of claims and statements by verdict, and the verdict of each goal."""
    claims, goals = of_kind(rows, "claim"), of_kind(statements, "goal")
    for name, found in (
        ("claims", claims),
        ("goals", goals),
        ("contributions", of_kind(statements, *CONTRIBUTIONS)),
        ("summaries", of_kind(statements, "summary")),
    ):
        value(name, len(found))
        value(f"{name}.verdicts", counted(found))
    for kind in EVIDENCE:
        value(kind, share([row for row in claims if row["evidence"] == kind]))
    for goal in goals:
        value(goal["id"], f"{goal['verdict']}, {share(goal['claims'])} claims")
    for row in claims:
        if row["chapter"] == 6:
            value(row["id"], row["verdict"])


def counted(found):
    """Return the verdicts of rows or statements as words, the most frequent first."""
    counts = Counter(one["verdict"] for one in found)
    if counts["quick"]:
        return "no verdicts in a quick build"
    return ", ".join(
        f"{count} {'differ' if verdict == 'differs' and count > 1 else verdict}"
        for verdict, count in counts.most_common()
    )


def share(claims):
    """Return how many of the claims are reproduced as words: 3 of 4."""
    counts = Counter(row["verdict"] for row in claims)
    return f"{'–' if counts['quick'] else counts['reproduced']} of {len(claims)}"


def bars_of(rows):
    """Return {kind: {chapter: counts by verdict}}, and the rows of the longest bar of
    each kind."""
    bars = {kind: {} for kind in PANELS}
    for row in rows:
        bar = bars[row["kind"]].setdefault(row["chapter"], Counter())
        bar[row["verdict"]] += 1
    return bars, {k: max(c.total() for c in own.values()) for k, own in bars.items()}
