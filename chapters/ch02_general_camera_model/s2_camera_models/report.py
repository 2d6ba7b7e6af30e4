"""Results of this page read: values of the prose, figures, tables, judgements."""

import numpy as np

from chapters.ch02_general_camera_model.s2_camera_models.experiment import (
    FOVS_DEG,
    ROOM,
)
from chapters.shared.general import ZOO, camera
from repro.page import new_figure, value
from repro.run import Drawing, Reading, claim, columns, figure

# Numbers of section 2.2 for its claim and its prose.


def name_values(open_results):
    """Name the numbers that the prose of the page quotes."""
    shares = feasible_shares(open_results("exp_c2_fov180"))
    found = {
        "cameras": len(ZOO),
        "not_central": sum(not camera(name).central for name in ZOO),
        "kb": camera("Kannala-Brandt, complete").parameters,
        "cubic": camera("rational cubic").parameters,
        "table_size": camera("look-up table").parameters,
        # The largest field of view with a plane in front of all rays.
        "plane_fov": np.array(FOVS_DEG)[shares == 1].max(),
    }
    for name, number in found.items():
        value(name, number)


def feasible_shares(result):
    """Return the share of trials with a plane, for every field of view (fov,)."""
    return np.array([result.column("feasible", fov_deg=fov).mean() for fov in FOVS_DEG])


def free_of_cubics(coordinates):
    """Return the number of free parameters of two ratios of cubics.

    coordinates: 3 for cubics of (X, Y, Z) with all lower terms, 2 for
    those of (X / Z, Y / Z).
    """
    return 4 * {3: 20, 2: 10}[coordinates] - 2


# Images of a room by eight cameras of the collection.


@figure("ext_zoo_room", needs=("exp_zoo_room",), evidence="rendered")
def ext_zoo_room(results):
    """Draw the same room as seen by eight cameras."""
    ran = results["exp_zoo_room"]
    drawn, axes = new_figure(2, 4, height_in=4.3)
    rows = []
    for panel, name in zip(axes.flat, ROOM, strict=True):
        panel.imshow(ran.arrays("picture", model=name)[0])
        panel.set_title(name, fontsize=8.5)
        panel.set_axis_off()
        rows.append((name, *ran.column(("mean", "seen"), model=name)[:, 0]))
    return Drawing(
        drawn,
        columns(("model", "mean_radiance", "share_lit"), rows),
        "Rendered images of one room by eight cameras at its centre. The "
        "camera of the hyperboloid mirror looks up; that of the plane mirrors "
        "has the room's windows behind it.",
    )


# The claim of section 2.2.2: no plane in front of 180 degrees.


@claim("c2_fov180", needs=("exp_c2_fov180",), evidence="analytic")
def judge_fov180(results):
    """Infeasible from 180 degrees on, feasible below, in every trial."""
    shares = feasible_shares(results["exp_c2_fov180"])
    below = np.array(FOVS_DEG) < 180
    verdict = "differs"
    if not np.isfinite(shares).all():
        verdict = "undecided"
    elif (shares[below] == 1).all() and (shares[~below] == 0).all():
        verdict = "reproduced"
    feasible = [fov for fov, share in zip(FOVS_DEG, shares, strict=True) if share > 0]
    reason = "share of trials with a plane: " + ", ".join(
        f"{share:.2f} at {fov} deg" for fov, share in zip(FOVS_DEG, shares, strict=True)
    )
    if verdict == "reproduced":
        reason = (
            "with both ends of a diameter of the rim among the rays, the "
            "programme has no solution from 180 deg on"
        )
    return Reading(
        verdict,
        "a plane up to "
        f"{max(feasible, default=0)} deg, none from "
        f"{min((f for f in FOVS_DEG if f not in feasible), default=0)} "
        "deg on",
        reason=reason,
    )
