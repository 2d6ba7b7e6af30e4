"""The film and its still, the mirror at three deflections in space, and the drift."""

import numpy as np

from chapters.ch05_flexible_mirror.ext_film.results import (
    FILM,
    SEEDS,
    UM,
    WAYS,
    Frames,
    courses,
)
from chapters.ch05_flexible_mirror.ext_film.trials.follow import KEPT
from chapters.ch05_flexible_mirror.ext_film.trials.space import SILVER, FilmView
from chapters.shared.mirror_rigs import mirror_rig
from repro.judge.statistics import median_interval
from repro.page.film import pictured
from repro.page.space import draw_scene, scene_figure, scene_frames
from repro.page.style import INK, legend_below, plot_estimates, series
from repro.page.style import figure as new_figure
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Drawing, Film, Panel

TRUE, FOUND, CORNER = INK, series(1)["color"], "#00b3ff"
LATER = {"color": "#c8ccd2", "lw": 1.2, "marker": ""}
# Of the film's own pictures: inches and dots per inch; pixels of the one in space.
FRAME_IN, FRAME_DPI, SPACE_PX = (4.2, 3.0), 92, (480, 344)
NOTE = (
    "Viewing rays run from the camera to the mirror as it was found, scene rays from "
    "there to the board."
)


@figure("ext_mirror_film", needs=("ext_mirror_film_pictures",), evidence="rendered",
        scene=True)  # fmt: skip
def film_figure(results):
    """All that the film shows: its middle as a still, and all of it to be played."""
    rig, frames = mirror_rig("A", small=True), Frames.of(results[FILM])
    view = FilmView(rig, frames)
    still = frames.peak
    drawn, axes = new_figure(2, 2, height_in=6.0)
    draw_picture(axes[0, 1], frames, still)
    draw_profile(axes[1, 0], frames, still)
    draw_error(axes[1, 1], frames, still)
    for panel, letter in zip(axes.flat, "abcd", strict=True):
        panel.set_title(f"({letter})")
    draw_scene(axes[0, 0], view.scene(still))
    return Drawing(
        drawn,
        columns(
            ("frame", "true_mm", "found_mm", "angle_deg", "residual_mm", "corners"),
            [
                (k, *row)
                for k, row in enumerate(
                    zip(frames.true_mm, frames.found_mm, frames.angle_deg,
                        frames.residual_mm, frames.used, strict=True)
                )
            ],
        ),
        "A mirror bends, and its calibration follows from picture to picture: here "
        f"the frame of {frames.true_mm[still]:g} mm. (a) In space: camera, mirror as "
        "it was found, rays (grey, then blue), and what the mirror shows of the "
        "board's plane (orange). (b) What the camera sees in the mirror, with the "
        "corners that were tracked. (c) The profile of the mirror's middle line, true "
        "and found. (d) What was found of the deflection, less what it is, over the "
        "film.",
        scene=film_of(frames, view),
    )  # fmt: skip


def film_of(frames, view):
    """The Film of all frames."""
    count = range(len(frames.true_mm))
    ways = (
        (draw_picture, "What the camera sees", "A board in the mirror, its corners "
         "marked where they were tracked."),
        (draw_profile, "Profile of the mirror", "Height of the mirror's middle line "
         "over the flat sheet, true and found."),
        (draw_error, "Error of the deflection", "Found minus true deflection over the "
         "film, up to the frame that is shown."),
    )  # fmt: skip
    panels = [
        Panel("In space", "Camera, bending mirror, rays and board; an orange outline "
              "on the board, what the mirror shows of it, widens and narrows.",
              scene_frames([view.scene(k) for k in count], SPACE_PX))
    ]  # fmt: skip
    panels += [
        Panel(title, says, [_alone(draw, frames, k) for k in count])
        for draw, title, says in ways
    ]
    labels = [
        f"Frame {k + 1} of {len(count)}: deflection {frames.true_mm[k]:.2f} mm, found "
        f"{_plain(frames.found_mm[k])} mm; {int(frames.used[k])} corners, rays off by "
        f"{frames.angle_deg[k]:.3f} degrees"
        for k in count
    ]
    return Film(panels, labels)


def _plain(mm):
    """A length to a hundredth of a mm, without a minus before zero."""
    return f"{round(float(mm), 2) + 0:.2f}"


def _alone(draw, frames, k):
    drawn, axes = new_figure(height_in=FRAME_IN[1])
    drawn.set_size_inches(*FRAME_IN)
    draw(axes, frames, k)
    return pictured(drawn, FRAME_DPI)


