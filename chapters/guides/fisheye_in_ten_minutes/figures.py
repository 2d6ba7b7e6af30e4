"""Pictures of a calibration: corners, coverage, residuals, and what is corrected."""

import numpy as np
from matplotlib.colors import ListedColormap

from chapters.guides.fisheye_in_ten_minutes.results import (
    CAMERA,
    DRAWN,
    FOUND,
    GOAL,
    VIEWS,
    corner_file,
    shares,
)
from chapters.guides.fisheye_in_ten_minutes.trials.boards import SIZES
from chapters.guides.fisheye_in_ten_minutes.trials.commands import ASIDE_DEG
from chapters.guides.fisheye_in_ten_minutes.trials.models import ANYWHERE, PLANNED, lit
from repro.page.style import INK, plot_interval, series
from repro.page.style import figure as new_figure
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Drawing

PICTURES = "ext_fisheye_pictures"
PATH = "#e69f00"
KEPT_OUT = "#56b4e9"
COLUMNS = 5
THUMBNAIL_PX = 300
# 0, 1, 2, 3, 4 boards and more.
COUNTS = ("#e4d9d2", "#c6dbef", "#6baed6", "#2171b5", "#08306b")
ARROW_SHARE = 0.06  # of the picture's width, for the 95th percentile


@figure("ext_fisheye_views", needs=("ext_fisheye_look",), evidence="rendered")
def ext_fisheye_views(results):
    """A street as taken, straightened, and as seen by a pinhole aimed aside."""
    look = results[VIEWS]
    panels = {
        "As taken": look.arrays("street")[0],
        "Straight ahead": look.arrays("views.ahead")[0],
        f"Aimed {ASIDE_DEG:.0f}° to the right": look.arrays("views.aside")[0],
    }
    drawn, axes = new_figure(1, 3, height_in=2.1)
    for place, (title, picture) in zip(axes, panels.items(), strict=True):
        place.imshow(picture, cmap="gray", vmin=0, vmax=255)
        place.set_title(title)
        place.set_axis_off()
    lit_share = [float(np.mean(picture > 0)) for picture in panels.values()]
    return Drawing(
        drawn,
        {"panel": list(panels), "share of pixels not black": lit_share},
        "A street through the rendered 183° lens, and the same picture as "
        "two pinholes at the lens's place would have taken it: remapped with "
        "the calibrated camera. Straight edges are straight; black has no ray.",
    )


