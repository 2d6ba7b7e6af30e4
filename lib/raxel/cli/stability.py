"""How far halves of the photographs agree about the camera, in words and as JSON."""

from raxel.evaluation.stability import FEWEST_BOARDS

POSSIBLE = (
    "boards longer one way than stated, or bent; pictures of several cameras, or of "
    "another zoom or focus; a rolling shutter while something moved; wrong corners"
)


def stability_fields(found):
    """A Stability as JSON; None where there is none."""
    if found is None:
        return None
    worst = found.divisions[0]
    return {
        "stable": found.stable,
        "p_value": found.p_value,
        **_told(worst),
        "halves": [list(names) for names in worst.halves],
        "divisions": [
            {**_told(each), "p_value": each.p_value} for each in found.divisions
        ],
    }


def _told(division):
    return {
        "divided_by": division.name,
        "disagreement_px": division.disagreement_px,
        "allowed_px": division.allowed_px,
    }


def stability_line(found, words):
    """What halves tell of each other, for people; words: of the target."""
    if found is None:
        return (
            "stability: not tested; it takes a formula or smooth rays, and "
            f"{FEWEST_BOARDS} {words.target}s whose halves overlap in the image"
        )
    worst = found.divisions[0]
    return (
        f"stability: of {len(found.divisions)} divisions into halves the worst is "
        f"'{worst.name}': {_numbers(found, words)}"
    )


def stability_warnings(found, words):
    """What to say of a camera that hangs on the photographs it was fitted to."""
    if found is None or found.stable:
        return []
    return [
        f"halves of the {words.target}s tell of different cameras: divided by "
        f"'{found.divisions[0].name}', {_numbers(found, words)}; stated standard "
        f"deviations do not hold; possible: {POSSIBLE}; stability of --json says which "
        f"{words.target}s are in which half"
    ]


def _numbers(found, words):
    worst = found.divisions[0]
    return (
        f"rays {worst.disagreement_px:.2g} px apart (RMS, after the best rotation, "
        f"where both saw {words.target}s), of which the {words.point}s' scatter "
        f"explains {worst.allowed_px:.2g} px; p = {found.p_value:.2g}"
    )
