# %% [markdown]
# # 3.3.2 Four cameras, sixty grids
#
# **Question.** Does CELECT extract grids from pictures that bend them, where
# a detector made for ordinary lenses does not? The thesis photographed 15
# grids with each of four cameras: mirror ball, hyperboloidal mirror, fisheye,
# flexible mirror. Those pictures are lost; here the laboratory renders such.

# %%
from chapters.ch03_planar_grids.s3_2_grid_sets.exercises import (
    clicks_task,
    reach_task,
    split_task,
)
from chapters.ch03_planar_grids.s3_2_grid_sets.results.numbers import name_values
from chapters.ch03_planar_grids.s3_2_grid_sets.trials.pictures import (
    CLICKS,
    IMAGES,
    from_smallest,
    grid_view,
    stream,
)
from chapters.ch03_planar_grids.s3_2_grid_sets.trials.scores import (
    BLEMISHES,
    CELECTS,
    DONE,
    METHODS,
    SEEDS,
    SPOTLESS,
    SPOTLESS_SEED,
    cause_of,
    drawn,
    errors_of,
    least_over_merging,
    settings_of,
    share_found,
    stacked,
)
from chapters.shared.grid_detectors import (
    CELECT,
    CLICK_SD_PX,
    OPENCV,
    is_right,
    localised,
    returned,
)
from chapters.shared.grid_rigs import RIGS, WHOLE
from chapters.shared.lattices import outer
from raxel.errors import InputError
from raxel.evaluation.board_scores import in_order_of, in_place
from raxel.features.celect import celect
from raxel.features.tone_curve import undo_srgb
from repro.page.exercise import check
from repro.page.reader import compared, open_results, show, show_code, show_table
from repro.run.experiment import experiments
from repro.run.outcomes import Plan

# %% tags=["active-ipynb"]
# show("ext_grid_rates")

# %% tags=["active-ipynb"]
# name_values(open_results)

# %% [markdown]
# **Findings.**
#
# - Today's OpenCV reads more of these grids than CELECT does:
#   {glue:text}`whole.findChessboardCorners:.0f` % against
#   {glue:text}`whole.celect:.0f` %, with hard poses
#   {glue:text}`hard.findChessboardCorners:.0f` % against
#   {glue:text}`hard.celect:.0f` %. The thesis, with the OpenCV of 2009, has
#   43 % against 85 %.
# - Small squares (merging distance, about 0.4 of a square, under 4.5 px) are
#   in {glue:text}`small.whole.lost` of CELECT's {glue:text}`whole.lost`
#   failures, with hard poses in {glue:text}`small.hard.lost` of
#   {glue:text}`hard.lost`. Over both ranges it reads
#   {glue:text}`small.right` of {glue:text}`small.count` such grids, and
#   {glue:text}`large.right` of {glue:text}`large.count` with 11 px or more.
# - With the camera's tone curve undone first, as the thesis does not,
#   CELECT reads {glue:text}`whole.celect-linear:.0f` %.
# - Our detector [without clicks](ext_without_clicks.ipynb) reads
#   {glue:text}`whole.raxel:.0f` %, and {glue:text}`hard.raxel:.0f` % with
#   hard poses.

# %% [markdown]
# ## What the thesis claims
#
# - CELECT extracts 51 of the 60 grids, OpenCV's detector 26; only 2 grids
#   are found by OpenCV alone, 27 by CELECT alone.
# - Before localisation CELECT's corners are the less accurate ones. After
#   OpenCV's `cornerSubPix` the difference no longer matters: every corner is
#   within 0.12 px of the precision that was asked for, 0.1 px.
# - Of CELECT's nine failures two are lost contours; the others are corners
#   found that are none, or missed, or merged.
# - OpenCV fails mostly because one corner is missed.

# %% [markdown]
# ## Model
#
# Every camera is a rig: geometry, lens, light, dirt, sensor.
# [Table 3.3](#table_3_3) has sizes, the rig files every value and its origin.
#
# - **Spherical**: a golden bauble of 80 mm with 600 flaws in its surface, a
#   number of ours; the grid takes the light from itself.
# - **Hyperboloidal**: dirt on the mirror, and patches of glare.
# - **Fisheye**: weak soft shadows; squares that vary along a contour.
# - **Flexible Mirror**: a sheet bent unevenly and twisted, before a webcam
#   with noise and colour fringes.
#
# A pose has three angles. *Polar* is the angle of the sheet's middle from
# the direction that the middle of the picture shows. *Tilt* is the angle
# between the sheet's normal and the line of sight. *Subtense* is how large
# the whole sheet looks from corner to corner, its white border, one square
# wide, included. Each is drawn uniformly:
#
# | range | polar | hyperboloid | flexible mirror | tilt | subtense |
# |---|---|---|---|---|---|
# | whole | 0 to 70° | 40 to 110° | 0 to 25° | 0 to 70° | 35 to 125° |
# | hard | 35 to 70° | 75 to 110° | 0 to 25° | 40 to 70° | 80 to 125° |
#
# The claims are judged on the **whole** range: all that the views show. The
# **hard** range came first. It was picked in a trial of four ranges with
# OpenCV and CELECT, because it still troubles today's OpenCV; so it is no
# more than a second reading of every claim. A pose counts if all of the
# sheet is in the picture and neighbouring corners are 9 px apart or more.
#
# CELECT is given the picture, the counts, and four simulated clicks. They
# scatter as the 2880 clicks of the thesis did, and begin at the outer corner
# with the smallest square, as 3.3.2 advises. The other detectors are given
# the picture and the counts. A grid is right if every corner is within 8 px
# of its own true corner and nearer to it than to any other.

