"""Results of this page read: values of the prose, figures, tables, judgements."""

from itertools import product

import numpy as np

from chapters.ch04_central_generic.s3_4_motion.experiment import (
    DETECTORS,
    METHODS,
    STEP_DEG,
    STEP_MM,
    STEPS,
)
from chapters.shared.central import LEVEL_NAMES, MATCHED, OPTIONS, over_the_sweep
from chapters.shared.methods import LINEAR_NAMES
from repro.page import INK, look_of, new_figure, value
from repro.run import (
    Case,
    Check,
    Drawing,
    Measured,
    Reading,
    Table,
    Value,
    claim,
    columns,
    figure,
    numbers,
    table,
    wins,
    with_worst,
)

# Motions of section 4.3.2 by method and detector, and the numbers of the text.


# Methods of the trials -> words.
NAMES = dict(zip(METHODS, LINEAR_NAMES.values(), strict=True))
MEASURES = {"translation": "deviation_mm", "rotation": "off_deg"}
SCALE = 4  # of the deviations in the drawing
QUESTIONS = {
    "decoding_noise": OPTIONS,
    "standard_method": {name: name for name in METHODS[:2]},
    "motion_corners": {name: name for name in DETECTORS},
}


def trials_of(result, motion, method, detector="CELECT", noise=MATCHED):
    """Return a motion's measure by one or more methods, (..., trials)."""
    trials = result.select()
    return trials.column(noise, motion, detector, method, MEASURES[motion])


def name_values(open_results):
    """Name the numbers that the text quotes: medians over the redrawn runs."""
    runs = open_results("fig_4_10_seeds")
    for method, short in (("as printed", "printed"), ("CGSP", "cgsp")):
        for name, motion, noise in (
            ("translation", "translation", MATCHED),
            ("rotation", "rotation", MATCHED),
            ("lab_translation", "translation", "laboratory"),
        ):
            found = with_worst(trials_of(runs, motion, method, noise=noise))
            value(f"{name}_{short}", np.median(found))


# Fig. 4.10: the motion of the stage, reconstructed from rays.


def path_of(shifts, across):
    """Return positions (steps + 1, 2) after each step, mm: along the mean, lateral.

    Deviations along the mean step are enlarged SCALE times; lateral ones are not.
    """
    mean = shifts.mean(axis=0)
    forward, off = mean / np.linalg.norm(mean), shifts - mean
    steps = np.column_stack([(mean + SCALE * off) @ forward, off @ across])
    return np.concatenate([np.zeros((1, 2)), np.cumsum(steps, axis=0)])


def widest(every):
    """Return the unit vector perpendicular to the motion with most deviation."""
    off = np.concatenate([s - s.mean(axis=0) for s in every])
    mean = np.mean([s.mean(axis=0) for s in every], axis=0)
    forward = mean / np.linalg.norm(mean)
    off = off - np.outer(off @ forward, forward)
    return np.linalg.svd(off)[2][0]


@figure("fig_4_10", needs=("fig_4_10_rendered",), evidence="rendered")
def fig_4_10(results):
    """Draw (a) the translation, deviations enlarged; (b) the rotation."""
    result = results["fig_4_10_rendered"]
    drawn, (left, right) = new_figure(1, 2, height_in=3.8)
    # The first rendered run, corners by CELECT.
    shifts, turned = (
        [
            result.arrays(MATCHED, motion, "CELECT", method, name, seed=0)[0]
            for method in METHODS
        ]
        for motion, name in (("translation", "shifts"), ("rotation", "turned"))
    )
    across = widest(shifts)
    rows, gaps = [], []
    stage = STEP_DEG * np.arange(STEPS["rotation"] + 1)
    judged = trials_of(result, "translation", METHODS)[:, 0]
    for index, (method, name) in enumerate(NAMES.items()):
        path = path_of(shifts[index], across)
        left.plot(*path.T, label=name, **look_of(name))
        off = np.concatenate([[0.0], turned[index]]) - stage
        right.plot(stage, off, **look_of(name))
        rows += [("a", method, *place) for place in path]
        rows += [("b", method, *pair) for pair in zip(stage, off, strict=True)]
        lateral = shifts[index] - shifts[index].mean(axis=0)
        deviation = np.sqrt(np.mean(np.sum(lateral**2, axis=1)))
        gaps.append(abs(deviation - judged[index]))
    for panel in (left, right):
        panel.axhline(0, color=INK, lw=0.8)
    left.set(
        xlabel=f"Along the mean step, deviations × {SCALE} (mm)",
        ylabel="Lateral deviation (mm)",
        title="(a)",
    )
    left.set_xticks(STEP_MM * np.arange(STEPS["translation"] + 1))
    right.set(
        xlabel="Rotation of the stage (deg)",
        ylabel="Error of the rotation (deg)",
        title="(b)",
    )
    drawn.legend(loc="outside lower center", ncols=3)
    return Drawing(
        drawn,
        columns(("panel", "method", "x", "y"), rows),
        "Motion of the stage reconstructed from the rays of three calibrations, one "
        "rendered run at the thesis-matched level, corners by CELECT: (a) translation "
        f"in steps of {STEP_MM:g} mm, lateral position against position along the mean "
        f"step, where deviations are enlarged {SCALE} times; (b) error of the "
        "accumulated rotation after each step of 10°.",
        Check(
            bool(max(gaps) < 1e-9),
            "the drawn steps have the deviations that the claims judge, to "
            f"{max(gaps):.0e} mm",
        ),
    )


