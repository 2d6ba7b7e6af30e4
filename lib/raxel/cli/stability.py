"""How far halves of the photographs agree about the camera, in words and as JSON."""

from raxel.evaluation.distortion import MIN_N_BOARDS

POSSIBLE = (
    "boards longer one way than stated, or bent; pictures of several cameras, or of "
    "another zoom or focus; pictures turned, cropped or stabilised; a rolling shutter "
    "while something moved; wrong corners"
)
ERRATIC = (
    "a rolling shutter while something moved; boards that bent otherwise in each "
    "picture; pictures turned, cropped or stabilised; pictures of several cameras, or "
    "of another zoom or focus; a lens, or a board, that this model does not follow; "
    "wrong corners"
)
ODD = (
    "a picture that was cropped, turned, mirrored or scaled; another camera, zoom or "
    "focus; wrong corners; something that moved"
)


def stability_fields(found):
    """A SplitHalf as JSON; None where there is none."""
    if found is None:
        return None
    worst = found.divisions[0]
    return {
        "stable": found.stable,
        "same_camera": found.same_camera,
        "p_value": found.p_value,
        "photographs_over_scatter": found.factor,
        "focal_lengths": found.focal and found.focal._asdict(),
        "odd_one": found.outlier and found.outlier._asdict(),
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
        "scatter_px": division.scatter_px,
        "allowed_px": division.allowed_px,
    }


def stability_line(found, words):
    """What halves tell of each other, for people; words: of the target."""
    if found is None:
        return (
            f"stability: not tested; it takes {MIN_N_BOARDS} {words.target}s whose "
            "halves overlap in the image"
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
    odd = found.outlier
    if odd and (found.same_camera or odd.p_value < found.p_value):
        return [
            f"{odd.name}: tells of another camera than all other {words.target}s do: "
            f"it lies {odd.times:.1f} times as far from what they say as they lie from "
            f"each other (p = {odd.p_value:.2g}), and moves rays by "
            f"{odd.rays_px:.2g} px (RMS); possible: {ODD}; look at it, or take it out "
            "of views"
        ]
    if not found.same_camera:
        return [
            f"halves of the {words.target}s tell of different cameras: divided by "
            f"'{found.divisions[0].name}', {_numbers(found, words)}; stated standard "
            f"deviations do not hold; possible: {POSSIBLE}; stability of --json says "
            f"which {words.target}s are in which half"
        ]
    if not found.one_focal:
        focal = found.focal
        return [
            f"{words.target}s do not ask for one focal length: those that they ask for "
            f"scatter by {100 * focal.sd:.2g} % (SD) beyond what explains how "
            f"{words.target}s differ in all else, {focal.times:.1f} times as far as "
            f"that (p = {focal.p_value:.2g}); divided in two by focal length: "
            f"{', '.join(min(focal.shorter, focal.longer, key=len))}, and the others; "
            "stated standard deviations have that in them only if it is chance; "
            "possible: a lens that focused anew, or a zoom that moved; pictures of "
            "several cameras; a rolling shutter while boards moved"
        ]
    worst = max(found.divisions, key=lambda each: each.disagreement_px)
    return [
        f"{words.target}s differ from each other {found.factor:.1f} times as much as "
        f"their {words.point}s' scatter explains: halves of them lead to rays up to "
        f"{worst.disagreement_px:.2g} px apart; stated standard deviations have that "
        f"in them if it is chance, and do not hold if all {words.target}s share it; "
        f"possible: {ERRATIC}"
    ]


def _numbers(found, words):
    worst = found.divisions[0]
    return (
        f"rays {worst.disagreement_px:.2g} px apart (RMS, after the best rotation, "
        f"where both saw {words.target}s), of which the {words.point}s' scatter "
        f"explains {worst.scatter_px:.2g} px, and {worst.allowed_px:.2g} px with what "
        f"photographs of one half differ by; p = {found.p_value:.2g}"
    )
