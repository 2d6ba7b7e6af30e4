"""Views of a mirror set for `calibrate_mirror`, measured in its images.

The detector of the library finds boards, and active grids are decoded. The mirror may
show a part of a step's board only. Images without a required board or grid are
rejected with their name. Redundant images of the flat reference mirror, or of the
boards of the viewing camera, are excluded and reported.
"""

import numpy as np

from raxel.calibration.mirror.clamp import MIN_N_PICKS, clamp_line, edge_picks
from raxel.calibration.mirror.observations import (
    labelled_like,
    lattice_of,
    magnification,
    normalised,
    on_one_lattice,
)
from raxel.calibration.mirror.platter import FlatMirrorImage, flat_view
from raxel.calibration.mirror.stages import ClampPicks, MirrorViews, StepViews
from raxel.calibration.parametric.opencv_fits import calibrate_zhang
from raxel.calibration.views.boards import board_views
from raxel.calibration.views.dense import dense_view
from raxel.cameras.registry import load_camera
from raxel.errors import CalibrationError, InputError
from raxel.features.boards import detect_boards
from raxel.features.grids import decode_grids
from raxel.sets.image_files import read_image
from raxel.sets.model import Charuco, ImageSet

MIN_N_BOARDS = 3  # for the viewing camera, by Zhang's method
N_PICKS = 15  # along the clamped edge
# Mean distance of the edge from the line through the given points, in their SD.
MAX_EDGE_OFFSET_SIGMAS = 3.0
# Distance of the best corner order over that of the second best, in a clear case.
MAX_ORDER_RATIO = 0.7


def mirror_views(mirror_set, say=None):
    """MirrorViews of a MirrorSet; say: a callable for one line of text per image.

    Raises InputError for images that cannot be read, for a required board or grid that
    is not found, and for a viewing camera that is not central or has another image
    size.
    """
    viewer, flags = _viewer(mirror_set, say)
    image_set = mirror_set.grids
    decoded = list(decode_grids(image_set, image_set.views, say))
    grids = tuple(_grid(image_set, seen) for seen in decoded)
    platter, left_out = _platter(mirror_set, viewer, say)
    steps, doubts = _steps(mirror_set, say)
    clamp = clamp_picks(mirror_set, viewer)
    flags = (*flags, *_warnings(decoded), *left_out, *doubts)
    thickness = mirror_set.thickness_mm
    return MirrorViews(viewer, grids, platter, thickness, clamp, steps, flags)


def ordered_like(before, after):
    """The BoardView `after` with its corners in the order of those of `before`, and
    whether that order is unambiguous.

    Counting may start at different corners of a board. Of the orders that its numbers
    of rows and columns allow, the one with the nearest corners in the image is chosen.
    """
    lattice = np.arange(after.columns * after.rows).reshape(after.rows, after.columns)
    turned = [np.rot90(lattice, k) for k in range(4)]
    fitting = [one.ravel() for one in turned if one.shape == lattice.shape]
    errors = []
    for order in fitting:
        gap = np.linalg.norm(after.pixels[order] - before.pixels, axis=1)
        errors.append(
            np.median(gap[np.isfinite(gap)]) if np.isfinite(gap).any() else 0.0
        )
    best = fitting[int(np.argmin(errors))]
    sd = None if after.sd is None else after.sd[best]
    first, second = sorted(errors)[:2]
    ordered = after._replace(pixels=after.pixels[best], sd=sd)
    return ordered, bool(first < MAX_ORDER_RATIO * second)


