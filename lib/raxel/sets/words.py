"""What messages call a target and what is found on it."""

from typing import NamedTuple

from raxel.sets.model import ActiveGrid


class Words(NamedTuple):
    """target: what stands before the camera; point: what is found on it; found: what
    became of a view that can be used; images: what a view is; check: where to look when
    too few can."""

    target: str
    point: str
    found: str
    images: str
    check: str


BOARDS = Words(
    "board",
    "corner",
    "board found",
    "images",
    "check target.columns and target.rows, or try another --detector",
)
GRIDS = Words(
    "grid",
    "point",
    "grid decoded",
    "views",
    "check exposure and order of the pictures; raxel decode draws what each pixel sees",
)


def words_of(target):
    """The Words for a target of an image set."""
    return GRIDS if isinstance(target, ActiveGrid) else BOARDS
