# %% [markdown]
# # 4.3.2 The motion of a target, found from its rays
#
# **Question.** What is a calibration good for? A target is moved on a stage
# by known amounts, and a calibrated mirror camera is to tell the motion from
# its rays alone. Does the motion come out better with the rays of CGSP than
# with those of the standard method?

# %%
from functools import partial

import numpy as np

from chapters.ch04_central_generic.s3_4_motion.exercises import (
    freedom_task,
    parallax_task,
)
from chapters.ch04_central_generic.s3_4_motion.results import name_values
from chapters.ch04_central_generic.s3_4_motion.trials.calibrations import (
    METHODS,
    SWEPT_METHODS,
    calibrated,
    drawn_grids,
    grids_at_pixels,
    table_rays,
)
from chapters.ch04_central_generic.s3_4_motion.trials.corners import (
    CALIBRATION,
    DETECTORS,
    MEASURED,
    RENDERED,
    SWEPT_DETECTOR,
    measured,
)
from chapters.ch04_central_generic.s3_4_motion.trials.stage import (
    RIG,
    RIG_FILES,
    SETTINGS,
    STEPS,
    motions,
    scored,
    target_poses,
    true_pixels,
)
from chapters.shared.bench_noise import NOISES, SWEPT_NOISES
from chapters.shared.rigs import rig_named
from raxel.errors import CalibrationError
from raxel.geometry import inverse_pose, transform
from repro.page.exercise import check
from repro.page.reader import compared, open_results, show, show_code, show_table
from repro.run.experiment import experiment
from repro.run.outcomes import Plan, crossed

# %% tags=["active-ipynb"]
# show("fig_4_10")

# %% tags=["active-ipynb"]
# name_values(open_results)

# %% [markdown]
# **Findings.**
#
# - In translation the steps deviate from their mean by
#   {glue:text}`translation_cgsp:.2f` mm with CGSP, by
#   {glue:text}`translation_printed:.2f` mm with the standard method as printed
#   and by {glue:text}`translation_well:.2f` mm with it well conditioned: medians
#   over seeds with redrawn corners, at the bench's noise
#   ([4.3.2](s3_2_results.ipynb)). With the laboratory's own decoding errors they
#   are {glue:text}`lab_translation_cgsp:.2f`,
#   {glue:text}`lab_translation_printed:.2f` and
#   {glue:text}`lab_translation_well:.2f` mm.
# - The whole turn of 110° is off by {glue:text}`rotation_cgsp:.2f`° with CGSP, by
#   {glue:text}`rotation_printed:.2f`° as printed and by
#   {glue:text}`rotation_well:.2f`° well conditioned; with the laboratory's errors
#   by {glue:text}`lab_rotation_cgsp:.2f`°, {glue:text}`lab_rotation_printed:.2f`°
#   and {glue:text}`lab_rotation_well:.2f`°. The three seeds whose corners were
#   found in pictures, one of which Fig. 4.10 draws, have
#   {glue:text}`rendered_rotation_cgsp:.2f`°,
#   {glue:text}`rendered_rotation_printed:.2f`° and
#   {glue:text}`rendered_rotation_well:.2f`° at the bench's noise.
# - The centre is off by {glue:text}`centre_cgsp:.2f` mm with CGSP, by
#   {glue:text}`centre_printed:.2f` mm as printed and by
#   {glue:text}`centre_well:.2f` mm well conditioned; with the laboratory's errors
#   by {glue:text}`lab_centre_cgsp:.2f`, {glue:text}`lab_centre_printed:.2f` and
#   {glue:text}`lab_centre_well:.2f` mm.
# - CELECT refused {glue:text}`celect_refused` of
#   {glue:text}`boards_shown` boards, all seen at a steep angle; the detector
#   without clicks {glue:text}`clickless_refused`.

# %% [markdown]
# ## What the thesis claims
#
# - A target of two orthogonal chessboards was translated by 100 mm in steps
#   of 20 mm, and rotated by 110° in steps of 10°. Corners were found by
#   CELECT, and their rays looked up in the table of each calibration.
# - With CGSP the translation is nearer to a straight line, and the rotation
#   nearer to 110°, than with the standard generic method (Fig. 4.10).

