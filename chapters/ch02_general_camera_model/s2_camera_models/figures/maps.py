"""Tables and figures of the camera zoo."""

from __future__ import annotations

import numpy as np

from chapters.ch02_general_camera_model.s2_camera_models.trials import (
    FAMILIES,
    LENSES,
    PLANE_ANGLE,
    ROOM,
)
from chapters.shared.zoo import ZOO
from repro.page.style import SERIES, series
from repro.page.style import figure as new_figure
from repro.run.columns import columns
from repro.run.experiment import figure, table
from repro.run.outcomes import Check, Drawing, Table

# Rounding: an error that is smaller counts as none.
NONE_PX = 1e-6
NONE_MM = 1e-9
PANELS = {
    "In the image plane": (
        "radial",
        "division",
        "field of view",
    ),
    "Fisheye laws": (
        "equidistance",
        "equisolid angle",
        "stereographic",
        "Micusik-Pajdla, rational",
        "Micusik-Pajdla, sine",
        "Kannala-Brandt, symmetric",
    ),
    "Mirrors and general": (
        "Tardif",
        "Scaramuzza",
        "unified sphere",
        "hyperboloid mirror",
        "paraboloid mirror",
        "ellipsoid mirror",
        "spherical mirror",
    ),
}
CURVES = tuple(name for names in PANELS.values() for name in names)


@table("ext_zoo", needs=("exp_zoo",), evidence="analytic")
def ext_zoo(results):
    """Counts and measures of every camera."""
    ran = results["exp_zoo"]

    def column(name):
        return [ran.column(name, model=model)[0] for model in ZOO]

    ends = column("model_end_deg")
    trips = np.array(column("round_trip_px"))
    returned = np.array(column("returned"))
    centres = np.array(column("centrality_mm"))
    central = np.array([c < NONE_MM for c in centres])
    said = np.array(
        [ran.texts("central", model=m)[0] for m in ZOO], dtype=bool
    )
    return Table(
        {
            "model": list(ZOO),
            "section": [model.section for model in ZOO.values()],
            "kind in the library": [
                ran.texts("kind", model=m)[0] for m in ZOO
            ],
            "parameters": [int(n) for n in column("parameters")],
            "central": ["yes" if c else "no" for c in said],
            "projects": [
                "yes" if ran.texts("projects", model=m)[0] else "no"
                for m in ZOO
            ],
            "widest ray (deg)": [f"{x:.1f}" for x in column("widest_deg")],
            "law ends (deg)": [
                f"{x:.1f}" if np.isfinite(x) else "" for x in ends
            ],
            "from central (mm)": [
                "0" if x < NONE_MM else f"{x:.3g}" for x in centres
            ],
            "round trip (px)": [f"{x:.0e}" for x in trips],
        },
        "One example camera of every model, 200 × 200 pixels. Widest ray: "
        "from the middle ray, within the image. Law ends: where the formula "
        "with the example's parameters stops. From central: smallest RMS "
        "distance of the rays from one point. Round trip: largest distance "
        "of a pixel from the projection of a point on its ray.",
        Check(
            bool(
                (returned == 1).all()
                and (trips < NONE_PX).all()
                and (central == said).all()
            ),
            f"{100 * returned.min():.3g} % of the pixels come back (least "
            f"of all cameras), to {trips.max():.1g} px, and just the cameras "
            "that say so are central",
        ),
    )


@table(
    "ext_zoo_scope",
    needs=("exp_zoo", "exp_zoo_mirrors"),
    evidence="analytic",
)
def ext_zoo_scope(results):
    """What each model can and cannot represent, with how many numbers."""
    ran, mirrors = results["exp_zoo"], results["exp_zoo_mirrors"]
    worst = max(
        mirrors.column("rms_px", **one)[0] for one in mirrors.conditions
    )
    return Table(
        {
            "model": list(ZOO),
            "parameters": [
                int(ran.column("parameters", model=m)[0]) for m in ZOO
            ],
            "represents": [model.can for model in ZOO.values()],
            "does not represent": [m.cannot for m in ZOO.values()],
        },
        "What each model can and cannot represent. Parameters are those of "
        "the example camera.",
        Check(
            bool(worst < NONE_PX),
            f"the unified sphere is each central mirror, to {worst:.1g} px",
        ),
    )