# %% tags=["active-ipynb"]
# show_code(grid_view, returned, is_right, in_place)

# %% tags=["active-ipynb"]
# show_code(localised, errors_of, cause_of, from_smallest, undo_srgb)

# %% [markdown]
# "OpenCV" is `findChessboardCorners` of today, with adaptive threshold and
# normalised image, and in a second reading the sector-based detector. The
# ball's pictures of one seed are exposed a second time without flaws.

# %% [markdown]
# ## Experiment


# %%
def grid_trial(condition, rng):
    """One picture and what the detectors make of it.

    Its draws are those of the picture (`pictures`), so that others can have
    the same one; `rng` is not used. CELECT is given the picture, simulated
    clicks and the counts; the others the picture and the counts.
    """
    where = tuple(condition[k] for k in ("set", "image", "seed", "poses"))
    view = grid_view(*where)
    lattice = from_smallest(view.corners.reshape(view.rows, view.columns, 2))
    clicks = outer(lattice) + stream(*where[:3], CLICKS).normal(0, CLICK_SD_PX, (4, 2))
    result, values = every_method(METHODS, view, clicks, lattice)
    both = ("spherical", SPOTLESS_SEED)
    if (condition["set"], condition["seed"]) == both:
        clean = grid_view(*where, without="spots")
        _, values["spotless"] = every_method(SPOTLESS, clean, clicks, lattice)
    if not values[CELECT]["success"]:
        for blemish in BLEMISHES.get(condition["set"], ()):
            clean = grid_view(*where, without=blemish)
            _, again, _ = run_celect(CELECT, clean.image, clicks, lattice)
            values[CELECT][f"right_without_{blemish}"] = again["success"]
    if condition["poses"] == WHOLE:
        values |= drawn(view, result)
    over, reach = least_over_merging(lattice)
    return values | {
        "corners": len(view.corners),
        "least_over_t8": over.min(),
        "t8_px": reach.min(),
    }


def every_method(methods, view, clicks, lattice):
    """(CelectResult, values) of several methods on one picture."""
    values, errors, result = {}, {}, None
    for name in methods:
        if name in CELECTS:
            found, values[name], right = run_celect(name, view.image, clicks, lattice)
            result = found if name == CELECT else result
        else:
            values[name], right = no_clicks(name, view)
        if right is not None:
            errors[name] = errors_of(view.image, *right)
    if not values[OPENCV]["success"]:
        values["independent"] = share_found(view.image, view.corners)
    values["errors"] = stacked(errors, methods, len(view.corners))
    return result, values


def run_celect(name, image, clicks, lattice):
    """(CelectResult or None, scores, right corners and the true ones or None).

    name: of CELECTS, which says what is done otherwise than in the thesis.
    """
    rows, columns = lattice.shape[:2]
    undone, settings = CELECTS[name]
    image = undo_srgb(image) if undone else image
    try:
        result = celect(image, clicks, columns, rows, settings=settings)
    except InputError as fault:
        return None, {"success": False, "cause": fault.code}, None
    truth = lattice.reshape(-1, 2)
    corners = result.corners.reshape(-1, 2)
    if result.found and is_right(corners, truth):
        return result, {"success": True, "cause": DONE}, (corners, truth)
    scores = {"success": False, "cause": cause_of(result, lattice)}
    if result.failures:
        first = result.failures[0]
        scores |= {"contour": first.contour, "stage": first.stage}
    return result, scores, None


def no_clicks(name, view):
    """(scores, right corners and the true ones or None) of a detector.

    It is told the counts alone.
    """
    truth = view.corners
    corners = returned(name, view.image, view.columns, view.rows)
    if corners is None:
        return {"success": False, "returned": False}, None
    corners = in_order_of(truth, corners, view.columns, view.rows)
    if not is_right(corners, truth):
        return {"success": False, "returned": True}, None
    return {"success": True, "returned": True}, (corners, truth)


# %%
SET_OF = {
    "table_3_4_grids": "spherical",
    "table_3_5_grids": "hyperboloidal",
    "table_3_6_grids": "fisheye",
    "table_3_7_grids": "flexible-mirror",
}


