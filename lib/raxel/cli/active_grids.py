"""Active grids from the command line: `raxel patterns` and `raxel decode`."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

from raxel.cli.findings import of_handedness, of_swapped_sides
from raxel.cli.outputs import new_folder
from raxel.cli.terminal import Say, on_one_line
from raxel.errors import InputError
from raxel.features.active_grid.view import DecodedView, decode_view
from raxel.features.grids import SUMMARY, write_points
from raxel.io.files import write_json
from raxel.report.active_grids import decoded_figure, pattern_sheet
from raxel.sets import (
    ActiveGrid,
    ImageSet,
    Pattern,
    View,
    chessboard_image,
    load_set,
    pattern_image,
    patterns_of,
    plan_of_cells,
)
from raxel.sets.image_files import write_png
from raxel.sets.image_set import set_text
from raxel.sets.model import DESCRIPTION
from raxel.sets.patterns import BLACK, CHESSBOARD, WHITE, chessboard_of_corners

PREVIEW = "preview.png"
HEADER = """\
# Show each image of this folder on the whole monitor, pixel by pixel, in a dark room,
# and photograph it. Camera and monitor are stationary; focus and exposure are manual,
# the same for all images, and nothing is overexposed. Give the photographs the names of
# the patterns, put them into a new folder with this file (each pose into its own
# folder, as below), and fill in:
# - resolution: width and height of the images in px
# - monitor_mm: width and height of the lit area in mm, [w, h], if it is null
# Further poses are further entries of views, with other names for their files.
"""
FEW_STEPS = """\
# Fewer than six phase steps require a nearly linear response of monitor and camera:
# otherwise low harmonics shift the decoded positions. The part of the shift that can be
# measured in the images is corrected.
"""


def patterns(options: SimpleNamespace, say: Say) -> None:
    """Write the patterns of a monitor, and a set.yaml for the photographs of them."""
    size = options.width, options.height
    plan = plan_of_cells(size, options.cells, options.steps, options.offset)
    shown = patterns_of(plan)
    board = options.chessboard and chessboard_of_corners(size, *options.chessboard)
    with new_folder(options.out) as folder:
        for number, pattern in enumerate(shown, 1):
            image = pattern_image(pattern, size)
            write_png(folder / pattern.image, image)
            say(f"{number}/{len(shown)} {pattern.image}")
        others = {WHITE: np.full_like(image, 255), BLACK: np.zeros_like(image)}
        if board:
            others[CHESSBOARD] = chessboard_image(board, size)
        for name, image in others.items():
            write_png(folder / name, image)
        pattern_sheet(shown, size).savefig(folder / PREVIEW)
        grid = ActiveGrid(size, options.size_mm, board)
        text = HEADER + FEW_STEPS * (options.steps < 6)
        text += set_text(_described(shown, grid, options.poses))
        (folder / DESCRIPTION).write_text(text, "utf-8")
    cells = " x ".join(f"{width:g}" for width in plan.cell_px)
    print(
        f"{len(shown)} patterns with cells of {cells} px, {', '.join(others)} and "
        f"{PREVIEW} in {on_one_line(options.out)}; {DESCRIPTION} contains instructions"
    )


def _described(shown: Sequence[Pattern], grid: ActiveGrid, n_poses: int) -> ImageSet:
    """Return a set of one pose, or of several in folders of their own."""
    names = [f"pose-{k}" for k in range(1, n_poses + 1)]
    folders = [f"{name}/" for name in names] if n_poses > 1 else [""]
    views = tuple(
        View(
            name=name,
            white=folder + WHITE,
            black=folder + BLACK,
            chessboard=folder + CHESSBOARD if grid.chessboard else None,
            patterns=tuple(replace(p, image=folder + p.image) for p in shown),
        )
        for name, folder in zip(names, folders, strict=True)
    )
    return ImageSet("my-active-grid", 0, 0, grid, views, Path())


def decode(options: SimpleNamespace, say: Say) -> None:
    """Decode the screen position that each pixel sees, in every view of the set."""
    image_set = load_set(options.set)
    _check_names(image_set)
    _check_margin(options.margin, image_set)
    summaries: list[dict] = []
    warnings: list[str] = []
    with new_folder(options.out) as folder:
        for number, view in enumerate(image_set.views, 1):
            found = decode_view(
                image_set, view,
                smooth=not options.raw, neighbours=options.neighbours,
                fill=options.fill, margin_px=options.margin, linear=options.linear,
            )  # fmt: skip
            if found.reason:
                raise InputError(
                    f"{image_set.description}: views: {view.label}: {found.reason}"
                )
            _write(folder, view.label, found, image_set.target)
            summaries.append(_summary(view.label, found))
            warnings += found.warnings
            del found  # memory for the next one
            say(f"{number}/{len(image_set.views)} {view.label}")
        warnings += of_handedness([(v["view"], v["as_in_a_mirror"]) for v in summaries])
        warnings += of_swapped_sides(image_set.target)
        write_json(
            folder / SUMMARY,
            {"set": image_set.name, "views": summaries, "warnings": warnings},
        )
    for summary in summaries:
        print(_line(summary))
    print(f"points, sigma and mask of each view in {on_one_line(options.out)}")
    for text in warnings:
        print(f"warning: {on_one_line(text)}")


def _write(folder: Path, label: str, found: DecodedView, target: Any) -> None:
    decoded, image = found.decoded, found.image
    write_points(folder / f"{label}.npz", decoded)
    if image.dtype == np.uint16:
        image = (image >> 8).astype(np.uint8)
    extent = target.monitor_mm or target.monitor_px
    figure = decoded_figure(decoded, image, extent)
    figure.savefig(folder / f"{label}.png", bbox_inches="tight")


def _summary(label: str, found: DecodedView) -> dict[str, Any]:
    decoded = found.decoded
    return {
        "view": label,
        "unit": decoded.unit,
        "pixels": {reason: n for reason, n in decoded.counts().items() if n},
        "median_sigma": [_median(decoded.sigma[..., axis]) for axis in (0, 1)],
        "noise_floor": decoded.noise.floor,
        "noise_slope": decoded.noise.slope,
        "blur_px": decoded.blur_px,
        "margin_px": decoded.margin_px,
        "response": {
            "corrected": [bool(own.ripple.steps) for own in decoded.response],
            "shift": [own.size for own in decoded.response],
            "left": [own.remaining for own in decoded.response],
        },
        "step_errors": list(found.step_errors),
        "noise_factors": list(found.noise_factors),
        "as_in_a_mirror": found.as_in_a_mirror,
    }


def _median(sigma: np.ndarray) -> float | None:
    """Return the median of the finite values, None if there are none."""
    finite = sigma[np.isfinite(sigma)]
    return float(np.median(finite, overwrite_input=True)) if len(finite) else None


def _check_names(image_set: ImageSet) -> None:
    for index, view in enumerate(image_set.views):
        if any(sign in view.label for sign in '/\\:*?"<>|\0') or view.label[0] == ".":
            raise InputError(
                f"{image_set.description}: views[{index}].name: found {view.label!r}, "
                "not possible as a file name; choose another name"
            )


def _check_margin(margin: int | None, image_set: ImageSet) -> None:
    """Raise InputError for a margin that excludes the whole image."""
    largest = (min(image_set.width, image_set.height) - 1) // 2
    if margin is not None and margin > largest:
        raise InputError(
            f"--margin: found {margin} px, but the images have {image_set.width} x "
            f"{image_set.height} px; give at most {largest}"
        )


def _line(view: dict[str, Any]) -> str:
    total = sum(view["pixels"].values())
    parts = ", ".join(
        f"{100 * count / total:.1f} % {reason}"
        for reason, count in view["pixels"].items()
    )
    sigma = " and ".join(
        f"{axis} {value:.3g} {view['unit']}"
        for axis, value in zip("xy", view["median_sigma"], strict=True)
        if value is not None
    )
    mirror = "; mirror image" if view["as_in_a_mirror"] else ""
    blur = "" if view["blur_px"] is None else f"; blur {view['blur_px']:.2g} px"
    return (
        f"{on_one_line(view['view'])}: {parts}; median sigma {sigma}{blur}, margin "
        f"{view['margin_px']} px{_of_response(view)}{mirror}"
    )


def _of_response(view: dict[str, Any]) -> str:
    """Describe the correction of the response of monitor and camera."""
    corrected = [
        f"{axis} by {shift:.2g} {view['unit']}, {remaining:.2g} left"
        for axis, used, shift, remaining in zip(
            "xy", *view["response"].values(), strict=True
        )
        if used
    ]
    return f"; response corrected: {'; '.join(corrected)}" if corrected else ""
