"""Every rig of data/rigs in three dimensions, a figure each."""

from chapters.guides.rigs.results import uses_of
from chapters.guides.rigs.trials import SEED
from chapters.shared.rigs import rig_named
from raxel.show.rigs import rig_scene
from repro.page.space import draw_scene
from repro.page.style import figure as new_figure
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Check, Drawing

HEIGHT_IN = 4.0
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


def drawn_rig(results, name):
    """The figure of a rig: picture, scene, and the poses as numbers."""
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
    drawn, axes = new_figure(height_in=HEIGHT_IN)
    drawn.set_layout_engine("none")
    axes.set_position([0.0, 0.0, 1.0, 1.0])
    draw_scene(axes, scene)
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
        drawn,
        columns(HEAD, rows),
        caption,
        Check(
            seen == len(poses),
            f"in {seen} of {len(poses)} poses the target is in the picture, "
            f"whole in {whole}",
        ),
        scene,
    )


@figure(
    "ext_rig_active_grid_demo", needs=("ext_rigs",), evidence="analytic", scene=True
)
def ext_rig_active_grid_demo(results):
    """The rig active-grid-demo."""
    return drawn_rig(results, "active-grid-demo")


@figure(
    "ext_rig_coolpix_4500_fce8_boards",
    needs=("ext_rigs",),
    evidence="analytic",
    scene=True,
)
def ext_rig_coolpix_4500_fce8_boards(results):
    """The rig coolpix-4500-fce8-boards."""
    return drawn_rig(results, "coolpix-4500-fce8-boards")


@figure(
    "ext_rig_coolpix_4500_fce8", needs=("ext_rigs",), evidence="analytic", scene=True
)
def ext_rig_coolpix_4500_fce8(results):
    """The rig coolpix-4500-fce8."""
    return drawn_rig(results, "coolpix-4500-fce8")


@figure(
    "ext_rig_coolpix_fce8_zoom_1", needs=("ext_rigs",), evidence="analytic", scene=True
)
def ext_rig_coolpix_fce8_zoom_1(results):
    """The rig coolpix-fce8-zoom-1."""
    return drawn_rig(results, "coolpix-fce8-zoom-1")


@figure(
    "ext_rig_coolpix_fce8_zoom_2", needs=("ext_rigs",), evidence="analytic", scene=True
)
def ext_rig_coolpix_fce8_zoom_2(results):
    """The rig coolpix-fce8-zoom-2."""
    return drawn_rig(results, "coolpix-fce8-zoom-2")


@figure(
    "ext_rig_coolpix_fce8_zoom_3", needs=("ext_rigs",), evidence="analytic", scene=True
)
def ext_rig_coolpix_fce8_zoom_3(results):
    """The rig coolpix-fce8-zoom-3."""
    return drawn_rig(results, "coolpix-fce8-zoom-3")


@figure("ext_rig_d200_boards", needs=("ext_rigs",), evidence="analytic", scene=True)
def ext_rig_d200_boards(results):
    """The rig d200-boards."""
    return drawn_rig(results, "d200-boards")


@figure("ext_rig_d200_fisheye", needs=("ext_rigs",), evidence="analytic", scene=True)
def ext_rig_d200_fisheye(results):
    """The rig d200-fisheye."""
    return drawn_rig(results, "d200-fisheye")


@figure("ext_rig_d200_lens", needs=("ext_rigs",), evidence="analytic", scene=True)
def ext_rig_d200_lens(results):
    """The rig d200-lens."""
    return drawn_rig(results, "d200-lens")


@figure("ext_rig_d200_lens_sharp", needs=("ext_rigs",), evidence="analytic", scene=True)
def ext_rig_d200_lens_sharp(results):
    """The rig d200-lens-sharp."""
    return drawn_rig(results, "d200-lens-sharp")


@figure("ext_rig_fisheye_12x9", needs=("ext_rigs",), evidence="analytic", scene=True)
def ext_rig_fisheye_12x9(results):
    """The rig fisheye-12x9."""
    return drawn_rig(results, "fisheye-12x9")


@figure("ext_rig_fisheye_9x7", needs=("ext_rigs",), evidence="analytic", scene=True)
def ext_rig_fisheye_9x7(results):
    """The rig fisheye-9x7."""
    return drawn_rig(results, "fisheye-9x7")


@figure("ext_rig_flexible_mirror", needs=("ext_rigs",), evidence="analytic", scene=True)
def ext_rig_flexible_mirror(results):
    """The rig flexible-mirror."""
    return drawn_rig(results, "flexible-mirror")


@figure("ext_rig_hyperboloidal", needs=("ext_rigs",), evidence="analytic", scene=True)
def ext_rig_hyperboloidal(results):
    """The rig hyperboloidal."""
    return drawn_rig(results, "hyperboloidal")


@figure("ext_rig_kodak_boards", needs=("ext_rigs",), evidence="analytic", scene=True)
def ext_rig_kodak_boards(results):
    """The rig kodak-boards."""
    return drawn_rig(results, "kodak-boards")


@figure("ext_rig_kodak_megaplus", needs=("ext_rigs",), evidence="analytic", scene=True)
def ext_rig_kodak_megaplus(results):
    """The rig kodak-megaplus."""
    return drawn_rig(results, "kodak-megaplus")


@figure("ext_rig_large_fisheye", needs=("ext_rigs",), evidence="analytic", scene=True)
def ext_rig_large_fisheye(results):
    """The rig large-fisheye."""
    return drawn_rig(results, "large-fisheye")


@figure(
    "ext_rig_large_hyperboloidal", needs=("ext_rigs",), evidence="analytic", scene=True
)
def ext_rig_large_hyperboloidal(results):
    """The rig large-hyperboloidal."""
    return drawn_rig(results, "large-hyperboloidal")


@figure("ext_rig_mirror_ball", needs=("ext_rigs",), evidence="analytic", scene=True)
def ext_rig_mirror_ball(results):
    """The rig mirror-ball."""
    return drawn_rig(results, "mirror-ball")


@figure("ext_rig_monitor_d200", needs=("ext_rigs",), evidence="analytic", scene=True)
def ext_rig_monitor_d200(results):
    """The rig monitor-d200."""
    return drawn_rig(results, "monitor-d200")


@figure(
    "ext_rig_onevr_d70_boards", needs=("ext_rigs",), evidence="analytic", scene=True
)
def ext_rig_onevr_d70_boards(results):
    """The rig onevr-d70-boards."""
    return drawn_rig(results, "onevr-d70-boards")


@figure("ext_rig_onevr_d70", needs=("ext_rigs",), evidence="analytic", scene=True)
def ext_rig_onevr_d70(results):
    """The rig onevr-d70."""
    return drawn_rig(results, "onevr-d70")


@figure("ext_rig_ordinary_lens", needs=("ext_rigs",), evidence="analytic", scene=True)
def ext_rig_ordinary_lens(results):
    """The rig ordinary-lens."""
    return drawn_rig(results, "ordinary-lens")


@figure(
    "ext_rig_panorama_hyperboloid", needs=("ext_rigs",), evidence="analytic", scene=True
)
def ext_rig_panorama_hyperboloid(results):
    """The rig panorama-hyperboloid."""
    return drawn_rig(results, "panorama-hyperboloid")


@figure("ext_rig_spherical", needs=("ext_rigs",), evidence="analytic", scene=True)
def ext_rig_spherical(results):
    """The rig spherical."""
    return drawn_rig(results, "spherical")
