"""What the images of a set show: boards or grids, found now or read from files."""

from typing import NamedTuple

import numpy as np

from raxel.calibration.views.boards import board_views
from raxel.calibration.views.correspondence import near_copies
from raxel.calibration.views.dense import dense_view
from raxel.cli.image_sets import boards_for
from raxel.cli.warnings import of_handedness
from raxel.errors import CalibrationError, InputError
from raxel.features.boards import SizeVote
from raxel.features.grids import decode_grids, read_grids
from raxel.sets import ActiveGrid, View
from raxel.sets.model import words_of

NAMED = 5  # photographs in a warning


class Entry(NamedTuple):
    """A view of the set, whether it can be used, and why not."""

    view: View
    found: bool
    reason: str


class SeenViews(NamedTuple):
    """entries: an Entry for each view; views: what calibrations take of those found, in
    their order; grids: of each grid, for the results; warnings: what a reader must know
    of the units; vote: how photographs voted for the size of a board, or None."""

    entries: list
    views: list
    grids: list
    warnings: list
    vote: SizeVote | None = None

    def left_out(self):
        """The views that show nothing to use, for the result: [{file, reason}]."""
        return [
            {"file": entry.view.label, "reason": entry.reason}
            for entry in self.entries
            if not entry.found
        ]

    def check_enough(self, image_set, needed, purpose):
        """Raise InputError unless `needed` views can be used."""
        if len(self.views) >= needed:
            return
        missed, words = self.left_out(), words_of(image_set.target)
        example = f" ({missed[0]['file']}: {missed[0]['reason']})" if missed else ""
        raise InputError(
            f"{image_set.description}: views: {words.found} in {len(self.views)} of "
            f"{len(self.entries)} {words.images}, {purpose} needs {needed}{example}; "
            f"{words.check}"
        )

    def fields(self):
        """What results hold of grids, {grids: [{file, pixels, points, step}]}, and of
        a vote for the size of a board, {size: ...}."""
        fields = {"grids": self.grids} if self.grids else {}
        return fields | ({"size": self.vote.fields()} if self.vote else {})

    def lines(self):
        """What to say of grids and of a vote, for people."""
        if self.vote:
            yield self.vote.line()
        if not self.grids:
            return
        count = len(self.grids)
        steps, pixels, points = (
            _range([grid[key] for grid in self.grids])
            for key in ("step", "pixels", "points")
        )
        yield (
            f"{count} {'grids' if count > 1 else 'grid'} of {pixels} pixels; formulas, "
            f"poses and scores take a pixel every {steps} px each way, {points} of them"
        )
        mirrored = [view.name for view in self.views if view.mirrored]
        if len(mirrored) == count:
            yield "grids are seen as in a mirror: their y is taken with a minus sign"


def check_options(image_set, options):
    """Raise InputError for options that are for another kind of target."""
    if isinstance(image_set.target, ActiveGrid):
        wrong, target, right = ("corners", "detector"), "an active grid", "--points"
    else:
        wrong, target, right = ("points",), "a chessboard", "--corners"
    for option in wrong:
        if getattr(options, option):
            raise InputError(
                f"--{option}: found with {image_set.description}, whose target is "
                f"{target}; leave it out, or give {right}"
            )


def seen_in(image_set, views, options, say):
    """SeenViews of these views, as --corners, --points and --detector say."""
    if isinstance(image_set.target, ActiveGrid):
        return _grids(image_set, views, options, say)
    boards, vote = boards_for(image_set, views, options, say)
    entries = [Entry(b.view, b.detection.found, b.detection.reason) for b in boards]
    seen = board_views(image_set, boards)
    warnings = [*_copies(seen), *_near_copies(seen)]
    return SeenViews(entries, seen, [], warnings, vote)


def _copies(views):
    """A warning where corners of views are those of others, to the last digit."""
    first, copies = {}, []
    for view in views:
        other = first.setdefault(view.pixels.tobytes(), view.name)
        if other != view.name:
            copies.append((view.name, other))
    if not copies:
        return
    (name, other), more = copies[0], len(copies) - 1
    others = f" ({more} more such: {_named(copies[1:])})" if more else ""
    yield (
        f"{name}: its corners are those of {other}, to the last digit{others}; a "
        "picture that is there twice says nothing more, and pulls the fit twice: take "
        "it out of views"
    )


def _named(copies):
    rest = len(copies) - NAMED
    names = ", ".join(name for name, _ in copies[:NAMED])
    return f"{names} and {rest} more" if rest > 0 else names


def _near_copies(views):
    """A warning where boards stand where others do, with corners of their own."""
    first = near_copies(views)
    near = [
        (view.name, views[k].name)
        for view, k in zip(views, first, strict=True)
        if view.name != views[k].name and not _same(view, views[k])
    ]
    if not near:
        return
    (name, other), count = near[0], len(near)
    yield (
        f"{count} of {len(views)} photographs show{'s' * (count == 1)} the board where "
        f"another does, such as {name} and {other}: they say little more than one of "
        "them; standard deviations and tests count them together, and a fit is pulled "
        "by each: keep one of each in views, and take boards at other places"
    )


def _same(one, other):
    return one.pixels.tobytes() == other.pixels.tobytes()


def _grids(image_set, views, options, say):
    if options.points:
        grids = read_grids(options.points, image_set, views)
    else:
        grids = decode_grids(image_set, views, say)
    entries, seen, warnings = [], [], []
    for grid in grids:
        name, reason = grid.view.label, grid.reason
        warnings += grid.warnings
        if not reason:
            try:
                seen.append(dense_view(grid.location, grid.sigma, grid.mask, name))
            except CalibrationError as fault:
                reason = str(fault).removeprefix(f"{name}: ")
        entries.append(Entry(grid.view, not reason, reason))
    told = [
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
        warnings.append(
            "target.monitor_mm: null: lengths are in pitches of the monitor's pixels, "
            "which are taken for square"
        )
    return SeenViews(entries, seen, told, warnings)


def _range(numbers):
    low, high = min(numbers), max(numbers)
    return f"{low}" if low == high else f"{low} to {high}"
