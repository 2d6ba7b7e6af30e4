"""The tables of the page of benchmarks."""

from chapters.guides.benchmarks.results import FAILED, scored_rigs, worst_corner
from chapters.guides.benchmarks.trials import DETECTORS, rig_names
from chapters.shared import detector_counts
from chapters.shared.rigs import rig_named
from raxel.sets import Chessboard
from repro.run.columns import cell, columns, in_columns
from repro.run.experiment import table
from repro.run.outcomes import Check, Table

ASKS = {
    "active-grid-demo": "decoder: place on a monitor, to a share of a px",
    "coolpix-4500-fce8": "calibration: a fisheye whose pupil moves, ten monitors",
    "coolpix-4500-fce8-boards": "correction: boards before the same camera",
    "coolpix-4500-fce8-boards-small": "the same, with fewer pixels",
    "coolpix-4500-fce8-small": "as coolpix-4500-fce8, with fewer pixels",
    "coolpix-4500-fce8-turned-small": "the same, its lens moved between the grids",
    "coolpix-fce8-zoom-1": "calibration: wide lens, moderate distortion",
    "coolpix-fce8-zoom-2": "calibration: boards bent by the lens",
    "coolpix-fce8-zoom-3": "detector: strong bending; no pinhole fits",
    "d200-boards": "calibration: a zoom whose distortion turns back",
    "d200-boards-small": "the same, with fewer pixels",
    "d200-fisheye": "decoder: a fisheye before a monitor",
    "d200-fisheye-small": "the same, with fewer pixels",
    "d200-lens": "decoder beside localiser: one monitor, both targets",
    "d200-lens-sharp": "as d200-lens, with sharper edges",
    "d200-lens-sharp-small": "the same, with fewer pixels",
    "d200-lens-small": "as d200-lens, with fewer pixels",
    "fisheye-12x9": "detector: bent boards in shadow",
    "fisheye-9x7": "detector: bent boards in shadow",
    "flexible-mirror": "detector: boards bent by a mirror of no simple form",
    "flexible-mirror-a": "calibration: a mirror that is bent in stages",
    "flexible-mirror-a-monitor": "its first shape: a monitor in two places",
    "flexible-mirror-a-monitor-small": "the same, with fewer pixels",
    "flexible-mirror-a-small": "as flexible-mirror-a, with fewer pixels",
    "flexible-mirror-b": "the same, nearer to a shorter mirror",
    "flexible-mirror-b-monitor": "its first shape: a monitor in two places",
    "flexible-mirror-b-monitor-small": "the same, with fewer pixels",
    "flexible-mirror-b-small": "as flexible-mirror-b, with fewer pixels",
    "hyperboloidal": "detector: glare and dirt on a mirror",
    "kodak-boards": "calibration: the camera of kodak-megaplus",
    "kodak-boards-small": "the same, with fewer pixels",
    "kodak-megaplus": "pose: a monitor far from a perspective camera",
    "kodak-megaplus-small": "the same, with fewer pixels",
    "large-fisheye": "detector: a large grid without a border",
    "large-hyperboloidal": "detector: a large grid without a border",
    "mirror-ball": "decoder: a monitor in pieces",
    "mirror-ball-small": "the same, with fewer pixels",
    "monitor-d200": "decoder: grids near, far, turned; localiser of corners",
    "monitor-d200-small": "the same, with fewer pixels",
    "onevr-d70": "calibration: a mirror a mm off its place, six monitors",
    "onevr-d70-aligned-small": "the same, aligned, with fewer pixels",
    "onevr-d70-boards": "correction: boards before the same camera",
    "onevr-d70-boards-small": "the same, with fewer pixels",
    "onevr-d70-double-small": "as onevr-d70-small, twice as far off",
    "onevr-d70-half-small": "as onevr-d70-small, half as far off",
    "onevr-d70-small": "as onevr-d70, with fewer pixels",
    "onevr-d70-turned-small": "the same, its lens moved between the grids",
    "ordinary-lens": "the easy case, which nothing should fail",
    "panorama-hyperboloid": "detector: small, mirrored, bent boards",
    "spherical": "detector: dim light and flaws in a ball",
}
CAMERAS = {"zhang": "Zhang", "opencv_fisheye": "OpenCV fisheye", "general": "Generic"}
CHECK_NAMES = {
    "area": "light of a turned sheet",
    "edge": "share of a pixel that an edge covers",
    "noise": "noise of an even picture",
}


