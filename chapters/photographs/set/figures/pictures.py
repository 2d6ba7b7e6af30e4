"""Figures of an image set: contact sheet and undistorted views."""

import textwrap

import numpy as np
from matplotlib.colors import to_rgb
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from chapters.shared.photographs.notes import EMPTY_IN, note
from chapters.shared.photographs.reading import BOARDS, MODELS, NAMES, Study
from repro.page.style import WIDTH_IN
from repro.page.style import figure as new_figure
from repro.page.wording import literal
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Drawing

NO_RAY = "#e4d9d2"
PATH = "#e69f00"
START = "#d55e00"


def tinted(mask):
    """Return RGBA (h, w, 4) that covers pixels without a ray (mask 255: ray)."""
    tint = np.ones((*mask.shape, 4))
    tint[..., :3] = to_rgb(NO_RAY)
    tint[..., 3] = 1 - mask / 255
    return tint


@figure(
    "ext_corners", needs=("photograph_study",), evidence="photograph", per_set=BOARDS
)
def ext_corners(results):
    """Draw every image with its corners; rejected ones pale, with the reason."""
    study = Study(results["photograph_study"])
    images = study.images
    across = min(max(int(np.ceil(np.sqrt(1.4 * len(images)))), 3), 10)
    rows = max(1, int(np.ceil(len(images) / across)))
    shape = study.settings["height_px"] / study.settings["width_px"]
    height = rows * (WIDTH_IN / across * shape + 0.17) + 0.4
    drawn, grid = new_figure(rows, across, height_in=height, squeeze=False)
    drawn.get_layout_engine().set(w_pad=0.03, h_pad=0.02, wspace=0, hspace=0)
    for axes in grid.ravel():
        axes.set_axis_off()
    size = 7.5 if across <= 5 else 5.5
    # A letter is about 0.6 of the font size wide, with 72 points per inch.
    characters = int(0.9 * WIDTH_IN / across * 72 / (0.6 * size))
    for axes, image in zip(grid.ravel(), images, strict=False):
        _one_photograph(axes, image, study.settings["width_px"], size, characters)
    drawn.legend(handles=_corner_legend(study), loc="outside lower center", ncols=4)
    return Drawing(
        drawn,
        _corner_data(study.found),
        "Images of the set with the detected corners, connected row by row: "
        f"{len(study.found)} of {len(images)} images.",
    )


def _one_photograph(axes, image, width_px, size, characters):
    height, width = image.thumbnail.shape
    axes.imshow(
        image.thumbnail,
        cmap="gray",
        vmin=0,
        vmax=255,
        alpha=1.0 if image.found else 0.3,
        interpolation="none",
    )
    use = "" if image.use == "calibrate" else " (evaluation)"
    axes.set_title(
        image.name + use, fontsize=size, fontweight="normal", pad=2, parse_math=False
    )
    if not image.found:
        axes.text(
            width / 2,
            height / 2,
            textwrap.fill(image.reason, characters),
            ha="center",
            va="center",
            fontsize=size,
            parse_math=False,
            bbox={"facecolor": "white", "alpha": 0.7, "edgecolor": "none"},
        )
        return
    scale = width / width_px
    lattice = (image.corners + 0.5) * scale - 0.5
    lattice = lattice.reshape(-1, image.columns, 2)
    # A gap after each row separates its line from the next.
    rows = np.pad(lattice, ((0, 0), (0, 1), (0, 0)), constant_values=np.nan).reshape(
        -1, 2
    )
    axes.plot(*rows.T, ".-", color=PATH, linewidth=0.8, markersize=2)
    axes.plot(*lattice[:, 0].T, "o", color=START, markersize=2.4)
    axes.plot(*lattice[0, 0], "s", color="white", mec=START, mew=1.2, markersize=5)


