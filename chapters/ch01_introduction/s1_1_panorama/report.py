"""Results of this page read: values of the prose, figures, tables, judgements."""

from chapters.ch01_introduction.s1_1_panorama.experiment import (
    MIN_RATIO,
    RIG_MIRROR,
    RIG_NAMES,
    RIG_SEED,
)
from chapters.shared.rigs import rig_named
from raxel.show import rig_scene
from repro.page import new_figure, value
from repro.page.space import draw_scene
from repro.run import Check, Drawing, Reading, claim, columns, figure

# Values that the page of section 1.1.2 quotes.


def name_values(open_results):
    """Name the values that the page quotes."""
    rows = open_results("fig_1_1_resolution")
    value("ratio", rows.column("ratio", mirror=RIG_MIRROR).max())
    value("band", rows.select().column("band_deg").min())


# Fig. 1.1, and an overview of the simulated rigs.


EXACT_PX = 1e-6
STRAIGHT_PX = 0.5
BORDER_COLUMNS = ("edge_column_px", "found_column_px", "deviation_px", "rows_found")
RIG_ROWS, RIG_COLUMNS = 6, 5


@figure("fig_1_1", needs=("fig_1_1_picture",), evidence="rendered")
def fig_1_1(results):
    """Draw (a) the image in the mirror and (b) its cylindrical projection."""
    ran = results["fig_1_1_picture"]
    recorded, unwrapped, borders = (
        ran.arrays(name)[0] for name in ("picture", "unwrapped", "borders")
    )
    drawn, axes = new_figure(2, 1, height_in=7.4, height_ratios=(4.4, 2.9))
    titles = ("(a) image in the mirror", "(b) unwrapped on a cylinder")
    for panel, image, title in zip(axes, (recorded, unwrapped), titles, strict=True):
        panel.imshow(image, interpolation="antialiased")
        panel.set(title=title, xlabel="u (px)", ylabel="v (px)")
        panel.grid(False)
    row, spread = ran.column(("horizon_error_px", "spread_px")).max(axis=1)
    off = borders[:, 2].max()
    exact = max(row, spread) < EXACT_PX
    return Drawing(
        drawn,
        dict(zip(BORDER_COLUMNS, borders.T, strict=True)),
        "A room in a hyperboloidal mirror. (a) Image of the camera below the "
        "mirror; the forward direction is at the top. (b) Cylindrical projection "
        "of the same image about the mirror's focus; the forward direction is in "
        "the middle.",
        Check(
            bool(exact and off < STRAIGHT_PX),
            "projected into (a) and unwrapped, each upright edge of the room is in "
            f"one column to {spread:.0e} px and the horizon in one row to "
            f"{row:.0e} px; the {len(borders)} upright borders detected in (b) "
            f"deviate from a column by at most {off:.2f} px (median)",
        ),
    )


@figure("ext_rigs", needs=("ext_rigs",), evidence="analytic")
def ext_rigs(results):
    """Draw every rig of data/rigs in three dimensions."""
    ran = results["ext_rigs"]
    drawn, axes = new_figure(RIG_ROWS, RIG_COLUMNS, height_in=7.0)
    drawn.get_layout_engine().set(w_pad=0.02, h_pad=0.02, wspace=0.0, hspace=0.0)
    rows = []
    for panel in axes.flat:
        panel.set_axis_off()
    panels = dict(zip(RIG_NAMES, axes.flat, strict=False))
    for name, panel in panels.items():
        panel.set_title(name, fontsize=6.5, pad=2)
    drawn.get_layout_engine().execute(drawn)
    drawn.set_layout_engine("none")  # all panels are placed
    for name, panel in panels.items():
        one = ran.one(rig=name)
        poses = one.arrays("T_camera_target")[0]
        width, height = one.column(("width_px", "height_px"))[:, 0].astype(int).tolist()
        draw_scene(panel, rig_scene(rig_named(name), RIG_SEED, poses), words=False)
        rows.append((name, one.texts("kind")[0], width, height, len(poses)))
    return Drawing(
        drawn,
        columns(("rig", "camera", "width_px", "height_px", "poses"), rows),
        "Cameras, mirrors and targets of the simulated rigs, in the camera frame (z "
        "forward, y down). Blue: rays at the edge of the field of view, truncated at "
        "one length. Orange outlines: targets for evaluation.",
    )


# The claim of section 1.1.2, tested as registered.


@claim("c1_unwrap_resolution", needs=("fig_1_1_resolution",), evidence="analytic")
def judge_unwrap_resolution(results):
    """Source pixels in the top and the bottom row differ by a factor above 1.5."""
    ran = results["fig_1_1_resolution"]

    names = ("ratio", "top", "bottom", "ratio_row", "ratio_column")
    ratio, top, bottom, along_row, along_column = (
        float(found) for found in ran.column(names, mirror=RIG_MIRROR).max(axis=1)
    )
    larger = max(ratio, 1 / ratio)
    smallest = ran.select().column("ratio").min()
    return Reading.of(
        larger > MIN_RATIO,
        larger,
        unit="1",
        reason="area of the source image per unwrapped pixel, top row to "
        f"bottom row: {top:.2f} to {bottom:.3f} px²; "
        f"{along_row:.1f} along the row, "
        f"{along_column:.1f} along the column; "
        f"{smallest:.0f} or more with all mirrors tried",
    )
