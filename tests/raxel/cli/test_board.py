"""Boards to print: the PDF has exact lengths, and raxel detects what it draws."""

import re

import cv2
import numpy as np
import pytest
import yaml

from raxel.cli import main
from raxel.features import find_board
from raxel.features.charuco import find_charuco
from raxel.sets import Charuco

PX_PER_MM, SUBPIXELS = 2, 8


def page(path):
    """(size in mm, rectangles [left, top, width, height] in mm) of a PDF."""
    text = path.read_bytes().decode("ascii")
    width, height = np.float64(
        re.search(r"MediaBox \[0 0 (\S+) (\S+)\]", text).groups()
    )
    scale = float(re.search(r"(\S+) 0 0 \S+ 0 0 cm", text)[1])
    assert scale == pytest.approx(72 / 25.4)
    x, y, w, h = np.float64(re.findall(r"(.+) (.+) (.+) (.+) re\n", text)).T
    return (width / scale, height / scale), np.c_[x, height / scale - y - h, w, h]


def raster(size, black):
    """Image of a page, pixels averaged over SUBPIXELS along each axis."""
    width, height = np.rint(PX_PER_MM * np.array(size)).astype(int)
    image = np.full((height * SUBPIXELS, width * SUBPIXELS), 255, np.uint8)
    for left, top, w, h in np.rint(PX_PER_MM * SUBPIXELS * black).astype(int):
        image[top : top + h, left : left + w] = 0
    return cv2.resize(image, (width, height), interpolation=cv2.INTER_AREA)


@pytest.mark.parametrize("kind", ["chessboard", "charuco"])
def test_printed_board_has_stated_corners(tmp_path, capsys, kind):
    path = tmp_path / "board.pdf"
    order = f"board --squares 9x6 --pitch 25 --paper a4 --kind {kind} --out"
    assert main([*order.split(), str(path)]) == 0
    line, fields = capsys.readouterr().out.split("\n", 1)
    assert "rotated" not in fields
    assert "9 x 6 squares of 25 mm = 8 x 5 interior corners = columns, rows" in line
    target = yaml.safe_load(fields)["target"]
    size, black = page(path)
    np.testing.assert_allclose(size, (297, 210), atol=1e-4)
    image = raster(size, black)
    if target.pop("kind") == "charuco":
        corners = find_charuco(image, Charuco(**target)).corners
    else:  # counted from the corner of the paper with a white square
        corners = find_board(image, target["columns"], target["rows"]).corners[::-1]
    # 225 x 150 mm in the middle between margins of 10 mm, below of 24 mm.
    v, u = np.mgrid[:5, :8]
    truth = np.dstack([36 + 25 * (u + 1), 10 + 13 + 25 * (v + 1)]) * PX_PER_MM - 0.5
    np.testing.assert_allclose(corners.reshape(truth.shape), truth, atol=0.05)
    # The ruler: marks every 10 mm over 270 mm.
    marks = black[np.isclose(black[:, 2], 0.2)]
    np.testing.assert_allclose(np.diff(marks[:, 0]), 10, atol=1e-3)
    assert marks[-1, 0] - marks[0, 0] == pytest.approx(270, abs=1e-3)


@pytest.mark.parametrize(
    ("given", "text"),
    [
        ("--squares 9x6 --pitch 40", "277 x 176 mm within margins; give at most 29.3"),
        ("--squares 6x9 --pitch 29.4 --paper 210x297", "give at most 29.2"),
        ("--squares 9x6 --pitch 25 --paper 50x50", "give at most 2.6"),
        ("--squares 60x50 --pitch 2 --paper a3 --kind charuco", "at most 1000"),
        ("--squares 9 --pitch 25", "expected two whole numbers from 4, such as 9x6"),
        ("--squares 9x6 --pitch 25 --paper a0", "expected a4, a3, letter"),
    ],
)
def test_board_states_what_is_possible(tmp_path, capsys, given, text):
    assert main(["board", *given.split(), "--out", str(tmp_path / "b.pdf")]) == 2
    assert text in capsys.readouterr().err
    assert not list(tmp_path.iterdir())
