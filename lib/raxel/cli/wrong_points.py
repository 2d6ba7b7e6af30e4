"""Corners that do not fit and have no weight, in words and as JSON."""

import math
from collections import Counter

NAMED = 5  # photographs in a warning


def wrong_points(details, found):
    """[{file, corner, distance_px}] of what a fit gave no weight, and of what stands
    alone: WrongCorners."""
    wrong = {(name, n): px for name, n, px in found.wrong}
    for entry in details.get("wrong_points", []):
        wrong[entry["file"], entry["corner"]] = entry["distance_px"]
    return [
        {"file": name, "corner": n, "distance_px": px}
        for (name, n), px in sorted(wrong.items())
    ]


def wrong_fields(wrong, count):
    """Those points for the result, their share of `count`, and how many there are in
    each photograph."""
    return {
        "wrong_points": wrong,
        "share_of_wrong_points": len(wrong) / count if count else None,
        "wrong_points_of": dict(Counter(entry["file"] for entry in wrong)),
    }


def wrong_line(fields, words):
    """How many points do not fit, and in which photographs; None where all do."""
    wrong = fields["wrong_points"]
    if not wrong:
        return None
    what, of = words.point, Counter(fields["wrong_points_of"]).most_common()
    many = len(wrong) > 1
    told = ", ".join(f"{name} ({n})" for name, n in of[:NAMED])
    rest = f" and {len(of) - NAMED} more" if len(of) > NAMED else ""
    return (
        f"{len(wrong)} {what}{'s' if many else ''} "
        f"({100 * fields['share_of_wrong_points']:.1f} %) "
        f"{'do not fit and have' if many else 'does not fit and has'} no weight: "
        f"photograph{'s' if len(of) > 1 else ''} {told}{rest}"
    )


def wrong_warnings(fields, right_px, words):
    """What to warn of; right_px: RMS distance of the others."""
    line = wrong_line(fields, words)
    if line is None:
        return []
    worst = max(fields["wrong_points"], key=lambda entry: entry["distance_px"])
    off = math.ceil(10 * worst["distance_px"]) / 10
    return [
        f"{line}; the worst, number {worst['corner']} of {worst['file']}, is off by "
        f"{off:g} px, the others by {right_px:.2f} px (RMS); look at it, and at "
        "wrong_points of --json"
    ]
