# %% [markdown]
# # Benchmarks: rendered sets with truth
#
# **Question.** How good is a detector, a decoder, a calibration?
# Photographs do not say: nobody knows where their corners truly are, and a
# small residual only says that a model agrees with itself. A rendered set
# knows. Anybody's method can be scored on one; here is how, and how today's
# do.

# %%
import tempfile
from dataclasses import replace
from pathlib import Path

from chapters.guides.benchmarks import exercises
from chapters.guides.benchmarks.results import counted, facts, worst_corner, worst_of
from chapters.guides.benchmarks.trials import (
    CHECKS,
    DETECTORS,
    NOISE,
    RECORD,
    RENDERINGS,
    SCORED,
    SIZE,
    VIEW_PX,
    VIEWS,
    camera_scores,
    cameras,
    kept_scores,
    megapixel_trial,
    recorded_scores,
)
from chapters.shared.records import record
from chapters.shared.rigs import rig_named
from chapters.shared.zoom_rigs import ZOOM_RIGS
from raxel.calibration.views.boards import board_views
from raxel.evaluation.benchmark import corner_errors, score_camera, score_corners
from raxel.features.boards import detect_boards
from raxel.lab import render_set
from repro.page.exercise import check
from repro.page.reader import (
    open_results,
    results_behind,
    seconds,
    show_code,
    show_table,
    value,
)
from repro.run.experiment import experiment
from repro.run.outcomes import Plan


# %%
def score_rig(name, views, rng):
    """Render a set of this rig; score the detectors and the calibrations.

    The cameras are compared on the pixels that the general one has a ray for.
    """
    rig = replace(rig_named(name), count=views, evaluate=0)
    seed = int(rng.integers(2**31))
    with tempfile.TemporaryDirectory() as room:
        image_set = render_set(rig, Path(room) / "set", seed)
        boards = {one: detect_boards(image_set, one) for one in DETECTORS}
        scores = {
            one: kept_scores(score_corners(image_set, found))
            for one, found in boards.items()
        }
        found = board_views(image_set, boards[DETECTORS[0]])
        return scores | camera_scores(image_set, found, rng)


@experiment(
    "ext_benchmark_scores",
    artefact="ext_benchmarks",
    shards={"full": 3},
    inputs=ZOOM_RIGS,
)
def ext_benchmark_scores(effort):
    """Small rendered sets, scored as raxel score does."""
    conditions = [{"rig": name} for name in SCORED[effort]]
    settings = {"views": VIEWS[effort], "detectors": list(DETECTORS)}

    def trial(condition, rng):
        return score_rig(condition["rig"], VIEWS[effort], rng)

    return Plan(trial, conditions, 1, settings)


@experiment("ext_lab_accuracy_checks", artefact="ext_lab_accuracy")
def ext_lab_accuracy_checks(effort):
    """Rendered corners and light against what they should be."""
    return Plan(
        lambda condition, rng: CHECKS[condition["check"]](condition, rng),
        [{"check": "corners", "camera": name} for name in cameras()]
        + [{"check": name} for name in ("area", "edge", "noise")],
        1,
        {"square_px": 17.0, "aim_px": 0.02, **SIZE, "noise": NOISE},
    )


@experiment("ext_lab_rendering", artefact="ext_lab_accuracy")
def ext_lab_rendering(effort):
    """Pictures of one megapixel; their time stands in the run record."""
    return Plan(megapixel_trial, [{"size_px": VIEW_PX}], RENDERINGS[effort])


@experiment(
    "ext_detector_record",
    artefact="ext_detector_counts",
    inputs=("data/records/detectors.json",),
)
def ext_detector_record(effort):
    """What the record holds; nothing is measured again."""
    kept = record(RECORD)
    return Plan(
        lambda condition, rng: recorded_scores(condition),
        [{"set": one["name"]} for one in kept["sets"]],
        1,
        {
            "record": RECORD,
            "command": kept["command"],
            "date": kept["date"],
            "opencv": kept["versions"]["opencv"],
        },
    )


# %% tags=["active-ipynb", "remove-input"]
# scores = open_results("ext_benchmark_scores")

# %% tags=["active-ipynb", "remove-input"]
# checks = open_results("ext_lab_accuracy_checks")

# %% tags=["active-ipynb", "remove-input"]
# drawn = open_results("ext_lab_rendering")

# %% tags=["active-ipynb"]
# for name, x in facts(scores).items(): value(name, x)

# %% tags=["active-ipynb"]
# value("worst", worst_corner(checks))

# %% tags=["active-ipynb"]
# value("aim", checks.settings["aim_px"])

# %% tags=["active-ipynb"]
# value("noise", 100 * worst_of(checks, "noise"))

# %% tags=["active-ipynb"]
# value("pace", seconds("ext_lab_rendering") / drawn.trials_per_condition)

# %% tags=["active-ipynb", "remove-input"]
# both = counted(results_behind("ext_detector_counts"))

# %% tags=["active-ipynb", "remove-input"]
# for name, x in both.items(): value(name, x)

# %% tags=["active-ipynb"]
# show_table("ext_benchmarks", digits=3)

