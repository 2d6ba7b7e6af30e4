"""Images of a room by eight cameras of the collection."""

from chapters.ch02_general_camera_model.s2_camera_models.trials.zoo import ROOM
from repro.page.style import figure as new_figure
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Drawing


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
        cells = (ran.column(what, model=name)[0] for what in ("mean", "seen"))
        rows.append((name, *cells))
    return Drawing(
        drawn,
        columns(("model", "mean_radiance", "share_lit"), rows),
        "Rendered images of one room by eight cameras at its centre. The "
        "camera of the hyperboloid mirror looks up; that of the plane mirrors "
        "has the room's windows behind it.",
    )
