"""The tables of the page of benchmarks."""

from __future__ import annotations

from chapters.guides.benchmarks.results import (
    _told,
    scored_rigs,
    worst_corner,
)
from chapters.guides.benchmarks.trials import DETECTORS, rig_names
from chapters.shared.rigs import rig_named
from raxel.sets import Chessboard
from repro.run.experiment import table
from repro.run.outcomes import Check, Table

NONE = "–"
ASKS = {
    "active-grid-demo": "decoder: place on a monitor, to a share of a px",
    "coolpix-fce8-zoom-1": "calibration: wide lens, moderate distortion",
    "coolpix-fce8-zoom-2": "calibration: boards bent by the lens",
    "coolpix-fce8-zoom-3": "detector: strong bending; no pinhole fits",
    "ordinary-lens": "the easy case, which nothing should fail",
    "panorama-hyperboloid": "detector: small, mirrored, bent boards",
}
CHECK_NAMES = {
    "area": "light of a turned sheet",
    "edge": "share of a pixel that an edge covers",
    "noise": "noise of an even picture",
}


@table(
    "ext_benchmarks",
    needs=("ext_benchmark_scores",),
    evidence="synthetic",
)
def ext_benchmarks(results):
    """Every rig, what it asks, and today's scores where it was scored."""
    result = results["ext_benchmark_scores"]
    rows = [_rig_row(name, result) for name in rig_names()]
    return Table(
        {key: [row[key] for row in rows] for key in rows[0]},
        "The rigs of data/rigs as benchmarks. Detectors: right boards of all, "
        "and the RMS error of their corners. Cameras: RMS angle between rays "
        "and true rays, on the pixels that the general camera has a ray for, "
        "calibrated with the corners of the first detector; where one "
        "calibration fails, neither camera is scored. Views: of a set "
        f"made by raxel render; scored were {result.settings['views']} of "
        "each rig that has scores.",
    )


def _rig_row(name, result):
    rig = rig_named(name)
    target = "monitor"
    if isinstance(rig.target, Chessboard):
        target = f"{rig.target.columns} x {rig.target.rows} corners"
    row = {
        "Rig": name,
        "Camera": rig.camera.kind,
        "Target": target,
        "Views": rig.count + rig.evaluate,
        "Size (px)": f"{rig.camera.width} x {rig.camera.height}",
        "What it asks": ASKS.get(name, NONE),
    }
    scored = name in scored_rigs(result)
    views = result.settings["views"]
    for one in DETECTORS:
        said = NONE
        if scored:
            right = int(result.column(f"{one}.right", rig=name)[0])
            rms = result.column(f"{one}.rms_px", rig=name)[0]
            said = f"{right} of {views}"
            if right:
                said += f", {rms:.2g}"
        row[f"{one}: right, RMS (px)"] = said
    for model in ("zhang", "general"):
        said = NONE
        if scored:
            angle = result.column(f"{model}.rms_deg", rig=name)[0]
            said = _told(angle)
        row[f"{model.capitalize()} (deg)"] = said
    return row


@table(
    "ext_lab_accuracy",
    needs=("ext_lab_accuracy_checks", "ext_lab_rendering"),
    evidence="synthetic",
)
def ext_lab_accuracy(results):
    """Errors of rendered corners for each camera; photometry against forms."""
    result = results["ext_lab_accuracy_checks"]
    rows = []
    for condition in result.conditions:
        check = condition["check"]
        rows.append(
            {
                "Checked": condition.get("camera") or CHECK_NAMES[check],
                "Against": "projection of corners"
                if check == "corners"
                else "closed form",
                "Unit": "px" if check == "corners" else "1",
                "RMS error": float(result.column("rms", **condition)[0]),
                "Largest error": float(
                    result.column("largest", **condition)[0]
                ),
            }
        )
    aim, worst = result.settings["aim_px"], worst_corner(result)
    return Table(
        {key: [row[key] for row in rows] for key in rows[0]},
        "What the laboratory renders against what it should. Cameras: corners "
        "of pictures without lens and noise, fitted by areas. Photometry: as "
        "shares of light, of a pixel, and of the spread.",
        Check(
            worst < aim,
            f"largest corner error {worst:.3g} px; the aim is {aim} px",
        ),
    )
