"""Every rig of data/rigs in three dimensions, a figure each."""

from chapters.guides.rigs.results import uses_of
from chapters.guides.rigs.trials import SEED
from chapters.shared.rigs import rig_named
from raxel.show.rigs import rig_scene
from repro.page.space import scene_figure
from repro.run.columns import columns
from repro.run.experiment import figures
from repro.run.outcomes import Check, Drawing

HEAD = (
    "view", "use", "x_mm", "y_mm", "z_mm", "distance_mm", "tilt_deg",
)  # fmt: skip
FRAME = (
    "In the frame of the camera: z ahead, y down. Blue: rays at the edge of "
    "the field of view, cut off at one length."
)
MIRROR = (
    " The camera sees the mirror along the grey lines, and its rays start "
    "where these end."
)
TWO_USES = " Rims: grey to calibrate with, orange to evaluate with."


@figures(
    (
        "ext_rig_active_grid_demo",
        "ext_rig_coolpix_4500_fce8_boards",
        "ext_rig_coolpix_4500_fce8",
        "ext_rig_coolpix_fce8_zoom_1",
        "ext_rig_coolpix_fce8_zoom_2",
        "ext_rig_coolpix_fce8_zoom_3",
        "ext_rig_d200_boards",
        "ext_rig_d200_fisheye",
        "ext_rig_d200_lens",
        "ext_rig_d200_lens_sharp",
        "ext_rig_fisheye_12x9",
        "ext_rig_fisheye_9x7",
        "ext_rig_flexible_mirror_a_monitor",
        "ext_rig_flexible_mirror_a",
        "ext_rig_flexible_mirror_b_monitor",
        "ext_rig_flexible_mirror_b",
        "ext_rig_flexible_mirror",
        "ext_rig_hyperboloidal",
        "ext_rig_kodak_boards",
        "ext_rig_kodak_megaplus",
        "ext_rig_large_fisheye",
        "ext_rig_large_hyperboloidal",
        "ext_rig_mirror_ball",
        "ext_rig_monitor_d200",
        "ext_rig_onevr_d70_boards",
        "ext_rig_onevr_d70",
        "ext_rig_ordinary_lens",
        "ext_rig_panorama_hyperboloid",
        "ext_rig_spherical",
    ),
    needs=("ext_rigs",),
    evidence="analytic",
    scene=True,
)
def drawn_rig(results, identifier):
    """The figure of a rig: picture, scene, and the poses as numbers."""
    name = identifier.removeprefix("ext_rig_").replace("_", "-")
    ran = results["ext_rigs"]
    poses, middles, distances, tilts = (
        ran.arrays(column, rig=name)[0]
        for column in (
            "T_camera_target", "middle_mm", "distance_mm", "tilt_deg",
        )
    )  # fmt: skip
    rig = rig_named(name)
    uses = uses_of(ran, name)
    scene = rig_scene(rig, SEED, poses)
    rows = [
        (view, use, *middle, distance, tilt)
        for view, (use, middle, distance, tilt) in enumerate(
            zip(uses, middles, distances, tilts, strict=True), 1
        )
    ]
    seen, whole = (int(ran.column(n, rig=name)[0]) for n in ("seen", "whole"))
    caption = f"{rig.summary[0].upper()}{rig.summary[1:]}. {FRAME}"
    caption += MIRROR if hasattr(rig.camera, "viewer") else ""
    caption += TWO_USES if rig.evaluate else ""
    return Drawing(
        scene_figure(scene, height_in=4.0),
        columns(HEAD, rows),
        caption,
        Check(
            seen == len(poses),
            f"in {seen} of {len(poses)} poses the target is in the picture, "
            f"whole in {whole}",
        ),
        scene,
    )