# %% [markdown]
# ## Findings
#
# - **Detectors, where it is easy**: of {glue:text}`views` rendered boards,
#   raxel has {glue:text}`right_raxel` right, OpenCV
#   {glue:text}`right_opencv`, and its sector-based detector
#   {glue:text}`right_opencv-sb`.
# - **Detectors on bent boards**: of {glue:text}`rendered.pictures`
#   pictures in mirrors, fisheyes and bad light, of the whole and the hard
#   range of poses in 3.3.2 together, they have
#   {glue:text}`rendered.raxel.right`, {glue:text}`rendered.opencv.right` and
#   {glue:text}`rendered.opencv-sb.right` right.
# - **Detectors, on photographs**: of {glue:text}`photographs.pictures` of
#   five real cameras, {glue:text}`photographs.raxel.right`,
#   {glue:text}`photographs.opencv.right` and
#   {glue:text}`photographs.opencv-sb.right`.
# - **Rays**: on one set of {glue:text}`last`, Zhang's are {glue:text}`zhang_deg`° off,
#   OpenCV's fisheye model's {glue:text}`opencv_fisheye_deg`°, those of the
#   generic camera {glue:text}`general_deg`°, on the {glue:text}`share` of
#   the image circle that it has rays for. The rendered lens follows the formula
#   of OpenCV's model exactly: where its rays are far off, its fit has
#   ended in a wrong place.

# %% [markdown]
# ## Detectors side by side

# %% tags=["active-ipynb"]
# show_table("ext_detector_counts")

# %% [markdown]
# The photographs are not part of this repository. The record in
# `data/records` names each set, where it is from and its licence. It is of
# {glue:text}`record.date`; with the same sets, `raxel bench` makes it again.
# Their reference corners were agreed on by detectors from outside, so
# OpenCV's are judged mildly.
#
# ## Make a set
#
# A rig file says what stands before what. The seed draws poses and noise;
# the same seed gives the same bytes.
#
# ```
# raxel render data/rigs/coolpix-fce8-zoom-2.yaml --out my-set --seed 0
# raxel check my-set
# ```
#
# In `my-set` are `set.yaml` and the pictures, just as in a recorded set.
# Its folder `truth` is for scoring only:
#
# | file | what is in it |
# |---|---|
# | `camera.npz` | the true camera |
# | `poses.json` | the pose of the target in each view |
# | `corners.json` | the projected corners of each view of a chessboard |
# | `<view>.npz` | for a monitor: the point in mm that each pixel sees |
#
# ## Score
#
# ```
# raxel corners my-set --json corners.json
# raxel calibrate my-set --model generic --out camera.npz
# raxel score my-set --corners corners.json --camera camera.npz
# raxel score a-monitor-set --points decoded --json scores.json
# ```
#
# The files may come from any program that writes these forms. `decoded` has
# for each view a file `<view>.npz` with `points_mm`, height by width by 2,
# and NaN where nothing was decoded.
#
# - *Corners*: a board is right if every corner is within 1 px of the truth.
#   Which corner is first does not matter, and a mirrored board is allowed.
#   Errors are those of right boards; wrong ones are counted and named.
# - *Points*: a point that misses by more than 1 % of the monitor's width
#   is gross. Gross ones are counted, and the errors are of the others.
# - *Camera*: angles between its rays and the true ones on a grid of pixels,
#   after the one rotation that fits best, since frames are chosen apart.
#   The px say where the true camera would see the ray. Beside them stands
#   the share of the pixels that have a ray at all.

# %% tags=["active-ipynb"]
# show_code(corner_errors, score_camera)

# %% [markdown]
# ## Rigs without scores here

# %% tags=["active-ipynb"]
# show_table("ext_benchmarks_further")

# %% [markdown]
# ## How good the pictures are
#
# A benchmark cannot judge what is better than itself. Corners of pictures
# without lens and noise are fitted by the areas that edges cover. They
# should lie at their projections.

# %% tags=["active-ipynb"]
# show_table("ext_lab_accuracy")

# %% [markdown]
# The worst corner is {glue:text}`worst:.2g` px off; the aim was
# {glue:text}`aim` px. The number holds the error of the fit as well, which allows
# for edges of even bend and no other. The spread of an even picture
# differs from shot and read noise by {glue:text}`noise:.2g` %.
#
# **Time.** A picture of a chessboard, one megapixel, without lens and
# sensor, took {glue:text}`pace:.2f` s on one core of the machine that made
# this page. That is read from the record of the run, not from the result,
# which is the same on every machine. A lens that blurs is rendered with
# twice as many pixels each way, so about four times that. `make
# ext_lab_accuracy` measures it on yours.

# %% tags=["active-ipynb"]
# show_code(megapixel_trial)

# %% [markdown]
# ## Limits
#
# - The background is even. A detector that takes clutter for a board is not
#   found out here.
# - The board is flat, printed without fault, and nothing moves.
# - The scores are of a few views. A difference between two methods
#   should be tested over many seeds before it is believed.
# - Best rotation: errors at the rim turn the whole camera a little. Compare
#   cameras on the same pixels.
# - Only central cameras are scored as cameras.
# - Decoders have no scores on this page. The scorer is there for yours.

# %% [markdown]
# ## Try it yourself
#
# Open this page as a notebook (`make lab`) and run all cells. Then put an
# answer in place of `None`, and run that cell again.
#
# A detector finds every corner of a board shifted by 0.3 px to the right
# and 0.4 px down. What RMS error in px does the score say?

# %% tags=["active-ipynb"]
# check(None, **exercises.shift_task())
