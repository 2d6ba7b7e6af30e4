"""`raxel decode SET --out FOLDER`"""

import numpy as np

from raxel.cli.new_folder import new_folder
from raxel.cli.terminal import on_one_line
from raxel.cli.warnings import of_handedness, of_swapped_sides, print_warnings
from raxel.errors import InputError
from raxel.features.active_grid.view import decode_view
from raxel.features.grids import SUMMARY, write_points
from raxel.io.files import write_json
from raxel.report.canvas import encoded
from raxel.report.images import decoded_picture
from raxel.sets import load_set


def decode(options, say):
    """Find the point of the monitor that each pixel sees, in every view of the set."""
    image_set = load_set(options.set)
    _check_names(image_set)
    _check_margin(options.margin, image_set)
    summaries, warnings = [], []
    with new_folder(options.out) as folder:
        for number, view in enumerate(image_set.views, 1):
            found = decode_view(
                image_set, view,
                smooth=not options.raw, neighbours=options.neighbours,
                fill=options.fill, margin_px=options.margin, linear=options.linear,
            )  # fmt: skip
            if found.reason:
                where = f"{image_set.description}: views: {view.label}"
                raise InputError(f"{where}: {found.reason}")
            _write(folder, view.label, found, image_set.target)
            summaries.append(_summary(view.label, found))
            warnings += found.warnings
            say(f"{number}/{len(image_set.views)} {view.label}")
        told = [(view["view"], view["as_in_a_mirror"]) for view in summaries]
        warnings += of_handedness(told) + of_swapped_sides(image_set.target)
        summary = {"set": image_set.name, "views": summaries, "warnings": warnings}
        write_json(folder / SUMMARY, summary)
    for view in summaries:
        print(_line(view))
    print(f"points, sigma and mask of each view in {on_one_line(options.out)}")
    print_warnings([on_one_line(text) for text in warnings])


def _write(folder, label, found, target):
    decoded, picture = found.decoded, found.image
    write_points(folder / f"{label}.npz", decoded)
    if picture.dtype == np.uint16:
        picture = (picture >> 8).astype(np.uint8)
    drawn = decoded_picture(decoded, picture, target.monitor_mm or target.monitor_px)
    (folder / f"{label}.png").write_bytes(encoded(drawn, ".png"))


def _summary(label, found):
    decoded = found.decoded
    pixels = {reason: n for reason, n in decoded.counts().items() if n}
    return {
        "view": label,
        "unit": decoded.unit,
        "pixels": pixels,
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


def _median(sigma):
    """The median over what is known, None where nothing is."""
    known = sigma[np.isfinite(sigma)]
    return float(np.median(known)) if len(known) else None


def _check_names(image_set):
    for index, view in enumerate(image_set.views):
        if any(sign in view.label for sign in '/\\:*?"<>|\0') or view.label[0] == ".":
            raise InputError(
                f"{image_set.description}: views[{index}].name: found {view.label!r}, "
                "which can be no name of a file; choose another"
            )


def _check_margin(margin, image_set):
    """Raise InputError for a margin that leaves nothing of a picture."""
    width, height = image_set.width, image_set.height
    if margin is not None and 2 * margin >= min(width, height):
        raise InputError(
            f"--margin: found {margin} px, and nothing is left of {width} x {height} "
            f"px; give {(min(width, height) - 1) // 2} at most"
        )


def _line(view):
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
    mirror = "; seen as in a mirror" if view["as_in_a_mirror"] else ""
    blur = "" if view["blur_px"] is None else f"; blur {view['blur_px']:.2g} px"
    margin = f"{blur}, margin {view['margin_px']} px{_of_response(view)}"
    return f"{on_one_line(view['view'])}: {parts}; median sigma {sigma}{margin}{mirror}"


def _of_response(view):
    """What the response of monitor and camera did to places, and what is left."""
    found = view["response"]
    parts = [
        f"{axis} by {shift:.2g} {view['unit']}, {remaining:.2g} left"
        for axis, corrected, shift, remaining in zip("xy", *found.values(), strict=True)
        if corrected
    ]
    return f"; response corrected: {'; '.join(parts)}" if parts else ""
