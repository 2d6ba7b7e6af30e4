# %% [markdown]
# # 1.1.2 A panorama and its unwrapping
#
# **Question.** A camera below a curved mirror shows the whole horizon in one
# image, which a perspective camera cannot do. Given the mirror's shape, that
# image is resampled onto a cylinder to give a panorama. How does the resolution
# vary over the panorama, and does the shape of the mirror matter?

# %%
import numpy as np

from chapters.ch01_introduction.s1_1_panorama.exercises import (
    EYE_HIGH_DEG,
    given,
    lamp_task,
    rows_task,
)
from chapters.ch01_introduction.s1_1_panorama.experiment import (
    AHEAD,
    BANDS_DEG,
    DOWN,
    ECCENTRICITIES,
    HEIGHT,
    HIGHEST_DEG,
    MIN_RATIO,
    RIG,
    RIG_FILES,
    RIG_NAMES,
    RIG_SEED,
    RIGS,
    RIM_MM,
    RIM_PX,
    WIDTH,
    T_world_camera,
    borders,
    jacobians,
    mirror_camera,
    rig_trial,
    scales,
    simulator,
    through_the_mirror,
    view_of,
)
from chapters.ch01_introduction.s1_1_panorama.report import name_values
from raxel.lab import room
from raxel.multiview import CylindricalView, cylindrical_view, resample, source_pixels
from repro.page import check, compared, open_results, show, show_code, value
from repro.run import Plan, crossed, experiment

# %% tags=["active-ipynb"]
# show("fig_1_1")

# %% tags=["active-ipynb"]
# name_values(open_results)

# %% [markdown]
# **Findings.**
#
# 1. **Upright edges and the horizon are straight in the panorama.** The camera's
#    rays alone make them so: no curve is fitted.
# 2. **Resolution varies strongly.** A panorama pixel of the top row covers
#    {glue:text}`ratio:.0f` times the source area of one in the bottom row.
# 3. **No mirror tried avoids the variation.** A lower panorama does: within
#    {glue:text}`band:.1f`° above and below the horizon the ratio stays below 1.5,
#    the limit of our test, in all mirrors.

# %% [markdown]
# | quantity | thesis | here |
# |---|---|---|
# | horizontal field of view | 360° (Fig. 1.1) | 360° |
# | resolution ratio (area) | varies, no number | {glue:text}`ratio:.0f` |
# | mirrors with a ratio below 1.5 | – | none of four |

# %% [markdown]
# ## Terms
#
# - *Panorama*, the thesis's *unwrapped image*: cylindrical projection of the scene.
# - *Source image*: the image that the camera takes in the mirror.
# - *Central camera*: all rays pass through one point (single viewpoint).
# - $\psi$, $\varphi$: angle of a direction from straight down; angle of its image
#   from the camera's axis.
# - $\alpha$, $\varepsilon$: azimuth; elevation above the horizon.
# - $e$, $a$, $b$: eccentricity and half axes of the hyperboloid.
# - *Resolution ratio*: source area of a panorama pixel in the top row, divided by
#   that in the bottom row.
# - *Rig*: a simulated camera with its mirror and targets, one file of `data/rigs`.
#
# A reader needs perspective projection and the Jacobian of a map.

# %% [markdown]
# ## What the thesis claims
#
# - A perspective camera has a limited and continuous field of view. Another design
#   removes that limit: Fig. 1.1(a) shows 360° in a single image.
# - Such cameras have drawbacks. The resolution of the unwrapped image, Fig. 1.1(b),
#   varies from top to bottom.

# %% [markdown]
# ## Model
#
# The camera looks straight up at a convex hyperboloid from one of its foci. Its rays,
# extended behind the mirror, then meet in the other focus: the system is central. A
# direction at $\psi$ appears in the camera at $\varphi$, with
#
# $$\tan\frac{\varphi}{2} = \frac{e-1}{e+1}\,\tan\frac{\psi}{2} .$$
#
# **Unwrapping.** A vertical cylinder of radius $f$ pixels surrounds the centre. It
# shows azimuth $\alpha$ and elevation $\varepsilon$ at
#
# $$u = u_0 + f\alpha, \qquad v = v_0 - f\tan\varepsilon ,$$
#
# with $u_0$ the column of azimuth 0 and $v_0$ the row of the horizon. Upright lines
# of the world become columns, and the horizon becomes a row. Each panorama pixel is
# projected into the source image and takes the colour there.

# %% tags=["active-ipynb"]
# show_code(CylindricalView, source_pixels)

# %% [markdown]
# **Resolution.** The map from panorama to source image has a Jacobian $J$. One
# panorama pixel covers $|\det J|$ source pixels. The lengths of the columns of $J$
# are the source pixels along a row and along a column.

# %% tags=["active-ipynb"]
# show_code(jacobians)

# %%
# A smaller image has fewer pixels in each direction; lens and room are the same.
SIZES = {"quick": 0.4, "full": 1.0}

# %% [markdown]
# ## Experiment
#
# The simulator renders a room full of straight edges in colour, with the noise and
# blur of a real camera. The rig is `data/rigs/panorama-hyperboloid.yaml`. The
# Jacobian is then computed in every row, for this mirror and for three others. They
# have the same edge in the world and in the image.


# %%
def image_trial(condition, rng):
    """Render the room, unwrap the image, detect its uprights."""
    lab = simulator(condition["size"])
    camera, view = lab.camera, view_of(lab.camera)
    image = lab.render(room(), T_world_camera(camera), rng, colour=True)
    unwrapped = resample(image, source_pixels(camera, view))
    row, columns = through_the_mirror(camera, view)
    return {
        "picture": image,
        "unwrapped": unwrapped,
        "horizon_px": view.horizon,
        "radius_px": view.radius,
        "highest_deg": np.degrees(view.elevations([0])[0]),
        "lowest_deg": np.degrees(view.elevations([view.height - 1])[0]),
        "spread_px": columns,
        "horizon_error_px": row,
        "borders": borders(unwrapped, camera, view),
    }