# %% [markdown]
# ## Model
#
# A point of the target is seen along $\mathbf{d}_1$ before a step and along
# $\mathbf{d}_2$ after it, both unit vectors. The step takes a point
# $\mathbf{X}$ to $R\mathbf{X} + \mathbf{t}$. Then $\mathbf{d}_1$ turned by
# $R$, $\mathbf{d}_2$ and $\mathbf{t}$ lie in one plane, which is one
# equation for each point,
#
# $$\mathbf{d}_2^T E\, \mathbf{d}_1 = 0 , \qquad
#   E = [\mathbf{t}]_\times R . \tag{4.25}$$
#
# It is linear in the nine entries of $E$. Eight points or more give $E$ up
# to a factor, and $E$ gives four motions. The right one is that for which
# the points lie ahead along their rays. Nothing here needs an image plane,
# so a mirror that sees more than half of the sphere is no special case.
#
# The rays do not tell how long $\mathbf{t}$ is. Each step is given the
# length of the stage's.

# %% tags=["active-ipynb"]
# show_code(motions)

# %% [markdown]
# Points on one plane leave $E$ open. That is why the target has two boards.

# %% [markdown]
# ## Experiment
#
# **Pictures.** The camera is the one of 4.3.1, a hyperboloidal mirror on a
# camera of 3008 x 2000 px, its bracket a millimetre off. The target stands
# 260 mm from the mirror, on a stage whose axis is vertical, and is set up by
# hand in each seed. All pictures of {glue:text}`seeds_rendered` seeds are
# rendered. CELECT gets four clicks for each board; a board that it refuses
# is clicked by hand, corner by corner. The second reading takes the detector
# that needs no clicks.

# %% [markdown]
# **Calibrations.** Three active grids give the centre and their poses,
# three more are posed from the rays known by then: with three points and
# refinement for the standard method, with the linear pose for CGSP
# ([section 4.2](s2_pose.ipynb)). The standard method's poses are adjusted,
# CGSP's are not, as in the thesis. What pixels see of the grids is redrawn
# for each seed, with the errors that were measured in decoded pictures of
# the rig, and made as large as the bench's; all calibrations of a seed see the
# same points.
#
# **Seeds.** The claims ask for fifty, a hundred are run. Those that are not
# rendered redraw the corners: the error that all rendered seeds share at a
# corner, and what is left of any corner of that board and picture.

# %%
SEEDS = {"quick": 3, "full": 100}


def motion_trial(condition, rng, corners, decoding):
    """Both motions from the rays of every calibration at every noise, one seed.

    The corners are those of the rendered pictures of the condition's seed, or
    redrawn. All calibrations see the same grids, with the same errors.
    """
    grids = drawn_grids(decoding, rng)
    shown = {
        (motion, detector): pixels
        for motion in STEPS
        for detector, pixels in corner_pixels(
            motion, condition.get("seed"), corners, rng
        ).items()
    }
    below = {
        case: grids_at_pixels(pixels.reshape(-1, 2), grids.T_camera_grid, decoding, rng)
        for case, pixels in shown.items()
    }
    out = {"without_ray": max(1 - g.seen.any(axis=0).mean() for g in below.values())}
    for name, noise in (NOISES | SWEPT_NOISES).items():
        methods, cases = METHODS, list(shown)
        if name in SWEPT_NOISES:
            methods = SWEPT_METHODS
            cases = [case for case in shown if case[1] == SWEPT_DETECTOR]
        found = attempted(grids.at(noise, rng), rng, methods)
        out[name] = {"centre_mm": centres_off(found, grids)}
        for case in cases:
            motion, detector = case
            seen = below[case].at(noise, rng)
            scores = out[name].setdefault(motion, {})
            scores[detector] = {
                method: {"failed": one}
                if isinstance(one, str)
                else scored(
                    motion, table_rays(seen, one).reshape(*shown[case].shape[:2], 3)
                )
                for method, one in found.items()
            }
    return out


def corner_pixels(motion, seed, corners, rng):
    """{detector: corners (pictures, N, 2) px} of the target in one motion."""
    poses = target_poses(motion, corners.setup(motion, seed, rng))
    camera = rig_named(RIG).camera
    pixels = np.stack([np.concatenate(true_pixels(camera, T)) for T in poses])
    return {
        detector: pixels + corners.of_seed(motion, detector, seed, rng)
        for detector in DETECTORS
    }


