"""`raxel patterns --width W --height H --out FOLDER`"""

from raxel.cli.new_folder import new_folder
from raxel.cli.terminal import on_one_line
from raxel.report.active_grid import pattern_sheet
from raxel.report.canvas import encoded
from raxel.sets import pattern_picture, patterns_of, plan_of_cells
from raxel.sets.image_set import set_text
from raxel.sets.model import DESCRIPTION, ActiveGrid, ImageSet, View
from raxel.sets.patterns import BLACK, WHITE

PREVIEW = "preview.png"
HEADER = """\
# Show each picture of this folder on the whole monitor, one pixel on one pixel, and
# photograph it, camera and monitor at rest and nothing overexposed. Give the photos
# the pictures' names, put them into a folder of their own with this file, and fill in:
# - resolution: width and height of the photos in px
# - monitor_mm: width and height of the lit area in mm, [w, h]
# Further poses are further entries of views, with other names for their files.
"""


def patterns(options, say):
    """Write what the monitor is to show, and a set.yaml for the photographs of it."""
    size = options.width, options.height
    plan = plan_of_cells(size, options.cells, options.steps)
    shown = patterns_of(plan)
    with new_folder(options.out) as folder:
        for pattern in shown:
            picture = pattern_picture(pattern, size)
            (folder / pattern.image).write_bytes(encoded(picture, ".png"))
            say(pattern.image)
        for name, level in ((WHITE, 255), (BLACK, 0)):
            picture[:] = level
            (folder / name).write_bytes(encoded(picture, ".png"))
        sheet = encoded(pattern_sheet(shown, size), ".png")
        (folder / PREVIEW).write_bytes(sheet)
        (folder / DESCRIPTION).write_text(HEADER + _stub(shown, size), "utf-8")
    cells = " x ".join(f"{width:g}" for width in plan.cell_px)
    print(
        f"{len(shown)} patterns with cells of {cells} px, {WHITE}, {BLACK} and "
        f"{PREVIEW} in {on_one_line(options.out)}; {DESCRIPTION} says what to do"
    )


def _stub(shown, size):
    view = View(name="pose-1", white=WHITE, black=BLACK, patterns=tuple(shown))
    grid = ActiveGrid(size)
    return set_text(ImageSet("my-active-grid", 0, 0, grid, (view,), None))