@experiments(
    {
        "table_3_4_grids": "table_3_4",
        "table_3_5_grids": "table_3_5",
        "table_3_6_grids": "table_3_6",
        "table_3_7_grids": "table_3_7",
    },
    shards={"full": 4},
    inputs=RIGS,
)
def pictures_of_sets(effort, identifier):
    """15 pictures of each seed of both ranges, or one of each for a look."""
    set_name = SET_OF[identifier]
    images = 1 if effort == "quick" else IMAGES
    conditions = [
        {"set": set_name, "poses": poses, "image": image, "seed": seed}
        for poses, seeds in SEEDS.items()
        for seed in (seeds[:1] if effort == "quick" else seeds)
        for image in range(images)
    ]
    return Plan(grid_trial, conditions, 1, settings_of(set_name))


# %% [markdown]
# ## Figures

# %% [markdown]
# A side of $n$ corners, $L$ px from end to end, has $s = L / 1.9n$, about
# half a square. CELECT's windows along it have the radius $s$. Answers of
# the corner detector nearer to each other than $t_8 = 0.8 s$ are taken for
# one corner.

# %% tags=["active-ipynb"]
# show_table("table_3_3")

# %% tags=["active-ipynb"]
# show_table("table_3_4")

# %% tags=["active-ipynb"]
# show_table("table_3_5")

# %% tags=["active-ipynb"]
# show_table("table_3_6")

# %% tags=["active-ipynb"]
# show_table("table_3_7")

# %% tags=["active-ipynb"]
# show("fig_3_12")

# %% tags=["active-ipynb"]
# show("fig_3_13")

# %% [markdown]
# ## Reading and limits
#
# **Why CELECT fails.** The first contour that fails names the cause.
#
# - *Contour lost*: {glue:text}`contours` of {glue:text}`whole.lost` in the
#   whole range, most of them where squares are small.
# - *Corner split*: the Harris detector answers at the tips of the two dark
#   squares, not at the point where they meet. If the two answers are farther
#   apart than $t_8$, they remain two corners.
# - *Corners merged*: along a side that shrinks, the smallest step comes near
#   $t_8$, which follows the mean step. CELECT reads {glue:text}`near.right`
#   of {glue:text}`near.count` grids of both ranges with steps under 1.2 $t_8$.
#
# The thesis does not state its Harris detector's scale
# (`celect_thresholds` in the ledger); smoothed by at most 0.7 px CELECT reads
# {glue:text}`whole.celect-fine:.0f` %. Nor does it undo the tone curve, which
# makes dark squares shrink and their tips draw apart.
#
# **Spots.** Of the same 15 pictures of the ball, CELECT reads
# {glue:text}`ball.whole.spots` with the spots and
# {glue:text}`ball.whole.clean` without; with hard poses
# {glue:text}`ball.hard.spots` and {glue:text}`ball.hard.clean`.
#
# **Accuracy.** 3.3.2 does not tell the width of `cornerSubPix`'s window.
# Table 3.4 has a corner 7.33 px off before and 0.1985 px at most after, which
# a window that reaches 4 px cannot do, so a half window of 9 px is the
# primary reading. With smaller squares it may end at a neighbour: the
# largest error is {glue:text}`largest.reference:.1f` px, and in grids whose
# neighbouring corners are all 15 px apart or more {glue:text}`largest.apart:.2f`
# px. There the thesis's sentence holds of nearly every corner, so that the
# verdict hangs on how small squares may be; the text does not say. With the
# full window corners that start far off stay there. The tables have both. A reference
# made with the same localiser hides a bias of either.
#
# **Limits.** The rigs' light, dirt, noise and bends are our choice. Nothing
# in the even background looks like a corner, which spares OpenCV more than
# CELECT. The whole range has three seeds, the hard one and the clean ball
# one. The pages of photographed sets have such tables.

# %% [markdown]
# ## Compared with the published numbers

# %% tags=["active-ipynb"]
# compared()

# %% [markdown]
# ## Try it yourself
#
# Open this page as a notebook (`make lab`) and run all cells. Then put an
# answer in place of `None`, and run that cell again.
#
# **1.** 27 pictures are right for one method alone and 2 for the other
# alone. How likely is so unequal a split if both are equally good
# (McNemar's test, exact, two-sided)?

# %% tags=["active-ipynb"]
# check(None, **split_task())

# %% [markdown]
# **2.** 15 pictures each of three sets show 7 × 5 corners; in the fourth
# seven show 9 × 7 and eight 12 × 9. How many corners were clicked?

# %% tags=["active-ipynb"]
# check(None, **clicks_task())

# %% [markdown]
# **3.** A side of 7 corners is 120 px long from end to end. How far apart,
# in px, may two answers be that CELECT joins to one corner?

# %% tags=["active-ipynb"]
# check(None, **reach_task())
