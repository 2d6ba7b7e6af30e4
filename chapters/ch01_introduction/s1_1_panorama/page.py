# %% [markdown]
# # 1.1.2 A panorama and its unwrapping
#
# **Question.** A camera below a curved mirror sees all around at once. Its
# picture can be turned into a panorama that people read easily. What does
# the panorama cost?

# %%
import numpy as np

from chapters.ch01_introduction.s1_1_panorama.exercises import (
    EYE_HIGH_DEG,
    given,
    lamp_task,
    rows_task,
)
from chapters.ch01_introduction.s1_1_panorama.results import name_values
from chapters.ch01_introduction.s1_1_panorama.trials import (
    AHEAD,
    BANDS_DEG,
    DOWN,
    ECCENTRICITIES,
    HEIGHT,
    HIGHEST_DEG,
    LEAST_RATIO,
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
    laboratory,
    mirror_camera,
    rig_trial,
    scales,
    through_the_mirror,
    view_of,
)
from raxel.lab import room
from raxel.multiview.cylindrical_view import CylindricalView, cylindrical_view
from raxel.multiview.perspective_view import resample, source_pixels
from repro.page.exercise import check
from repro.page.reader import compared, open_results, show, show_code, value
from repro.run.experiment import experiment
from repro.run.outcomes import Plan, crossed

# %% tags=["active-ipynb"]
# show("fig_1_1")

# %% tags=["active-ipynb"]
# name_values(open_results)

# %% [markdown]
# **Findings.**
#
# - One picture holds the room all around, from {glue:text}`low:.0f`° below
#   the horizon to {glue:text}`high:.0f`° above it.
# - Upright edges and the horizon come out straight in the panorama. No curve
#   was fitted for that: the rays alone do it.
# - The price is resolution. A pixel of the panorama's top row is made of
#   {glue:text}`ratio:.0f` times as much of the picture as one of its bottom
#   row.
# - None of the mirrors tried avoids that. A lower panorama does.

# %% [markdown]
# ## What the thesis claims
#
# - A perspective camera has a field of view that is limited and in one
#   piece. Another design lifts that limit: Fig. 1.1(a) shows all 360° in a
#   single picture.
# - Such cameras have drawbacks of their own. The resolution of the
#   unwrapped picture, Fig. 1.1(b), varies from top to bottom.

# %% [markdown]
# ## Model
#
# The camera looks straight up at a convex hyperboloid. It stands at one
# focus of the hyperboloid, and then all its rays, continued behind the
# mirror, meet in the other: the system has a single centre. A direction at
# the angle $\psi$ from straight down is seen by the camera at the angle
# $\varphi$ from its axis, with
#
# $$\tan\frac{\varphi}{2} = \frac{e-1}{e+1}\,\tan\frac{\psi}{2}$$
#
# where $e$ is the eccentricity of the mirror.
#
# **Unwrapping.** An upright cylinder stands around the centre, $f$ pixels
# in radius. It shows azimuth $\alpha$ and elevation $\varepsilon$ at
#
# $$u = u_0 + f\alpha, \qquad v = v_0 - f\tan\varepsilon .$$
#
# Upright lines of the world become columns, the horizon becomes a row. Each
# pixel of the panorama asks the camera where its direction was seen, and
# takes the colour there.

# %% tags=["active-ipynb"]
# show_code(CylindricalView, source_pixels)

# %% [markdown]
# **Resolution.** From the unwrapped to the source picture there is a map,
# and its Jacobian $J$ says what one unwrapped pixel is made of: an area of
# $|\det J|$ source pixels. The lengths of its columns are the source pixels
# along a row and along a column.

# %% tags=["active-ipynb"]
# show_code(jacobians)

# %%
# A smaller picture has fewer pixels each way; lens and room are the same.
SIZES = {"quick": 0.4, "full": 1.0}


# %% [markdown]
# ## Experiment
#
# The virtual laboratory takes the picture, in colour and with the noise and
# blur of a real camera, in its room full of straight edges. The rig is
# `data/rigs/panorama-hyperboloid.yaml`. Then the Jacobian is computed in
# every row: for that mirror, and for others with the same rim in the world
# and in the picture.


