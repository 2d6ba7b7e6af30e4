"""`raxel patterns --width W --height H --out FOLDER`"""

from dataclasses import replace

from raxel.cli.new_folder import new_folder
from raxel.cli.terminal import on_one_line
from raxel.report.canvas import encoded
from raxel.report.images import pattern_sheet
from raxel.sets import chessboard_image, pattern_image, patterns_of, plan_of_cells
from raxel.sets.image_set import set_text
from raxel.sets.model import DESCRIPTION, ActiveGrid, ImageSet, View
from raxel.sets.patterns import BLACK, CHESSBOARD, WHITE, chessboard_of_corners

PREVIEW = "preview.png"
HEADER = """\
# Show each picture of this folder on the whole monitor, one pixel on one pixel, in a
# dark room, and photograph it: camera and monitor at rest, focus and exposure by hand,
# the same for all, nothing overexposed. Give the photographs the pictures' names, put
# them into a folder of their own with this file (each pose into its folder, as below),
# and fill in:
# - resolution: width and height of the photographs in px
# - monitor_mm: width and height of the lit area in mm, [w, h], if it is null
# Further poses are further entries of views, with other names for their files.
"""
STEPS = """\
# Fewer steps than six of the sines are for monitors and cameras that answer nearly in
# proportion: of one that does not, low harmonics shift places. What can be told of that
# from the pictures is corrected.
"""


def patterns(options, say):
    """Write what the monitor is to show, and a set.yaml for the photographs of it."""
    size = options.width, options.height
    plan = plan_of_cells(size, options.cells, options.steps, options.offset)
    shown = patterns_of(plan)
    board = options.chessboard and chessboard_of_corners(size, *options.chessboard)
    grid = ActiveGrid(size, options.size_mm and tuple(options.size_mm), board)
    with new_folder(options.out) as folder:
        for pattern in shown:
            picture = pattern_image(pattern, size)
            (folder / pattern.image).write_bytes(encoded(picture, ".png"))
            say(pattern.image)
        for name, level in ((WHITE, 255), (BLACK, 0)):
            picture[:] = level
            (folder / name).write_bytes(encoded(picture, ".png"))
        if board:
            picture = chessboard_image(board, size)
            (folder / CHESSBOARD).write_bytes(encoded(picture, ".png"))
        sheet = encoded(pattern_sheet(shown, size), ".png")
        (folder / PREVIEW).write_bytes(sheet)
        (folder / DESCRIPTION).write_text(_stub(shown, grid, options), "utf-8")
    cells = " x ".join(f"{width:g}" for width in plan.cell_px)
    others = ", ".join([WHITE, BLACK] + [CHESSBOARD] * bool(board))
    print(
        f"{len(shown)} patterns with cells of {cells} px, {others} and {PREVIEW} in"
        f" {on_one_line(options.out)}; {DESCRIPTION} says what to do"
    )


def _stub(shown, grid, options):
    """A set.yaml for one pose, or for several in folders of their own."""
    names = [f"pose-{k}" for k in range(1, options.poses + 1)]
    folders = [f"{name}/" for name in names] if options.poses > 1 else [""]
    views = tuple(
        View(
            name=name,
            white=folder + WHITE,
            black=folder + BLACK,
            chessboard=folder + CHESSBOARD if grid.chessboard else None,
            patterns=tuple(replace(p, image=folder + p.image) for p in shown),
        )
        for name, folder in zip(names, folders, strict=True)
    )
    text = set_text(ImageSet("my-active-grid", 0, 0, grid, views, None))
    return HEADER + (STEPS if options.steps < 6 else "") + text
