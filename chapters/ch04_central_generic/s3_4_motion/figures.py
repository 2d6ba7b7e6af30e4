"""Fig. 4.10: the motion of the stage, found again from rays."""

import numpy as np
from matplotlib.ticker import FixedFormatter

from chapters.ch04_central_generic.s3_4_motion.results import (
    DRAWN,
    MEASURES,
    METHODS,
    MIN_GAIN,
    NAMES,
    SCALE,
    ahead_at,
    trials_of,
)
from chapters.ch04_central_generic.s3_4_motion.trials.stage import (
    BOARDS,
    BORDER_MM,
    CENTRE_MM,
    STEP_DEG,
    STEP_MM,
    STEPS,
    Setup,
    board_poses,
    target_poses,
)
from chapters.shared.bench_noise import BENCH
from chapters.shared.noise_sweep import ALONG_THE_SWEEP
from chapters.shared.sweep_figure import RATIO, draw_sweep
from raxel.show import Labels, Points, Polyline, board, framed
from repro.judge.statistics import median_interval
from repro.page.method_looks import look_of
from repro.page.space import draw_scene
from repro.page.style import INK, series
from repro.page.style import figure as new_figure
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Check, Drawing

EXACT = 1e-9


def drawn_arrays(result, motion, method, name):
    """One array of the first rendered seed, by CELECT."""
    return result.arrays(f"{BENCH}.{motion}.{DRAWN}.{method}.{name}", seed=0)[0]


def path_of(shifts, across):
    """Places (steps + 1, 2) after each step, mm: along the mean, and aside.

    Along the mean step its differences are drawn SCALE times; aside all is as found.
    """
    mean = shifts.mean(axis=0)
    ahead = mean / np.linalg.norm(mean)
    off = shifts - mean
    steps = np.column_stack([(mean + SCALE * off) @ ahead, off @ across])
    return np.concatenate([np.zeros((1, 2)), np.cumsum(steps, axis=0)])


def widest(every):
    """The unit vector at right angles to the motion with most deviation."""
    off = np.concatenate([s - s.mean(axis=0) for s in every])
    mean = np.mean([s.mean(axis=0) for s in every], axis=0)
    ahead = mean / np.linalg.norm(mean)
    off = off - np.outer(off @ ahead, ahead)
    return np.linalg.svd(off)[2][0]


@figure("fig_4_10", needs=("fig_4_10_rendered",), evidence="rendered")
def fig_4_10(results):
    """(a) the translation, deviations times four; (b) the rotation."""
    result = results["fig_4_10_rendered"]
    drawn, (left, right) = new_figure(1, 2, height_in=3.8)
    shifts = {
        method: drawn_arrays(result, "translation", method, "shifts")
        for method in METHODS
    }
    across = widest(list(shifts.values()))
    rows, gaps = [], []
    stage = STEP_DEG * np.arange(STEPS["rotation"] + 1)
    for method in METHODS:
        path = path_of(shifts[method], across)
        left.plot(*path.T, label=NAMES[method], **look_of(NAMES[method]))
        turned = drawn_arrays(result, "rotation", method, "turned")
        off = np.concatenate([[0.0], turned]) - stage
        right.plot(stage, off, **look_of(NAMES[method]))
        rows += [("a", method, *place) for place in path]
        rows += [("b", method, *pair) for pair in zip(stage, off, strict=True)]
        beside = shifts[method] - shifts[method].mean(axis=0)
        judged = trials_of(result, "translation", "deviation_mm", method, DRAWN)[0]
        gaps.append(abs(np.sqrt(np.mean(np.sum(beside**2, axis=1))) - judged))
    for panel in (left, right):
        panel.axhline(0, color=INK, lw=0.8)
    left.set(
        xlabel=f"Along the mean step, deviations × {SCALE} (mm)",
        ylabel="Aside of the mean step (mm)",
        title="(a)",
    )
    left.set_xticks(STEP_MM * np.arange(STEPS["translation"] + 1))
    right.set(
        xlabel="Turn of the stage (deg)",
        ylabel="Turn found less that of the stage (deg)",
        title="(b)",
    )
    drawn.legend(loc="outside lower center", ncols=3)
    return Drawing(
        drawn,
        columns(("panel", "method", "x", "y"), rows),
        "Motion of the stage found from the rays of three calibrations at the "
        "bench's noise, of one seed of rendered pictures, corners by CELECT: (a) the "
        f"translation in steps of {STEP_MM:g} mm: how far it goes aside, in mm as "
        "found, and along the mean step, where its deviations are drawn "
        f"{SCALE} times as long; (b) the rotation, as its difference from "
        "that of the stage, after each step of 10°.",
        Check(
            bool(max(gaps) < EXACT),
            "the drawn steps have the deviations that the claims judge, to "
            f"{max(gaps):.0e} mm",
        ),
    )


