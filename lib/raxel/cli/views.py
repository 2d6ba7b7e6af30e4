"""Views of a set: boards or grids, detected now or read from files."""

from typing import NamedTuple

import numpy as np

from raxel.calibration import board_views, dense_view
from raxel.calibration.views.correspondence import near_copies
from raxel.cli.findings import of_cut_boards, of_handedness, of_pitch, unused_text
from raxel.cli.image_sets import boards_for
from raxel.errors import CalibrationError, InputError
from raxel.evaluation.diagnoses import Diagnosis, diagnosis
from raxel.features.boards import SizeVote
from raxel.features.grids import decode_grids, read_grids
from raxel.io.stored import StoredArray
from raxel.sets import ActiveGrid, MirrorSet, View
from raxel.sets.model import words_of

# Options that do not apply to a mirror set.
BOARD_OPTIONS = "corners", "points", "detector", "board"


class Entry(NamedTuple):
    """A view of the set, whether it can be used, and why not."""

    view: View
    found: bool
    reason: str


class SeenViews(NamedTuple):
    """entries: an Entry for each view; views: BoardViews or DenseViews of those found,
    in their order; grids: for each grid its numbers, for the results; warnings: list of
    Diagnosis; vote: SizeVote for the size of a board, or None; unused: images of the
    folder that are no views, with the reason."""

    entries: list
    views: list
    grids: list
    warnings: list
    vote: SizeVote | None = None
    unused: tuple = ()

    def left_out(self):
        """The images that cannot be used, for the result: [{file, reason}]."""
        missed = [(e.view.label, e.reason) for e in self.entries if not e.found]
        return [{"file": f, "reason": why} for f, why in (*missed, *self.unused)]

    def size(self):
        """(columns, rows) of the boards, None without boards."""
        boards = (v for v in self.views if not v.every_pixel)
        return next(((board.columns, board.rows) for board in boards), None)

    def check_enough(self, image_set, needed, purpose):
        """Raise InputError unless `needed` views, each of another pose, can be used."""
        poses = len(set(near_copies(self.views)))
        if poses >= needed:
            return
        words = words_of(image_set.target)
        if len(self.views) >= needed:
            raise InputError(
                f"{image_set.description}: views: {len(self.views)} {words.images} "
                f"show {poses} different pose{'s' * (poses > 1)} of the "
                f"{words.target}, {purpose} requires {needed}; add images of others"
            )
        missed = [entry for entry in self.entries if not entry.found]
        example = f" ({missed[0].view.label}: {missed[0].reason})" if missed else ""
        raise InputError(
            f"{image_set.description}: views: {words.found} in {len(self.views)} of "
            f"{len(self.entries)} {words.images}, {purpose} requires {needed}"
            f"{example}{unused_text(image_set)}; {words.check}"
        )

    def fields(self):
        """The grids, {grids: [{file, pixels, points, step}]}, and the vote for the size
        of a board, {size: ...}, for JSON."""
        size = {"size": self.vote.fields()} if self.vote else {}
        return ({"grids": self.grids} if self.grids else {}) | size

    def lines(self):
        """Text lines of the grids and of the vote."""
        if self.vote:
            yield self.vote.line()
        if not self.grids:
            return
        steps, pixels, points = (
            _range([grid[key] for grid in self.grids])
            for key in ("step", "pixels", "points")
        )
        count = f"{len(self.grids)} grid{'s' * (len(self.grids) > 1)}"
        yield (
            f"{count} of {pixels} pixels; models, poses and scores use every {steps} "
            f"px along each axis: {points} points"
        )
        if all(view.mirrored for view in self.views):
            yield "grids are mirrored: their y axis is inverted"


def check_options(source, options):
    """Raise InputError for options that do not apply to an ImageSet or MirrorSet."""
    if isinstance(source, MirrorSet):
        wrong, target, other = BOARD_OPTIONS, "a mirror set", ""
    elif isinstance(source.target, ActiveGrid):
        wrong, target = ("corners", "detector"), "an active grid"
        other = ", or use --points"
    else:
        wrong, target, other = ("points",), "a chessboard", ", or use --corners"
    for option in (name for name in wrong if getattr(options, name, None)):
        raise InputError(
            f"--{option}: not for {target} ({source.description}); leave it out{other}"
        )


def seen_in(image_set, views, options, say):
    """SeenViews of these views, by the options --corners, --points and --detector."""
    if isinstance(image_set.target, ActiveGrid):
        return _grids(image_set, views, options, say)
    boards, vote = boards_for(image_set, views, options, say)
    entries = [Entry(b.view, b.detection.found, b.detection.reason) for b in boards]
    seen = board_views(image_set, boards)
    warnings = of_pitch(image_set.target) + of_cut_boards(boards, image_set)
    warnings += _near_copies(seen)
    return SeenViews(entries, seen, [], warnings, vote, image_set.unused)


def _near_copies(views):
    """A warning where boards have the pose of others."""
    near = [
        {"file": view.name, "original": views[k].name}
        for view, k in zip(views, near_copies(views), strict=True)
        if view.name != views[k].name
    ]
    if near:
        yield diagnosis("same-pose", count=len(near), n_views=len(views), **near[0])


def _grids(image_set, views, options, say):
    decoded = options.points and read_grids(options.points, image_set, views)
    entries, seen, warnings = [], [], []
    for grid in decoded or decode_grids(image_set, views, say):
        name, reason = grid.view.label, grid.reason
        warnings += [Diagnosis.reported("decoding", text) for text in grid.warnings]
        if not reason:
            try:
                seen.append(_stored(dense_view(*grid[1:4], name)))
            except CalibrationError as fault:
                reason = str(fault).removeprefix(f"{name}: ")
        entries.append(Entry(grid.view, not reason, reason))
    fields = [
        {
            "file": view.name,
            "pixels": view.area(),
            "points": int(np.count_nonzero(np.isfinite(view.pixels[:, 0]))),
            "step": view.step,
        }
        for view in seen
    ]
    warnings += of_handedness([(view.name, view.mirrored) for view in seen])
    if image_set.target.monitor_mm is None:
        warnings.append(diagnosis("no-monitor-size"))
    return SeenViews(entries, seen, fields, warnings)


def _stored(view):
    """The DenseView with its arrays of all pixels in files."""
    return view._replace(
        location=StoredArray(view.location),
        sigma=StoredArray(view.sigma),
        whole=StoredArray(view.whole),
    )


def _range(numbers):
    low, high = min(numbers), max(numbers)
    return f"{low}" if low == high else f"{low} to {high}"
