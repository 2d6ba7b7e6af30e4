"""`raxel decode SET --out FOLDER`"""

import numpy as np

from raxel.cli.new_folder import new_folder
from raxel.cli.terminal import on_one_line
from raxel.errors import InputError
from raxel.features.active_grid import decode as decode_view
from raxel.files import write_json
from raxel.report.active_grid import decoded_picture
from raxel.report.canvas import encoded
from raxel.sets import ActiveGrid, load_set, read_image

SUMMARY = "decoded.json"


def decode(options, say):
    """Find the point of the monitor that each pixel sees, in every view of the set."""
    image_set = load_set(options.set)
    if not isinstance(image_set.target, ActiveGrid):
        raise InputError(
            f"{image_set.description}: target.kind: found no active_grid; chessboards "
            "are for raxel corners"
        )
    _check_names(image_set)
    summaries = []
    with new_folder(options.out) as folder:
        for number, view in enumerate(image_set.views, 1):
            summaries.append(_decode(image_set, view, options, folder))
            say(f"{number}/{len(image_set.views)} {view.label}")
        write_json(folder / SUMMARY, {"set": image_set.name, "views": summaries})
    for view in summaries:
        print(_line(view))
    print(f"points, sigma and mask of each view in {on_one_line(options.out)}")


def _decode(image_set, view, options, folder):
    images = np.array([read_image(image_set, p.image) for p in view.patterns])
    levels = {
        name: read_image(image_set, getattr(view, name))
        for name in ("white", "black")
        if getattr(view, name)
    }
    try:
        found = decode_view(
            images, view.patterns, image_set.target, **levels,
            smooth=not options.raw, neighbours=options.neighbours, fill=options.fill,
            margin_px=options.margin,
        )  # fmt: skip
    except InputError as fault:
        where = f"{image_set.description}: views: {view.label}"
        raise InputError(f"{where}: {fault}") from fault
    counts = found.counts()
    if not found.mask.any():
        reasons = (f"{n} {reason}" for reason, n in counts.items() if n)
        raise InputError(
            f"{image_set.description}: views: {view.label}: no pixel could be decoded "
            f"({', '.join(reasons)}); check exposure and order of its pictures"
        )
    np.savez_compressed(
        folder / f"{view.label}.npz",
        **{f"points_{found.unit}": found.location, f"sigma_{found.unit}": found.sigma},
        mask=found.mask,
        status=found.status,
    )
    target = image_set.target
    photograph = levels.get("white", images[0])
    if photograph.dtype == np.uint16:
        photograph = (photograph >> 8).astype(np.uint8)
    picture = decoded_picture(found, photograph, target.monitor_mm or target.monitor_px)
    (folder / f"{view.label}.png").write_bytes(encoded(picture, ".png"))
    return {
        "view": view.label,
        "unit": found.unit,
        "pixels": {reason: count for reason, count in counts.items() if count},
        "median_sigma": [_median(found.sigma[..., axis]) for axis in (0, 1)],
        "noise_floor": found.noise.floor,
        "noise_slope": found.noise.slope,
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
    return f"{on_one_line(view['view'])}: {parts}; median sigma {sigma}"
