"""What is known of the image beyond the boards, in words and as JSON."""

from raxel.evaluation.coverage import UNKNOWN_PX


def beyond_fields(found):
    """A BeyondBoards as JSON; None where there is none."""
    if found is None:
        return None
    return {
        "share_of_image": found.share,
        "share_unknown": found.unknown,
        "largest_sd_px": found.largest_px,
        "sd_under_boards_px": found.under_px,
    }


def beyond_warnings(found, words):
    """What to say where much of the image is known by extrapolation alone; words: of
    the target."""
    if found is None or not found.matters:
        return []
    return [
        f"{100 * found.share:.0f} % of the image lie beyond all {words.target}s, where "
        "rays are extrapolated and no residual tells of them: if the lens departs from "
        f"the model a little, they may be off by up to {found.largest_px:.2g} px (SD; "
        f"{found.under_px:.2g} px under the {words.target}s), and in "
        f"{100 * found.unknown:.0f} % of the image by {UNKNOWN_PX:g} px or more; take "
        f"photographs with the {words.target} in the corners and at the rim, or keep "
        "to the middle"
    ]