@figure("ext_motion_seeds", needs=("fig_4_10_seeds",), evidence="rendered")
def motion_seeds(results):
    """Both errors of every seed, by method."""
    result = results["fig_4_10_seeds"]
    drawn, axes = new_figure(1, 2, height_in=3.2)
    labels = {
        "translation": "Deviation from the mean step (mm)",
        "rotation": "Total turn off 110° (deg)",
    }
    rows = []
    for panel, (motion, measure) in zip(axes, MEASURES.items(), strict=True):
        for index, method in enumerate(METHODS):
            trials = trials_of(result, motion, measure, method, DRAWN)
            look = look_of(NAMES[method])
            panel.plot(
                index + np.linspace(-0.25, 0.25, len(trials)), np.sort(trials),
                ls="", ms=3, marker=look["marker"], color=look["color"],
            )  # fmt: skip
            panel.plot(
                [index - 0.32, index + 0.32], [median_interval(trials).value] * 2,
                color=INK, lw=1.6, ls="-", marker="",
            )  # fmt: skip
            rows += [(motion, method, error) for error in trials]
        panel.set(yscale="log", ylabel=labels[motion], xticks=range(len(METHODS)))
        names = [NAMES[method].replace(", ", ",\n") for method in METHODS]
        panel.xaxis.set_major_formatter(FixedFormatter(names))
    return Drawing(
        drawn,
        columns(("motion", "method", "error"), rows),
        "Errors of the motion in every seed with redrawn corners (CELECT), at the "
        "bench's noise, in rising order, and their medians.",
    )


@figure(
    "ext_motion_target", needs=("fig_4_10_corners",), evidence="rendered", scene=True
)
def motion_target(results):
    """The target on its stage in space, and in three pictures."""
    pictures = [
        results["fig_4_10_corners"].arrays(name, motion="rotation")[0]
        for name in ("first", "middle", "last")
    ]
    drawn, axes = new_figure(1, 4, height_in=3.4, width_ratios=(2, 1, 1, 1))
    for panel, picture in zip(axes[1:], pictures, strict=True):
        panel.imshow(picture, cmap="gray", vmin=0, vmax=255)
        panel.set_axis_off()
    drawn.set_layout_engine("none")
    axes[0].set_position([0.0, 0.02, 0.5, 0.96])
    for k, panel in enumerate(axes[1:]):
        panel.set_position([0.52 + 0.16 * k, 0.05, 0.15, 0.9])
    scene = target_scene()
    draw_scene(axes[0], scene)
    rows = [(k, *T[:3, 3]) for k, T in enumerate(target_poses("rotation", STRAIGHT))]
    return Drawing(
        drawn,
        columns(("pose", "x_mm", "y_mm", "z_mm"), rows),
        "The target, two chessboards at right angles, before the mirror: in "
        "space, and in rendered pictures at the beginning, the middle and "
        "the end of the rotation.",
        scene=scene,
    )


STRAIGHT = Setup(np.eye(3), np.zeros(3))


def target_scene():
    """Boards in the middle of the turn, the stage's circle, the mirror's focus."""
    poses = target_poses("rotation", STRAIGHT)
    middle = poses[len(poses) // 2]
    parts = []
    for face, T in zip(BOARDS, board_poses(), strict=True):
        parts += board(face, middle @ T, BORDER_MM, label="target")
    # Where the fold of the boards goes while the stage turns.
    parts += [
        Polyline(poses[:, :3, 3], series(1)["color"], "path of the fold", 2.0),
        Points(CENTRE_MM[None], INK, "focus of the mirror", 12.0),
        Labels(CENTRE_MM[None] + [0, 0, 25], ["mirror"], INK),
    ]
    return framed(parts, (0.75, 0.35, -0.5), up=(0.0, 0.0, 1.0), aspect=1.2)


@figure("ext_noise_motion", needs=("fig_4_10_seeds",), evidence="rendered")
def ext_noise_motion(results):
    """The claims of this page along the sweep."""
    panels = {}
    for claim, motion in (
        ("c4_motion_trans", "translation"),
        ("c4_motion_rot", "rotation"),
    ):
        ratios = [
            ahead_at(results["fig_4_10_seeds"], {}, motion, noise).ratio.value
            for noise in ALONG_THE_SWEEP.values()
        ]
        panels[claim] = ratios, MIN_GAIN, RATIO
    return draw_sweep(
        panels,
        "Error of the motion with the standard method over that with CGSP, ratio of "
        "the medians, from half to twice the bench's noise.",
    )