@table("ext_benchmarks", needs=("ext_benchmark_scores",), evidence="rendered")
def ext_benchmarks(results):
    """Today's scores on the rigs that are scored."""
    result = results["ext_benchmark_scores"]
    return Table(
        in_columns(_score_row(name, result) for name in scored_rigs(result)),
        "Rigs of data/rigs with scores. Detectors: boards right, and the RMS "
        "error of their corners. Cameras: RMS angle between rays and true "
        "rays, on the pixels that the generic camera has a ray for, "
        "calibrated with the corners of the first detector. Image circle: the "
        "pixels that truly have a ray, which is the whole picture unless the "
        "lens leaves its corners dark; with a ray: of the generic camera.",
    )


def _score_row(name, result):
    def of(value):
        return result.column(value, rig=name)[0]

    row = {"Rig": name, "Boards": int(result.settings["views"])}
    for one in DETECTORS:
        title = detector_counts.DETECTORS[one]
        row[f"{title}: right"] = int(of(f"{one}.right"))
        row[f"{title} (px)"] = cell(of(f"{one}.rms_px"))
    for model, title in CAMERAS.items():
        row[f"{title} (deg)"] = cell(of(f"{model}.rms_deg")) or FAILED
    share = cell(100 * of("general.share_with_ray"))
    return row | {"Image circle with a ray (%)": share}


@table("ext_benchmarks_further", needs=("ext_benchmark_scores",), evidence="analytic")
def ext_benchmarks_further(results):
    """Rigs without scores here, and what each one asks."""
    scored = scored_rigs(results["ext_benchmark_scores"])
    return Table(
        in_columns(_rig_row(name) for name in rig_names() if name not in scored),
        "The other rigs of data/rigs: not scored on this page. Views: of a "
        "set made by raxel render.",
    )


def _rig_row(name):
    rig = rig_named(name)
    board = rig.target if isinstance(rig.target, Chessboard) else None
    return {
        "Rig": name,
        "Camera": rig.camera.kind,
        "Target": f"{board.columns} x {board.rows} corners" if board else "monitor",
        "Views": rig.count + rig.evaluate,
        "Size (px)": f"{rig.camera.width} x {rig.camera.height}",
        "What it asks": ASKS[name],
    }


@table(
    "ext_detector_counts",
    needs=(
        "table_3_4_grids",
        "table_3_5_grids",
        "table_3_6_grids",
        "table_3_7_grids",
        "ext_detector_record",
    ),
    evidence="photograph",
)
def ext_detector_counts(results):
    """Boards right and wrong on the rendered sets, and on photographs."""
    record = results[detector_counts.RECORD]
    return Table(
        detector_counts.count_columns(detector_counts.every_count(results)),
        "Whole boards that three detectors return, told the number of corners "
        "and nothing else, on rendered pictures and on photographs, as each "
        "row says. Rendered: the sets of 3.3.2, all seeds; right is "
        "every corner within 8 px of its place. Photographs: a record of "
        f"{record.settings['date']} with OpenCV "
        f"{record.settings['opencv']}, which the build does not make again "
        "(data/records); right is every corner within the tolerance of its "
        "reference. The others were refused.",
    )


@table(
    "ext_lab_accuracy",
    needs=("ext_lab_accuracy_checks", "ext_lab_rendering"),
    evidence="synthetic",
)
def ext_lab_accuracy(results):
    """Errors of rendered corners for each camera; photometry against forms."""
    result = results["ext_lab_accuracy_checks"]
    rows = [
        (condition.get("camera"), "projection of corners", "px")
        if condition["check"] == "corners"
        else (CHECK_NAMES[condition["check"]], "closed form", "1")
        for condition in result.conditions
    ]
    errors = {
        title: result.select().column(name).tolist()
        for title, name in (("RMS error", "rms"), ("Largest error", "largest"))
    }
    aim, worst = result.settings["aim_px"], worst_corner(result)
    return Table(
        columns(("Checked", "Against", "Unit"), rows) | errors,
        "What the laboratory renders against what it should. Cameras: corners "
        "of pictures without lens and noise, fitted by areas. Photometry: as "
        "shares of light, of a pixel, and of the spread.",
        Check(worst < aim, f"largest corner error {worst:.3g} px; the aim is {aim} px"),
    )