def centres_off(found, grids):
    """{method: distance (mm) of its centre from the true one}, where it has one."""
    true = viewpoint(rig_named(RIG).camera)
    centre = transform(inverse_pose(grids.T_camera_grid[0]), true[None])[0]
    return {
        method: np.linalg.norm(one.centre - centre)
        for method, one in found.items()
        if not isinstance(one, str)
    }


def attempted(grids, rng, methods):
    """{method: its calibration, or the code of the error that left none}."""
    found = {}
    for method in methods:
        try:
            found[method] = calibrated(method, grids, rng)
        except CalibrationError as error:
            found[method] = error.code
    return found


def viewpoint(camera):
    """The point (3,) that the camera's rays pass most nearly, its frame."""
    u, v = np.meshgrid(
        np.arange(0.0, camera.width, 40), np.arange(0.0, camera.height, 40)
    )
    rays = camera.rays(np.column_stack([u.ravel(), v.ravel()]))
    d = rays.directions[rays.valid]
    o = np.broadcast_to(rays.origins, rays.directions.shape)[rays.valid]
    across = np.eye(3) - d[:, :, None] * d[:, None, :]
    return np.linalg.solve(across.sum(axis=0), np.einsum("nij,nj->i", across, o))


def trial_of(results, effort):
    """The trial with what the pictures have shown."""
    corners, decoding = measured(results, effort)
    return partial(motion_trial, corners=corners, decoding=decoding)


@experiment("fig_4_10_rendered", artefact="fig_4_10", inputs=RIG_FILES, needs=MEASURED)
def rendered_seeds(effort, results):
    """Motions from the corners of the rendered pictures."""
    seeds = crossed(seed=range(RENDERED[effort]))
    return Plan(trial_of(results, effort), seeds, 1, SETTINGS | CALIBRATION)


@experiment(
    "fig_4_10_seeds",
    artefact="fig_4_10",
    shards={"full": 2},
    inputs=RIG_FILES,
    needs=MEASURED,
)
def redrawn_seeds(effort, results):
    """Motions of further seeds, with redrawn corners."""
    return Plan(trial_of(results, effort), [{}], SEEDS[effort], SETTINGS | CALIBRATION)


# %% [markdown]
# ## All seeds

# %% tags=["active-ipynb"]
# show_table("ext_motion")

# %% [markdown]
# ## Reading and limits
#
# **Which standard method.** As printed, one ratio of two noisy numbers sets
# a common scale ([section
# 2.5.1](../ch02_general_camera_model/s5_1_synthetic_data.ipynb)), and the centre
# is off by {glue:text}`centre_printed:.2f` mm. With the same equations well
# conditioned it is off by {glue:text}`centre_well:.2f` mm, and with the
# laboratory's errors the motion is then as near to the truth as CGSP's. So what
# helps is the conditioning, not the synthetic camera. At the bench's noise the
# rays of single corners are so noisy that a better centre hardly shows in the
# motion: in translation CGSP stays ahead of the method as printed by a little,
# in rotation it does not.
#
# **Small errors all the same.** The motion between two pictures needs
# differences of directions. A centre that is wrong bends all rays smoothly,
# and much of that goes into both views alike. The points span a few tens of
# degrees; there a small turn and a small shift look nearly the same, and
# noise of corners and table turns one into the other. Refinement would
# gain on both calibrations; the thesis estimates linearly, and so does this
# page.
#
# **Not central.** The mirror's bracket is a millimetre off, so no centre is
# the right one. It is the same for both methods.
#
# **Corners without a ray.** {glue:text}`lost_percent:.1f` % of the corners,
# at most of any method, lie where no grid was seen, and were left out.
#
# **What is not stated.** The size of the boards, their distance, the
# direction of the stage and the length of the steps found are choices
# (see the ledger). The boards are so large that neighbouring
# corners are 8 px apart or more in every picture, and so placed that both
# are seen from the front over the whole turn.

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
# **1.** How many numbers of a motion can be found from matched rays?

# %% tags=["active-ipynb"]
# check(None, **freedom_task())

# %% [markdown]
# **2.** A point straight ahead, 300 mm away, is shifted by 20 mm across the
# line of sight. By how many degrees does its ray turn?

# %% tags=["active-ipynb"]
# check(None, **parallax_task())
