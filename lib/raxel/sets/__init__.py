"""Image sets: a folder of photographs and a set.yaml that says what they show."""

from raxel.sets.image_files import read_colour, read_image
from raxel.sets.image_set import load_set, write_set
from raxel.sets.mirror_set import MirrorSet, is_mirror_set, load_mirror_set
from raxel.sets.model import (
    ActiveGrid,
    Charuco,
    Chessboard,
    ImageSet,
    MonitorChessboard,
    Motion,
    Pattern,
    View,
)
from raxel.sets.patterns import (
    PatternPlan,
    chessboard_of_corners,
    chessboard_picture,
    pattern_picture,
    patterns_of,
    plan_of_cells,
)
from raxel.sets.reference import ReferenceCorners, load_reference

__all__ = [
    "ActiveGrid",
    "Charuco",
    "Chessboard",
    "ImageSet",
    "MirrorSet",
    "MonitorChessboard",
    "Motion",
    "Pattern",
    "PatternPlan",
    "ReferenceCorners",
    "View",
    "chessboard_of_corners",
    "chessboard_picture",
    "is_mirror_set",
    "load_mirror_set",
    "load_reference",
    "load_set",
    "pattern_picture",
    "patterns_of",
    "plan_of_cells",
    "read_colour",
    "read_image",
    "write_set",
]
