"""`raxel board --squares 9x6 --pitch 25 --paper a4 --out board.pdf`

A sheet is a set of black rectangles and lines of text, in mm from its upper left
corner. A PDF of it is written directly: lengths are exact, and viewers are requested
not to scale it.
"""

import math
from pathlib import Path
from types import SimpleNamespace
from typing import NamedTuple

import numpy as np

from raxel.cli.outputs import check_written
from raxel.cli.terminal import Say, on_one_line
from raxel.errors import InputError
from raxel.io.files import write_whole

# Printers leave 4 to 6 mm blank; a detector requires white around the board. The foot
# holds the ruler and the text.
MARGIN_MM, FOOT_MM = 10.0, 24.0
MAX_TEXT_MM, EM_PER_LETTER = 3.0, 0.55  # size of letters; width of Helvetica, at most
TICK_MM, LINE_MM = 10.0, 0.2  # of the ruler
MARKER_SHARE = 0.75  # side of a marker over that of its square
N_MARKERS = 50, 100, 250, 1000  # of dictionaries with 4 x 4 cells


class PrintedBoard(NamedTuple):
    """size: (width, height); black: rectangles (N, 4), left, top, width and height;
    texts: [(left, baseline, size of letters, text)]; all in mm."""

    size: tuple[float, float]
    black: np.ndarray
    texts: list[tuple[float, float, float, str]]


def board(options: SimpleNamespace, say: Say) -> None:
    """Write a board to print, and print its fields of set.yaml."""
    out = Path(options.out)
    if out.suffix.lower() != ".pdf":
        raise InputError(f"{out}: found ending {out.suffix or 'none'!r}; give .pdf")
    check_written([out], [])
    (across, down), pitch = options.squares, options.pitch
    fields = {"kind": options.kind, "columns": across - 1, "rows": down - 1}
    fields["pitch_mm"] = f"{pitch:g}"
    if options.kind == "charuco":
        size = next((n for n in N_MARKERS if across * down // 2 <= n), None)
        if size is None:
            raise InputError(
                f"--squares: {across * down // 2} markers; give a board with at most "
                f"{N_MARKERS[-1]}"
            )
        fields["dictionary"] = f"4X4_{size}"
        fields["marker_mm"] = f"{MARKER_SHARE * pitch:g}"
    counts = (
        f"{across} x {down} squares of {pitch:g} mm = {across - 1} x {down - 1} "
        "interior corners = columns, rows of set.yaml"
    )
    texts = [
        f"{counts}. Outside: {across * pitch:g} x {down * pitch:g} mm.",
        ", ".join(f"{name}: {value}" for name, value in fields.items()),
    ]
    drawn = sheet(options, fields.get("dictionary"), texts)
    write_whole(out, pdf(drawn))
    print(f"{on_one_line(out)}: {counts}, on {drawn.size[0]:g} x {drawn.size[1]:g} mm")
    print(
        "target:", *(f"{name}: {value}" for name, value in fields.items()), sep="\n  "
    )
    if options.kind == "chessboard" and (across - down) % 2 == 0:
        print(
            "the board looks the same rotated by 180 degrees, which exchanges its "
            "corners; give an even and an odd number of squares"
        )


def sheet(
    options: SimpleNamespace, dictionary: str | None, texts: list[str]
) -> PrintedBoard:
    """Return a board in the middle of the paper, with a ruler and texts below.

    dictionary: of the markers in white squares, None for a chessboard. Raises
    InputError for a board that does not fit.
    """
    counts, pitch = np.array(options.squares), options.pitch
    size = sorted(options.paper, reverse=bool(counts[0] >= counts[1]))
    room = np.subtract(size, [2 * MARGIN_MM, MARGIN_MM + FOOT_MM])
    board_mm = counts * pitch
    if (board_mm > room).any():
        most = math.floor(10 * (room / counts).min()) / 10
        raise InputError(
            f"--pitch: {counts[0]} x {counts[1]} squares of {pitch:g} mm have "
            f"{board_mm[0]:g} x {board_mm[1]:g} mm, --paper has {room[0]:g} x "
            f"{room[1]:g} mm within margins; "
            + (f"give at most {most:g}" if most > 0 else "give a larger --paper")
        )
    j, i = np.mgrid[: counts[1], : counts[0]].reshape(2, -1)
    places = (room - board_mm) / 2 + MARGIN_MM + pitch * np.column_stack([i, j])
    dark = (i + j) % 2 == 0
    foot = size[1] - FOOT_MM + 4
    marks = MARGIN_MM + np.arange(0, room[0] + 1e-9, TICK_MM)
    ruler = marks[-1] - marks[0]
    black = [
        *((*place, pitch, pitch) for place in places[dark]),
        (MARGIN_MM, foot, ruler, LINE_MM),
        *((mark - LINE_MM / 2, foot, LINE_MM, TICK_MM / 4) for mark in marks),
    ]
    if dictionary:
        margin = (1 - MARKER_SHARE) / 2 * pitch
        for number, place in enumerate(places[~dark]):
            black += _marker(dictionary, number, place + margin, MARKER_SHARE * pitch)
    first = (
        f"Print at 100 %. Measure this: {ruler:g} mm from the first to the last mark."
    )
    lines = [
        (
            MARGIN_MM,
            foot + 7 + 4 * k,
            min(MAX_TEXT_MM, room[0] / EM_PER_LETTER / len(t)),
            t,
        )
        for k, t in enumerate([first, *texts])
    ]
    return PrintedBoard((size[0], size[1]), np.array(black), lines)


def _marker(dictionary, number, place, side_mm):
    """Black cells of an ArUco marker with its upper left corner at `place`."""
    import cv2

    known = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, f"DICT_{dictionary}"))
    n_cells = known.markerSize + 2
    cell = side_mm / n_cells
    rows, columns = np.nonzero(known.generateImageMarker(number, n_cells) == 0)
    return [
        (*(place + cell * np.array([u, v])), cell, cell)
        for u, v in zip(columns, rows, strict=True)
    ]