def clamp_picks(mirror_set, viewer):
    """ClampPicks along the clamp: on the edge in the image where one is near the given
    points, else these points."""
    given = np.array(mirror_set.clamp.points)
    sd, hidden = mirror_set.clamp.sd_px, mirror_set.clamp.hidden_mm
    between = _between(given)
    if len(given) < MIN_N_PICKS:
        given = between[:: N_PICKS // 2]
    given_picks = ClampPicks(given, sd, hidden)
    near = edge_picks(_lit(mirror_set.grids), between, reach=max(4.0, 4 * sd))
    near = near[np.isfinite(near[:, 0])]
    if len(near) < N_PICKS // 2:
        return given_picks
    try:
        line, by_hand = clamp_line(viewer, near), clamp_line(viewer, given)
    except CalibrationError:
        return given_picks
    # Distance of the edge from the given line, px.
    across = np.array([np.cos(by_hand.angle), np.sin(by_hand.angle)])
    scale = np.median(magnification(viewer, near))
    errors = (normalised(viewer, near[line.used]) - by_hand.ends[0]) @ across * scale
    if abs(np.mean(errors)) > MAX_EDGE_OFFSET_SIGMAS * sd or line.rms_px > max(sd, 0.5):
        return given_picks
    return ClampPicks(near, line.rms_px, hidden)


def _between(given):
    """N_PICKS points (n, 2) spread over the line through given points (N, 2)."""
    along = np.linalg.svd(given - given.mean(axis=0), full_matrices=False)[2][0]
    place = given @ along
    order = np.argsort(place)
    wanted = np.linspace(place.min(), place.max(), N_PICKS)
    return np.column_stack(
        [np.interp(wanted, place[order], given[order, k]) for k in range(2)]
    )


def _lit(image_set):
    """Mean of all images of the first view (H, W): the evenly lit mirror."""
    view = image_set.views[0]
    total = 0.0
    for name in view.files:
        total = total + read_image(image_set, name).astype(np.float32)
    return total / len(view.files)


def _viewer(mirror_set, say):
    """(camera, flags)"""
    if not isinstance(mirror_set.viewer, ImageSet):
        camera = load_camera(mirror_set.viewer)
        size = camera.width, camera.height
        if size != mirror_set.size or not getattr(camera, "central", False):
            raise InputError(
                f"{mirror_set.description}: viewer: found a {camera.kind} camera of "
                f"{size[0]} x {size[1]} px; give a central camera of "
                f"{mirror_set.size[0]} x {mirror_set.size[1]} px"
            )
        return camera, ()
    views, missed = _found(mirror_set.viewer, say)
    if len(views) < MIN_N_BOARDS:
        raise InputError(
            f"{mirror_set.viewer.description}: views: found the board in {len(views)} "
            f"of {len(views) + len(missed)} images; add images, at least "
            f"{MIN_N_BOARDS} with the board{_first(missed)}"
        )
    try:
        camera = calibrate_zhang(views, *mirror_set.size).camera
    except CalibrationError as fault:
        raise CalibrationError(
            f"{mirror_set.viewer.description}: views: {fault}", code=fault.code
        ) from fault
    return camera, tuple(f"viewer: {n}: excluded: {why}" for n, why in missed)


def _found(image_set, say, views=None):
    """(BoardViews, [(name, reason)] of the images without a board)"""
    boards = detect_boards(image_set, views=views, say=say)
    missed = [(b.view.label, b.detection.reason) for b in boards]
    missed = [
        one for one, b in zip(missed, boards, strict=True) if not b.detection.found
    ]
    return board_views(image_set, boards), missed


def _first(missed):
    return f" ({missed[0][0]}: {missed[0][1]})" if missed else ""


def _warnings(decoded):
    """Distinct warnings of the decoder about SeenGrids."""
    return dict.fromkeys(text for seen in decoded for text in seen.warnings)


def _grid(image_set, seen):
    """The DenseView of a DecodedGrid, or InputError."""
    reason = seen.reason
    if not reason:
        try:
            return dense_view(seen.location, seen.sigma, seen.mask, seen.view.label)
        except CalibrationError as fault:
            reason = str(fault)
    raise InputError(
        f"{image_set.description}: {seen.view.label}: grid not found ({reason}); "
        "take new images of the monitor's patterns in the mirror"
    )


def _platter(mirror_set, viewer, say):
    """(PlatterPictures, flags), without those in which a board or a grid is missing."""
    boards, missed = _found(mirror_set.plate, say)
    by_name = {view.name: view for view in boards}
    grids = list(decode_grids(mirror_set.platter, mirror_set.platter.views, say))
    flags = list(_warnings(grids))
    why_not = dict(missed)
    images = []
    for position, name in enumerate(v.label for v in mirror_set.grids.views):
        usable = 0
        for k in mirror_set.platter_views(name):
            plate = mirror_set.plate.views[k].label
            try:
                grid = flat_view(viewer, _grid(mirror_set.platter, grids[k]))
                if plate in why_not:
                    raise InputError(
                        f"{mirror_set.plate.description}: {plate}: board not found "
                        f"({why_not[plate]}); take a new image of the plate's board"
                    )
            except InputError as fault:
                flags.append(f"platter: excluded: {fault}")
                continue
            # One position of the flat mirror per image: it may have moved between them.
            images.append(FlatMirrorImage(by_name[plate], grid, len(images), position))
            usable += 1
        if not usable:
            raise InputError(flags[-1].removeprefix("platter: excluded: "))
    return tuple(images), tuple(flags)


def _steps(mirror_set, say):
    """(StepViews, flags), the corners of each board in one order before and after."""
    labels = {view.label: view for view in mirror_set.stages.views}
    names = [name for step in mirror_set.steps for name in (step.before, step.after)]
    wanted = [labels[name] for name in dict.fromkeys(names)]
    boards = detect_boards(mirror_set.stages, views=wanted, say=say)
    numbered = isinstance(mirror_set.stages.target, Charuco)
    missed = [board for board in boards if not board.detection.found]
    if missed and not numbered:
        return _steps_in_part(mirror_set, boards)
    for board in missed:
        raise InputError(_without_board(mirror_set, board))
    views = board_views(mirror_set.stages, boards)
    of, steps, flags = {view.name: view for view in views}, [], []
    for k, step in enumerate(mirror_set.steps, 1):
        before, clear = of[step.before], True
        if not numbered:
            of[step.after], clear = ordered_like(before, of[step.after])
        if not clear:
            flags.append(
                f"step {k}: the corner order after the deflection is ambiguous (large "
                "motion of the board in the image); use smaller steps"
            )
        steps.append(StepViews(before, of[step.after], step.deflection_mm))
    return tuple(steps), tuple(flags)


def _steps_in_part(mirror_set, boards):
    """As `_steps`, where some images show a part of the board."""
    of = {}
    for board in boards:
        lattice = lattice_of(board.detection)
        if lattice is None:
            raise InputError(_without_board(mirror_set, board))
        of[board.view.label] = lattice
    clamp, flags = np.array(mirror_set.clamp.points), []
    for k, step in enumerate(mirror_set.steps, 1):
        pair = f"step {k} ({step.before}, {step.after})"
        of[step.after] = labelled_like(of[step.before], of[step.after], clamp, pair)
        counts = [len(of[name].corners) for name in (step.before, step.after)]
        flags.append(
            f"step {k}: the board is partly visible, {counts[0]} corners before and "
            f"{counts[1]} after"
        )
    views = on_one_lattice(list(of.values()), mirror_set.stages.target, list(of))
    of = dict(zip(of, views, strict=True))
    steps = [
        StepViews(of[step.before], of[step.after], step.deflection_mm)
        for step in mirror_set.steps
    ]
    return tuple(steps), tuple(flags)


def _without_board(mirror_set, board):
    return (
        f"{mirror_set.stages.description}: {board.view.label}: board not found "
        f"({board.detection.reason}); take a new image of the board in the mirror"
    )