@figure(
    "ext_fisheye_corners",
    needs=("ext_fisheye_pictures", "ext_fisheye_found"),
    evidence="rendered",
)
def ext_fisheye_corners(results):
    """Every picture with the corners that were found."""
    import cv2

    pictures, images = results[PICTURES], corner_file(results[FOUND])
    kept_out = len(images) - SIZES[pictures.effort].kept_out
    rows = -(-len(images) // COLUMNS)
    drawn, grid = new_figure(rows, COLUMNS, height_in=1.08 * rows)
    drawn.get_layout_engine().set(w_pad=0.02, h_pad=0.02, wspace=0, hspace=0)
    cells = []
    for axes in grid.ravel():
        axes.set_axis_off()
    for view, (axes, image) in enumerate(zip(grid.ravel(), images, strict=False)):
        png = pictures.arrays("png", view=view)[0]
        picture = cv2.imdecode(png, cv2.IMREAD_GRAYSCALE)
        height, width = picture.shape
        small = cv2.resize(
            picture,
            (THUMBNAIL_PX, THUMBNAIL_PX * height // width),
            interpolation=cv2.INTER_AREA,
        )
        axes.imshow(
            small,
            cmap="gray",
            vmin=0,
            vmax=255,
            extent=(-0.5, width - 0.5, height - 0.5, -0.5),
        )
        if not image["found"]:
            continue
        corners = np.array(image["corners"], float)
        axes.plot(
            *corners.T,
            ".",
            markersize=0.35,
            color=PATH if view < kept_out else KEPT_OUT,
        )
        cells += [(image["file"], k, *c) for k, c in enumerate(corners.tolist())]
    return Drawing(
        drawn,
        columns(("picture", "corner", "u_px", "v_px"), cells),
        "All pictures with their corners, in the order taken: one in the "
        "middle, a ring half way out, a ring at the rim. Blue corners: "
        "pictures kept out, at such places again.",
    )


@figure("ext_fisheye_residuals", needs=("ext_fisheye_camera",), evidence="rendered")
def ext_fisheye_residuals(results):
    """What the boards cover, and what is left at the corners kept out."""
    camera = results[CAMERA]
    counts = np.minimum(camera.arrays("counts")[0], len(COUNTS) - 1)
    height, width = counts.shape
    drawn, axes = new_figure(1, 2, height_in=3.2, sharey=True)
    shown = np.where(lit(SIZES[camera.effort]), counts, np.nan)
    image = axes[0].imshow(
        shown, cmap=ListedColormap(COUNTS), vmin=-0.5, vmax=len(COUNTS) - 0.5
    )
    axes[0].set_title("Boards over each pixel")
    bar = drawn.colorbar(
        image, ax=axes[0], location="bottom", shrink=0.8, ticks=range(5)
    )
    bar.set_ticklabels(["0", "1", "2", "3", "4 +"])
    bar.set_label("Boards (1)")
    use = camera.arrays("kept_out")[0]
    pixels = camera.arrays("pixels")[0][use]
    off = camera.arrays("residuals")[0][use]
    lengths = np.linalg.norm(off, axis=1)
    known = np.isfinite(lengths)
    long = float(np.percentile(lengths[known], 95))
    arrows = axes[1].quiver(
        *pixels[known].T,
        *off[known].T,
        lengths[known],
        cmap="cividis_r",
        angles="xy",
        scale_units="xy",
        scale=long / (ARROW_SHARE * width),
        width=0.003,
    )
    axes[1].set_title("Residuals of boards kept out")
    bar = drawn.colorbar(arrows, ax=axes[1], location="bottom", shrink=0.8)
    bar.set_label("Length (px)")
    axes[1].set_aspect("equal")
    for place in axes:
        place.grid(False)
        place.set(xlim=(-0.5, width - 0.5), ylim=(height - 0.5, -0.5), xlabel="u (px)")
    axes[0].set_ylabel("v (px)")
    return Drawing(
        drawn,
        columns(("u_px", "v_px", "du_px", "dv_px"), np.hstack([pixels, off]).tolist()),
        "Left: how many boards cover each pixel of the image circle. Right: "
        "residuals at corners of boards that the calibration never saw, "
        f"found less predicted. An arrow of {ARROW_SHARE * width:.0f} px on "
        f"the axes is {long:.2g} px. Where these boards are, they point all "
        "ways: what is left is the noise of the corners. Where there are none, "
        "nothing is checked.",
    )


@figure("ext_fisheye_coverage", needs=("ext_fisheye_draws",), evidence="synthetic")
def ext_fisheye_coverage(results):
    """Coverage of the image circle against the number of pictures."""
    drawn_sets = results[DRAWN]
    drawn, axes = new_figure(height_in=3.2)
    rows = []
    for index, held in enumerate((PLANNED, ANYWHERE)):
        percent = 100 * shares(drawn_sets, held)
        count = np.arange(1, percent.shape[1] + 1)
        middle = np.median(percent, axis=0)
        low, high = percent.min(axis=0), percent.max(axis=0)
        plot_interval(
            axes, count, middle, low, high, look=series(index),
            label=f"held {held}: median and range",
        )  # fmt: skip
        rows += [(held, *cells) for cells in zip(count, middle, low, high, strict=True)]
    axes.axhline(100 * GOAL, color=INK, linewidth=0.8, linestyle=":")
    axes.set(ylim=(0, 100), xlabel="Pictures (1)")
    axes.set_ylabel("Image circle under boards (%)")
    axes.legend(loc="lower right")
    return Drawing(
        drawn,
        columns(("held", "pictures", "median", "least", "most"), rows),
        "How much of the image circle the boards cover after so many pictures, "
        f"over {drawn_sets.trials_per_condition} draws: held by the plan of "
        "this page, give or take what a hand misses, and held anywhere in "
        f"view. Dotted: {100 * GOAL:.0f} %.",
    )
