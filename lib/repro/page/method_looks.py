"""One colour and marker per method in the whole report.

A method is identified by its name in the legend, `look_of("CGSP")`. Names of the same
method have the same look in all figures. With an adjustment or a refinement after it,
the colour and the marker remain, and the marker is hollow. Other series (noise levels,
readings, rigs) use `repro.page.style.series`.

No two methods of the report share both colour and marker. `check_looks` rejects a
figure whose legend names a method that is drawn in another look.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.figure import Figure

BLUE, VERMILLION, GREEN, PINK = "#0072b2", "#d55e00", "#009e73", "#c76ea3"
SKY, ORANGE, GREY = "#56b4e9", "#e69f00", "#4a4a4a"
WINE, OLIVE, TEAL, BROWN, INDIGO = "#882255", "#999933", "#44aa99", "#8c5a2b", "#332288"

SOLID, DASHED, DASH_DOT, DOTTED = "-", "--", "-.", ":"
LONG, MIXED, SPARSE = (0, (7, 2)), (0, (3, 1, 1, 1, 1, 1)), (0, (1, 3))
HOLLOW = {"markerfacecolor": "white", "linestyle": (0, (4, 1.5))}
"""Changes of the look for a second curve of a method: neither colour nor marker."""

# (colour, marker, line style) -> the names of the method.
_CALIBRATIONS = {
    (BLUE, "o", SOLID): (
        "parametric",
        "standard perspective",
        "pinhole, two radial terms",
        "Zhang",
    ),
    (VERMILLION, "s", DASHED): (
        "central generic, as printed",
        "standard, as printed",
        "standard + RANSAC",
    ),
    (GREEN, "^", DASH_DOT): (
        "central generic, well conditioned",
        "standard, well conditioned",
        "no vanishing divisors",
        "General camera",
    ),
    (PINK, "D", DOTTED): (
        "CGSP",
        "CGSP's linear stage",
        "Sturm-Maybank",
        "table of rays",
    ),
    (WINE, "d", SOLID): ("CGSP + RANSAC", "CGSP with RANSAC"),
    (OLIVE, "p", MIXED): ("CGSP, weighted",),
    (INDIGO, "h", LONG): ("circles",),
    (ORANGE, "v", LONG): ("three points + RANSAC",),
    (SKY, "v", LONG): ("OpenCV fisheye",),
    (INDIGO, "<", MIXED): ("Kannala-Brandt",),
    (TEAL, ">", DASHED): ("Kannala-Brandt, pupil by test",),
    (WINE, "P", MIXED): ("unified sphere", "Unified sphere"),
    (BROWN, "h", DASHED): ("radial law alone",),
    (OLIVE, "*", SOLID): ("Smooth rays", "smooth table"),
    (BROWN, "<", DASH_DOT): ("line fitting", "scheme 3: line fitting"),
    (SKY, "8", LONG): ("ray-point distances", "scheme 1, centre set free"),
    (GREY, "X", SPARSE): ("exact rays",),
}
_DETECTORS = {
    (BLUE, "h", SOLID): ("CELECT",),
    (SKY, "h", DASH_DOT): ("CELECT, tone curve undone",),
    (VERMILLION, "<", DASHED): ("findChessboardCorners",),
    (ORANGE, ">", LONG): ("findChessboardCornersSB",),
    (GREEN, "d", DOTTED): ("without clicks (ours)",),
}
_LOCALISERS = {
    (GREEN, "v", DASH_DOT): ("saddle point", "saddle point, 19 px"),
    (INDIGO, "^", SOLID): ("derivative", "derivative, 19 px"),
    (PINK, "o", DOTTED): (
        "active grid",
        "active grid, 7 × 7 filter",
        "decoding, 7 × 7 filter",
    ),
    (WINE, "o", DASHED): ("active grid, no filter", "decoding, no filter"),
    (VERMILLION, "8", DASHED): ("OpenCV", "OpenCV, 9 × 9 px"),
    (ORANGE, "8", LONG): ("OpenCV, half window of 9",),
    (GREY, "", DOTTED): ("true corners",),
}
# Chapter 5: the flexible mirror.
_MIRRORS = {
    (BLUE, "P", SOLID): ("reduced model",),
    (VERMILLION, "X", DASHED): ("full model",),
    (GREEN, "p", DASH_DOT): ("distance spline",),
    (PINK, "v", DOTTED): ("inverse-depth spline",),
    (SKY, "*", LONG): ("simulated mirror",),
    (GREY, "*", SPARSE): ("true mirror",),
}
GROUPS = (_CALIBRATIONS, _DETECTORS, _LOCALISERS, _MIRRORS)
LOOKS = {
    name: dict(zip(("color", "marker", "linestyle"), look, strict=True))
    for group in GROUPS
    for look, names in group.items()
    for name in names
}
"""Name of a method -> colour, marker and line style, keyword arguments of ``plot``."""

_ADJUSTED = {
    "CGSP, adjusted with the centre": "CGSP",
    "consistent": "CGSP",
    "consistent adjustment": "CGSP",
    "CGSP + RANSAC, angles refined": "CGSP + RANSAC",
    "adjusted directly": "Smooth rays",
}
LOOKS |= {name: LOOKS[of] | HOLLOW for name, of in _ADJUSTED.items()}


class LookError(ValueError):
    """A method without a look, or drawn in another look; the message names it."""


def look_of(name: str, *, hollow: bool = False) -> dict:
    """Return colour, marker and line style of a method, as keyword arguments of
    ``plot``.

    hollow: for the second curve of a method in one figure, such as after adjustment.
    """
    if name not in LOOKS:
        raise LookError(
            f"{name!r}: not in repro.page.method_looks; add its look there, or use "
            "series() for what is not a method"
        )
    return LOOKS[name] | (HOLLOW if hollow else {})


def named_in(label: str) -> str | None:
    """The method with which a legend entry begins, the longest match."""
    fitting = [
        name
        for name in LOOKS
        if label.startswith(name) and not label[len(name) : len(name) + 1].isalnum()
    ]
    return max(fitting, key=len, default=None)


def check_looks(drawn: Figure, stem: str) -> None:
    """Raise `LookError` if a legend entry names a method and has another look."""
    from matplotlib.colors import same_color

    for axes in drawn.axes:
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
            line = handle[0] if isinstance(handle, tuple) else handle
            name = named_in(label)
            if name is None or not hasattr(line, "get_marker"):
                continue
            look, colour, marker = LOOKS[name], line.get_color(), line.get_marker()
            # A line across the whole panel has only a colour.
            plain = marker in ("None", "none", "", " ", None)
            same_marker = plain or marker == look["marker"]
            if same_marker and same_color(colour, look["color"]):
                continue
            raise LookError(
                f"{stem}: {label!r} is drawn with {colour} and {marker!r}; "
                f"{name!r} has {look['color']} and {look['marker']!r} in the whole "
                "report, see repro.page.method_looks"
            )