# Errors of the motion by method and detector.


@table("ext_motion", needs=("fig_4_10_seeds", "fig_4_10_rendered"), evidence="rendered")
def motion_table(results):
    """Tabulate medians of both errors, redrawn and rendered."""
    both = [results[name] for name in ("fig_4_10_seeds", "fig_4_10_rendered")]
    rows = []
    for noise, detector, method in product(LEVEL_NAMES, DETECTORS, NAMES):
        cells = []
        for motion in MEASURES:
            redrawn, found = (
                trials_of(one, motion, method, detector, noise) for one in both
            )
            cells += [Measured.median_or_none(redrawn), float(np.median(found))]
        rows.append((LEVEL_NAMES[noise], detector, NAMES[method], *cells))
    return Table(
        columns(
            (
                "Noise level",
                "Corners",
                "Calibration",
                "Deviation from the mean step, redrawn (mm)",
                "rendered (mm)",
                "Error of the total rotation, redrawn (°)",
                "rendered (°)",
            ),
            rows,
        ),
        "Errors of the reconstructed motion: medians over the redrawn runs, with 95 % "
        "intervals, and over the rendered runs, at both noise levels of the decoded "
        "grids.",
    )


# The claims about Fig. 4.10, tested as the registry words them, and its settings.


INTERPRETATIONS = ("decoding_noise", "standard_method", "motion_corners")
MIN_GAIN = 1.05  # of the medians, required by the rule for wins


def _judged(results, options, motion, words):
    """wins(CGSP < standard) in one motion's measure."""
    result, case = results["fig_4_10_seeds"], Case(QUESTIONS, options)
    methods, detector = ("CGSP", case["standard_method"]), case["motion_corners"]

    def found_at(noise):
        return wins([tuple(trials_of(result, motion, methods, detector, noise))])[0]

    def reading_at(noise):
        found = found_at(noise)
        return Reading.of(
            found.decision,
            found.ratio,
            "x",
            f"{words}, standard over CGSP; p = {found.p:.1g} over "
            f"{result.trials_per_condition} runs",
        )

    return over_the_sweep(
        case, reading_at, lambda noise: found_at(noise).ratio.value >= MIN_GAIN
    )


@claim(
    "c4_motion_trans",
    needs=("fig_4_10_seeds",),
    evidence="rendered",
    readings=INTERPRETATIONS,
)
def judge_translation(results, options):
    """The deviation from the mean step is smaller with CGSP."""
    return _judged(results, options, "translation", "RMS deviation from the mean step")


@claim(
    "c4_motion_rot",
    needs=("fig_4_10_seeds",),
    evidence="rendered",
    readings=INTERPRETATIONS,
)
def judge_rotation(results, options):
    """The total rotation is nearer to 110 degrees with CGSP."""
    words = "difference of the total rotation from 110 degrees"
    return _judged(results, options, "rotation", words)


@numbers("fig_4_10", needs=("fig_4_10_seeds",), evidence="rendered")
def numbers_fig_4_10(results):
    """The settings that the text states, as they were run."""
    settings = results["fig_4_10_seeds"].settings
    steps = settings["steps"]
    return {
        "fig4_10_t": Value(steps["translation"] * settings["step_mm"], unit="mm"),
        "fig4_10_ts": Value(settings["step_mm"], unit="mm"),
        "fig4_10_r": Value(steps["rotation"] * settings["step_deg"], unit="deg"),
        "fig4_10_rs": Value(settings["step_deg"], unit="deg"),
        "fig4_10_scale": Value(SCALE, unit="x"),
    }
