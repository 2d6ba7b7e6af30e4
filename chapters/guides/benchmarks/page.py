# %% [markdown]
# # Benchmarks: rendered sets with truth
#
# Pictures of targets for which everything is known: camera, poses, corners,
# and the point that each pixel sees. Anybody's detector, decoder or
# calibration can be scored on them. Here is how, how today's methods of
# this library do, and how far the pictures themselves can be trusted.

# %% tags=["hide-cell"]
import tempfile
from dataclasses import replace
from pathlib import Path

from chapters.guides.benchmarks import exercises
from chapters.guides.benchmarks.results import facts, worst_corner, worst_of
from chapters.guides.benchmarks.trials import (
    CHECKS,
    DETECTORS,
    NOISE,
    RENDERINGS,
    SCORED,
    SIZE,
    VIEW_PX,
    VIEWS,
    camera_scores,
    cameras,
    kept_scores,
    megapixel_trial,
)
from chapters.shared.rigs import rig_named
from raxel.calibration.board_views import board_views
from raxel.evaluation.benchmark import (
    corner_errors,
    score_camera,
    score_corners,
)
from raxel.features.boards import detect_boards
from raxel.lab import render_set
from repro.page.exercise import check
from repro.page.reader import (
    open_results,
    seconds,
    show_code,
    show_table,
    value,
)
from repro.run.experiment import experiment
from repro.run.outcomes import Plan


# %% tags=["hide-cell"]
def score_rig(name, views, rng):
    """Render a set of this rig; score both detectors and both calibrations.

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
    shards={"quick": 1, "full": 3},
)
def ext_benchmark_scores(effort):
    """Small rendered sets, scored as raxel score does."""
    conditions = [{"rig": name} for name in SCORED[effort]]
    settings = {"views": VIEWS[effort], "detectors": list(DETECTORS)}

    def trial(condition, rng):
        return score_rig(condition["rig"], VIEWS[effort], rng)

    return Plan(trial, conditions, 1, settings)


@experiment(
    "ext_lab_accuracy_checks",
    artefact="ext_lab_accuracy",
    shards={"quick": 1, "full": 1},
)
def ext_lab_accuracy_checks(effort):
    """Rendered corners and light against what they should be."""
    return Plan(
        lambda condition, rng: CHECKS[condition["check"]](condition, rng),
        [{"check": "corners", "camera": name} for name in cameras()]
        + [{"check": name} for name in ("area", "edge", "noise")],
        1,
        {"square_px": 17.0, "aim_px": 0.02, **SIZE, "noise": NOISE},
    )


@experiment(
    "ext_lab_rendering",
    artefact="ext_lab_accuracy",
    shards={"quick": 1, "full": 1},
)
def ext_lab_rendering(effort):
    """Pictures of one megapixel; their time stands in the run record."""
    return Plan(megapixel_trial, [{"size_px": VIEW_PX}], RENDERINGS[effort])


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

# %% [markdown]
# ## Question
#
# How good is a detector, a decoder, a calibration? Photographs do not say:
# nobody knows where their corners truly are, and a small residual only says
# that a model agrees with itself. A rendered set knows.
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
#   The px say where the true camera would see the ray.

# %% tags=["active-ipynb", "hide-output"]
# show_code(corner_errors, score_camera)

# %% [markdown]
# ## How today's methods do

# %% tags=["active-ipynb"]
# show_table("ext_benchmarks")

# %% [markdown]
# Scored here: {glue:text}`rigs`. Of {glue:text}`views` boards, detector
# raxel has {glue:text}`right_raxel` right, opencv {glue:text}`right_cv`,
# opencv-sb {glue:text}`right_sb`.
# On {glue:text}`last`, Zhang's rays are {glue:text}`zhang_deg`° off, and
# those of the general camera {glue:text}`general_deg`°. The general camera
# has a ray for {glue:text}`share` of the pixels, and both are compared
# there alone: beyond its boards Zhang's camera only extrapolates.
#
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

# %% tags=["active-ipynb", "hide-output"]
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
# - The table sets no score beside the monitor: the library has no decoder.
#   The scorer is there for yours.

# %% [markdown]
# ## Try it yourself
#
# Open this page as a notebook (`make notebooks`), put an answer in place of
# `None`, and run the cell.
#
# A detector finds every corner of a board shifted by 0.3 px to the right
# and 0.4 px down. What RMS error in px does the score say?

# %% tags=["active-ipynb"]
# check(None, **exercises.shift_task())