def draw_picture(axes, frames, k):
    """The camera's picture with the corners of frame k."""
    axes.imshow(frames.picture[k], cmap="gray", vmin=0, vmax=255)
    # Pixel centres at whole numbers, in the kept picture as in the camera's.
    places = KEPT * (frames.corners[k] + 0.5) - 0.5
    axes.plot(*places.T, "o", mfc="none", mec=CORNER, ms=4, mew=1.0)
    axes.set_axis_off()


def draw_profile(axes, frames, k):
    """Height of the middle line, true and found, in frame k."""
    sheet = mirror_rig("A", small=True).camera(float(frames.true_mm[k])).mirror
    flat = np.linspace(0, sheet.end, 81)
    axes.plot(
        flat, sheet.height(flat, 0 * flat)[0], color=TRUE, marker="", label="true"
    )
    axes.plot(*frames.profile[k].T, ".", color=FOUND, ms=5, label="found")
    top = 1.15 * np.nanmax(frames.profile[..., 1])
    axes.set(xlim=(0, 1.03 * sheet.end), ylim=(-0.05 * top, top))
    axes.set(xlabel="Along the flat sheet (mm)", ylabel="Height (mm)")
    axes.legend(loc="upper left")


def draw_error(axes, frames, k):
    """Error of the deflection up to frame k; what is to come is pale."""
    time = np.arange(len(frames.true_mm)) + 1
    axes.axhline(0, color=TRUE, lw=0.8, marker="")
    axes.plot(time, frames.error_um, **LATER)
    axes.plot(time[: k + 1], frames.error_um[: k + 1], ".-", color=FOUND, lw=1.4)
    axes.plot(time[k], frames.error_um[k], "o", color=FOUND, ms=7)
    axes.set(xlabel="Frame (1)", ylabel="Found less true (µm)")


@figure("ext_mirror_film_space", needs=("ext_mirror_film_pictures",),
        evidence="rendered", scene=True)  # fmt: skip
def space_figure(results):
    """The mirror at three deflections in one space, as it was found."""
    rig, frames = mirror_rig("A", small=True), Frames.of(results[FILM])
    half = frames.peak // 2
    chosen = (0, half, frames.peak)
    scene = FilmView(rig, frames).together(
        chosen, [SILVER, series(2)["color"], series(1)["color"]], NOTE
    )
    return Drawing(
        scene_figure(scene, height_in=4.8),
        columns(("frame", "true_mm"), [(k, frames.true_mm[k]) for k in chosen]),
        "The mirror as it was found at three deflections, "
        f"{', '.join(f'{frames.true_mm[k]:g}' for k in chosen)} mm, and what it shows "
        "of the board's plane: the outlines on it are the mirror's own edges, seen by "
        "their rays. In the 3-D scene each deflection can be hidden.",
        scene=scene,
    )


@figure("ext_mirror_film_drift", needs=("ext_mirror_film_seeds",),
        evidence="synthetic")  # fmt: skip
def drift_figure(results):
    """Deflection and rays over the film, tracked and stage by stage."""
    result, rows = results[SEEDS], []
    drawn, axes = new_figure(1, 2, height_in=3.6, sharex=True)
    for shift, (way, label) in enumerate(WAYS.items()):
        true = courses(result, way, "true_mm")
        if not len(true):
            continue
        measured = (
            UM * np.abs(courses(result, way, "found_mm") - true),
            courses(result, way, "angle_deg"),
        )
        for panel, values in zip(axes, measured, strict=True):
            found = [median_interval(of_frame) for of_frame in values.T]
            rows += plot_estimates(
                panel, np.arange(values.shape[1]) + 1 + 0.15 * shift, found,
                (way, panel.get_label()), look=series(shift), label=label, bars=True,
            )  # fmt: skip
    axes[0].set_ylabel("Error of the deflection (µm)")
    axes[1].set_ylabel("Mean ray angle (degrees)")
    for panel in axes:
        panel.set_xlabel("Frame (1)")
        panel.set_ylim(bottom=0)
    legend_below(drawn, axes[0], ncols=2)
    return Drawing(
        drawn,
        columns(("way", "what", "frame", "median", "low", "high"), rows),
        "Error over the film, there and back, when each picture is fitted for itself "
        "and when each is calibrated from the one before: medians over "
        f"{result.trials_per_condition} seeds with 95 % intervals, corners with "
        "0.05 px of noise in a picture of 768 x 576, no picture rendered.",
    )