def pdf(drawn: PrintedBoard) -> bytes:
    """Return a page in PDF 1.4: one path of all rectangles, and text in Helvetica."""
    (width, height), scale = drawn.size, 72 / 25.4  # points in a mm
    content = "\n".join(
        [
            f"{scale:.9f} 0 0 {scale:.9f} 0 0 cm",
            *(
                f"{x:.4f} {height - y - h:.4f} {w:.4f} {h:.4f} re"
                for x, y, w, h in drawn.black
            ),
            "f",
            *(
                f"BT /F {size:.3f} Tf {x:.4f} {height - y:.4f} Td ({text}) Tj ET"
                for x, y, size, text in drawn.texts
            ),
        ]
    )
    objects = [
        "<< /Type /Catalog /Pages 2 0 R "
        "/ViewerPreferences << /PrintScaling /None >> >>",
        "<< /Type /Pages /Kids [3 0 R] /Count 1 >>",
        f"<< /Type /Page /Parent 2 0 R /MediaBox [0 0 {scale * width:.6f} "
        f"{scale * height:.6f}] /Contents 4 0 R /Resources << /Font << /F "
        "<< /Type /Font /Subtype /Type1 /BaseFont /Helvetica >> >> >> >>",
        f"<< /Length {len(content)} >>\nstream\n{content}\nendstream",
    ]
    made, table = "%PDF-1.4\n", "0000000000 65535 f \n"
    for number, one in enumerate(objects, 1):
        table += f"{len(made):010d} 00000 n \n"
        made += f"{number} 0 obj\n{one}\nendobj\n"
    end = f"trailer\n<< /Size 5 /Root 1 0 R >>\nstartxref\n{len(made)}\n%%EOF\n"
    return f"{made}xref\n0 5\n{table}{end}".encode("ascii")