# %%
def picture_trial(condition, rng):
    """Photograph the room, unwrap the picture, look for its verticals."""
    lab = laboratory(condition["size"])
    camera, view = lab.camera, view_of(lab.camera)
    picture = lab.photograph(room(), T_world_camera(camera), rng, colour=True)
    unwrapped = resample(picture, source_pixels(camera, view))
    row, columns = through_the_mirror(camera, view)
    return {
        "picture": picture,
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
def picture(effort):
    """The room in the mirror, and the picture unwrapped."""
    settings = {"rig": RIG, "size": "pixels each way, as a share"}
    return Plan(picture_trial, [{"size": SIZES[effort]}], 1, settings)


def resolution_trial(condition, rng):
    """Scales in every row, and the ratio of the top row to the bottom."""
    camera = mirror_camera(condition["mirror"])
    # The rows of Fig. 1.1(b), for every mirror.
    rig = view_of(laboratory(1.0).camera)
    view = cylindrical_view(camera, DOWN, AHEAD, WIDTH)
    view = view._replace(horizon=rig.horizon, height=rig.height)
    elevations = view.elevations(np.arange(rig.height))
    area, row, column = scales(camera, view, elevations)
    # A horizontal band from -x to x degrees: where does 1.5 begin?
    ends = np.radians(np.stack([BANDS_DEG, -BANDS_DEG]))
    top, bottom = (scales(camera, view, end)[0] for end in ends)
    wide = BANDS_DEG[top / bottom > LEAST_RATIO]
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
    """Source pixels per unwrapped pixel, row by row, for each mirror."""
    settings = {
        "rig": RIG,
        "image_px": [WIDTH, HEIGHT],
        "rim_of_the_others_mm": RIM_MM,
        "rim_of_the_others_px": RIM_PX,
        "highest_elevation_of_the_others_deg": HIGHEST_DEG,
        "least_ratio": LEAST_RATIO,
    }
    return Plan(resolution_trial, crossed(mirror=ECCENTRICITIES), 1, settings)


# %% [markdown]
# ## Reading and limits
#
# - **Left and right.** The picture in the mirror is left-right reversed, as
#   one who looks up at it would see it. The panorama is not: it is made of
#   rays.
# - **Any central camera** can be unwrapped so, once it is calibrated.
# - **The resolution varies by far more than the test asks.** Along the
#   rows that is because rings of the picture become rows of one width. The
#   bottom is blurred for want of pixels, and at the top the picture has
#   more of them than the panorama can show.
# - **No mirror tried avoids it.** From the paraboloid to the most open
#   hyperboloid the ratio goes from {glue:text}`least:.0f` to
#   {glue:text}`most:.0f`. The height of the panorama counts for more: in a
#   strip from the horizon up and down by less than
#   {glue:text}`band:.1f`° the ratio stays below {glue:text}`limit:.1f`.
# - **Limits.** The thesis does not name the camera of its figure. Here it
#   is a laboratory camera, with a mirror that this report chose. All
#   mirrors tried are central; one can be designed for even resolution, and
#   then has no single centre in general. Lens blur is not part of the
#   Jacobian: it counts pixels, not detail.

# %% [markdown]
# ## The rigs of the laboratory
#
# A rig is a file of `data/rigs`: a camera, its mirror and its targets, each
# length with its unit, its origin and its reason. All rendered images of this
# report come from these rigs. `raxel show data/rigs/spherical.yaml` opens one
# in the browser, and `raxel render` photographs its targets.

# %% tags=["active-ipynb"]
# show("ext_rigs")

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
# many rows lie between the horizon and 45° of elevation?

# %% tags=["active-ipynb"]
# check(None, **rows_task())

# %% [markdown]
# **2.** How far from the middle of the full picture of Fig. 1.1(a), in px,
# is a lamp at {glue:text}`lamp:.0f`° of elevation? The mirror's half axes
# are $a$ = {glue:text}`half_a:.1f` and $b$ = {glue:text}`half_b:.1f` mm,
# $e = \sqrt{a^2+b^2}/a$, and the camera a focal length of
# {glue:text}`focal:.1f` px.

# %% tags=["active-ipynb"]
# check(None, **lamp_task())