@figure("ext_zoo_curves", needs=("exp_zoo_curves",), evidence="analytic")
def ext_zoo_curves(results):
    """r(theta) of the round cameras, at the same scale on the axis."""
    ran = results["exp_zoo_curves"]
    drawn, axes = new_figure(1, 3, height_in=4.6, sharey=True)
    rows = []
    for panel, (title, names) in zip(axes, PANELS.items(), strict=True):
        grid = np.linspace(0, np.radians(125), 50)
        for index, name in enumerate(names):
            theta, r = (
                ran.arrays(part, model=name)[0] for part in ("theta", "r")
            )
            look = series(index) | {"marker": "", "lw": 1.4}
            panel.plot(np.degrees(theta), r, label=name, **look)
            rows += [
                (name, *cells)
                for cells in zip(np.degrees(theta), r, strict=True)
            ]
        tangent = grid[grid < 1.24]
        panel.plot(
            np.degrees(tangent),
            np.tan(tangent),
            color="#9aa5b1",
            lw=0.9,
            ls="-",
            marker="",
            label="pinhole",
        )
        panel.axvline(90, color="#9aa5b1", lw=0.8, ls=":", marker="")
        panel.set(xlim=(0, 125), ylim=(0, 2.6), title=title)
        panel.set_xlabel("Angle θ (deg)")
        panel.set_xticks([0, 30, 60, 90, 120])
        panel.legend(
            loc="upper center",
            bbox_to_anchor=(0.5, -0.2),
            fontsize=7.5,
            frameon=False,
        )
    axes[0].set_ylabel("Radius r / r′(0) (1)")
    return Drawing(
        drawn,
        columns(("model", "theta_deg", "r"), rows),
        "Projection curves $r(\\theta)$ of the radially symmetric example "
        "cameras, drawn from the rays of a row of pixels, at equal slope on "
        "the axis. Grey: the pinhole. The mirrors' angles count from the "
        "direction back to the viewer.",
    )


def fits_of(result, lens, family):
    """Free parameters (n,) and rms (n,) px of a family's fits."""
    rows = [
        c
        for c in result.conditions
        if c["lens"] == lens and c["family"] == family
    ]
    free = [result.column("free", **row)[0] for row in rows]
    rms = [result.column("rms_px", **row)[0] for row in rows]
    return np.array(free), np.array(rms)


@figure("ext_zoo_fits", needs=("exp_zoo_fits",), evidence="synthetic")
def ext_zoo_fits(results):
    """Every round model fitted to two lenses: error and parameters."""
    ran = results["exp_zoo_fits"]
    drawn, axes = new_figure(1, 2, height_in=5.0, sharey=True, sharex=True)
    rows = []
    falls = True
    for panel, lens in zip(axes, LENSES, strict=True):
        for index, family in enumerate(FAMILIES):
            free, rms = fits_of(ran, lens, family)
            plane = FAMILIES[family][0] == PLANE_ANGLE
            falls &= bool((np.diff(rms) <= NONE_PX).all())
            # Points that would hide each other stand side by side.
            shift = 0.05 * (index - 5.5)
            look = series(index) | {"linestyle": ":" if plane else "-"}
            look["mfc"] = "white" if plane else look["color"]
            if index >= len(SERIES):
                look["marker"] = "<>*ph"[index - len(SERIES)]
            panel.plot(
                free + shift,
                np.maximum(rms, NONE_PX),
                label=family + (" (70°)" if plane else ""),
                lw=1.0,
                **look,
            )
            to_deg = np.degrees(FAMILIES[family][0])
            rows += [
                (lens, family, int(n), error, to_deg)
                for n, error in zip(free, rms, strict=True)
            ]
        panel.set(yscale="log", title=f"Lens: {lens}")
        panel.set_xlabel("Free radial parameters (1)")
        panel.set_xticks(range(1, 6))
    axes[0].set_ylabel("RMS radius error (px)")
    handles, labels = axes[0].get_legend_handles_labels()
    drawn.legend(
        handles, labels, loc="outside lower center", ncols=3, fontsize=8
    )
    return Drawing(
        drawn,
        columns(("lens", "model", "free", "rms_px", "to_deg"), rows),
        "Every radially symmetric model fitted to two lenses of 183°: RMS "
        "error of the radius against the number of radial parameters (centre, "
        "aspect and skew are not counted). Open markers: models of the "
        "image plane, fitted up to 70° only. Errors below $10^{-6}$ px "
        "are drawn there: the model contains the lens. Models with equally "
        "many parameters are drawn side by side.",
        Check(falls, "more terms never fit worse"),
    )


@figure("ext_zoo_room", needs=("exp_zoo_room",), evidence="rendered")
def ext_zoo_room(results):
    """The same room through eight cameras."""
    ran = results["exp_zoo_room"]
    drawn, axes = new_figure(2, 4, height_in=4.3)
    rows = []
    for panel, name in zip(axes.flat, ROOM, strict=True):
        panel.imshow(ran.arrays("picture", model=name)[0])
        panel.set_title(name, fontsize=8.5)
        panel.set_axis_off()
        cells = (
            ran.column(what, model=name)[0] for what in ("mean", "seen")
        )
        rows.append((name, *cells))
    return Drawing(
        drawn,
        columns(("model", "mean_radiance", "share_lit"), rows),
        "The same room from its middle, through eight cameras. The viewer of "
        "the hyperboloid mirror looks up; that of the plane mirrors has the "
        "room's windows behind it.",
    )