@experiment("fig_1_1_picture", artefact="fig_1_1", inputs=RIGS)
def image(effort):
    """The room in the mirror, and its panorama."""
    settings = {"rig": RIG, "size": "pixels each way, as a share"}
    return Plan(image_trial, [{"size": SIZES[effort]}], 1, settings)


def resolution_trial(condition, rng):
    """Scales in every row, and the ratio of the top row to the bottom."""
    camera = mirror_camera(condition["mirror"])
    # The rows of Fig. 1.1(b), for every mirror.
    rig = view_of(simulator(1.0).camera)
    view = cylindrical_view(camera, DOWN, AHEAD, WIDTH)
    view = view._replace(horizon=rig.horizon, height=rig.height)
    elevations = view.elevations(np.arange(rig.height))
    area, row, column = scales(camera, view, elevations)
    # Smallest band from -x to x degrees in which the ratio exceeds the limit.
    ends = np.radians(np.stack([BANDS_DEG, -BANDS_DEG]))
    top, bottom = (scales(camera, view, end)[0] for end in ends)
    wide = BANDS_DEG[top / bottom > MIN_RATIO]
    return {
        "eccentricity": camera.mirror.eccentricity,
        "elevation_deg": np.degrees(elevations),
        "area": area,
        "along_row": row,
        "along_column": column,
        "top": area[0],
        "bottom": area[-1],
        "ratio": area[0] / area[-1],
        "ratio_row": row[0] / row[-1],
        "ratio_column": column[0] / column[-1],
        "band_deg": wide[0] if len(wide) else np.nan,
    }


@experiment("ext_rigs", artefact="ext_rigs", inputs=RIG_FILES)
def ext_rigs(effort):
    """Poses of the targets of every rig."""
    conditions = [{"rig": name} for name in RIG_NAMES]
    return Plan(rig_trial, conditions, 1, {"seed": RIG_SEED})


@experiment("fig_1_1_resolution", artefact="fig_1_1", inputs=RIGS)
def resolution(effort):
    """Source pixels per panorama pixel, row by row, for each mirror."""
    settings = {
        "rig": RIG,
        "image_px": [WIDTH, HEIGHT],
        "rim_of_the_others_mm": RIM_MM,
        "rim_of_the_others_px": RIM_PX,
        "highest_elevation_of_the_others_deg": HIGHEST_DEG,
        "least_ratio": MIN_RATIO,
    }
    return Plan(resolution_trial, crossed(mirror=ECCENTRICITIES), 1, settings)


# %% [markdown]
# ## The simulated rigs
#
# A rig file gives a camera, its mirror and its targets. Each length has its unit, its
# origin and its reason. All rendered images of this report come from these rigs.
# `raxel show data/rigs/spherical.yaml` opens one in the browser, and `raxel render`
# renders images of its targets.

# %% tags=["active-ipynb"]
# show("ext_rigs")

# %% [markdown]
# ## Discussion
#
# - **The thesis's claim holds.** The variation exceeds the limit of our test by far.
#   Rings of different circumference become rows of one width.
# - **Top and bottom.** The bottom of the panorama is blurred, since it has few source
#   pixels. At the top the source image has more pixels than the panorama can show.
# - **The mirror.** The mirrors range from a paraboloid to the most open hyperboloid.
#   All ratios are of the same order, so the height of the panorama matters more.
# - **Orientation.** The source image is left-right reversed, the panorama is not.
# - **Generality.** Any calibrated central camera can be unwrapped in this way.
# - **Limits.** The thesis does not name the camera of its figure. The rig and its
#   mirror are our choice. All mirrors tried are central. A mirror designed for even
#   resolution is not central in general. The Jacobian counts pixels and ignores lens
#   blur.

# %% [markdown]
# ## Summary
#
# The rays of a central mirror camera turn its image into a panorama with straight
# uprights and a straight horizon. The resolution varies from top to bottom, as the
# thesis states, and none of the four mirrors tried avoids this. A panorama of
# small height has nearly even resolution.

# %% [markdown]
# ## Compared with the published numbers

# %% tags=["active-ipynb"]
# compared()

# %% tags=["active-ipynb"]
# value("lamp", EYE_HIGH_DEG)

# %% tags=["active-ipynb"]
# value("half_a", given()[0])

# %% tags=["active-ipynb"]
# value("half_b", given()[1])

# %% tags=["active-ipynb"]
# value("focal", given()[2])

# %% [markdown]
# ## Try it yourself
#
# Open this page as a notebook (`make lab`) and run all cells. Then put an
# answer in place of `None`, and run that cell again.
#
# **1.** A panorama on a cylinder is 1280 px wide and shows a full turn. How
# many rows are between the horizon and an elevation of 45°?

# %% tags=["active-ipynb"]
# check(None, **rows_task())

# %% [markdown]
# **2.** A light is at an elevation of {glue:text}`lamp:.0f`°. How far, in px, is its
# image from the middle of the full image of Fig. 1.1(a)? The mirror's half axes
# are $a$ = {glue:text}`half_a:.1f` and $b$ = {glue:text}`half_b:.1f` mm, with
# $e = \sqrt{a^2+b^2}/a$. The camera's focal length is {glue:text}`focal:.1f` px.

# %% tags=["active-ipynb"]
# check(None, **lamp_task())