def _corner_legend(study):
    handles = [
        Line2D([], [], color=PATH, marker=".", linewidth=1, label="row of corners"),
        Line2D([], [], color=START, marker="o", linestyle="", label="row starts"),
        Line2D(
            [], [], color="white", mec=START, marker="s", linestyle="",
            label="first corner",
        ),
    ]  # fmt: skip
    if len(study.found) < len(study.images):
        handles.append(Patch(color="#d9d9d9", label="pale: no board detected"))
    return handles


def _corner_data(images):
    rows = [
        (image.name, k, *divmod(k, image.columns), *corner)
        for image in images
        for k, corner in enumerate(image.corners.tolist())
    ]
    return columns(("image", "corner", "row", "column", "u_px", "v_px"), rows)


@figure(
    "ext_undistorted",
    needs=("photograph_study",),
    evidence="photograph",
    per_set=BOARDS,
)
def ext_undistorted(results):
    """Draw one image as taken, and undistorted by either model."""
    study = Study(results["photograph_study"])
    view = study.number("undistorted.view", part="fit")
    if not np.isfinite(view):
        drawn, axes = new_figure(height_in=EMPTY_IN)
        note(axes, study.refusal("zhang"))
        return Drawing(drawn, {}, "Undistorted image: no camera.")
    shape = study.settings["height_px"] / study.settings["width_px"]
    drawn, axes = new_figure(1, 3, height_in=WIDTH_IN / 3 * shape + 0.75)
    image = study.image(int(view))
    original = study.array("undistorted.original", part="fit")
    corners = study.array("undistorted.corners", part="fit")
    scale = original.shape[1] / study.settings["width_px"]
    _picture(axes[0], original, None)
    _frame_lines(axes[0], (corners + 0.5) * scale - 0.5, image.columns)
    axes[0].set_title("As taken")
    rows = _numbered("as taken", corners)
    for place, model in zip(axes[1:], MODELS, strict=True):
        place.set_title(NAMES[model])
        picture = study.array(f"undistorted.{model}.picture", part="fit")
        if picture is None:
            _picture(place, np.full_like(original, 255), None)
            reason = study.text(f"undistorted.{model}.reason", part="fit")
            note(place, study.refusal(model) or reason, 26)
            continue
        _picture(place, picture, study.array(f"undistorted.{model}.mask", part="fit"))
        seen = study.array(f"undistorted.{model}.corners", part="fit")
        _frame_lines(place, seen, image.columns)
        rows += _numbered(NAMES[model], seen)
    drawn.legend(
        handles=[
            Patch(color=NO_RAY, label="no ray, or outside the image"),
            Line2D(
                [], [], color=START, linewidth=1, label="chords of the board's outline"
            ),
        ],
        loc="outside lower center",
        ncols=2,
    )
    towards = study.text("undistorted.towards", part="fit")
    centre = "mid-image" if towards == "mid-image" else "the middle of the board"
    zoom = study.number("undistorted.zoom", part="fit")
    return Drawing(
        drawn,
        columns(("panel", "corner", "x_px", "y_px"), rows),
        f"{literal(image.name)}, as taken and undistorted, in a view towards {centre} "
        f"at {100 * zoom:.0f} % of the original scale there. Straight edges of the "
        "scene must be straight.",
    )


def _picture(axes, picture, mask):
    axes.set_axis_off()
    axes.imshow(picture, cmap="gray", vmin=0, vmax=255, interpolation="none")
    if mask is not None:
        axes.imshow(tinted(mask), interpolation="none")


def _frame_lines(axes, corners, columns):
    """Draw straight chords between the outermost corners of the board."""
    outer = corners[[0, columns - 1, len(corners) - 1, len(corners) - columns, 0]]
    height, width = axes.images[0].get_array().shape[:2]
    axes.plot(*outer.T, "-", color=START, linewidth=0.8)
    axes.set(xlim=(-0.5, width - 0.5), ylim=(height - 0.5, -0.5))


def _numbered(panel, corners):
    """Return rows of a panel's corners for the figure's data."""
    return [(panel, k, *corner) for k, corner in enumerate(corners.tolist())]
