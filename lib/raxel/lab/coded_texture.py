"""A chessboard whose squares carry marks: the coded grid of section 6.3.1."""

import numpy as np

from raxel.errors import InputError
from raxel.lab.textures import GridTexture, colour_table


class CodedTexture(GridTexture):
    """Squares of two colours in turn; a mark in the middle of those whose bit is set.

    bits: (rows, columns) bool, one for each square; pitch_mm: side of a square; mark:
    side of a mark, a square too, as a share of the pitch. contrast: how far a mark's
    colour is from its square's towards the other colour, up to 1. The outer corner of
    square (0, 0), which is white, is at uv (0, 0), and uv grows along columns and rows.
    `extent` gives the corner and size of the whole.
    """

    def __init__(self, bits, pitch_mm, mark=0.3, contrast=1.0, black=0.05, white=0.9):
        bits = np.asarray(bits, bool)
        shares = 0 < mark < 1 and 0 < contrast <= 1
        if bits.ndim != 2 or not bits.size or not pitch_mm > 0 or not shares:
            raise InputError(
                f"coded grid: found bits of shape {bits.shape}, pitch {pitch_mm}, mark "
                f"{mark} and contrast {contrast}; give rows x columns, a positive "
                "pitch, a mark below 1 and a contrast of up to 1"
            )
        self.bits, self.pitch_mm = bits, float(pitch_mm)
        rows, columns = bits.shape
        edges = np.array([0.0, (1 - mark) / 2, (1 + mark) / 2])
        lines = [
            self.pitch_mm * np.append((np.arange(n)[:, None] + edges).ravel(), n)
            for n in (columns, rows)
        ]
        white_square = np.add.outer(np.arange(rows), np.arange(columns)) % 2 == 0
        cells = np.repeat(np.repeat(white_square, 3, axis=0), 3, axis=1).astype(int)
        # Colours 0 and 1 are those of squares, 2 and 3 those of marks on them.
        cells[1::3, 1::3] += 2 * bits
        # No point of the sheet lies in the outer cells, which go on without end.
        cells = np.pad(cells, 1, mode="edge")
        squares = colour_table(black, white)
        marks = (1 - contrast) * squares + contrast * squares[::-1]
        super().__init__(lines, np.concatenate((squares, marks))[cells.ravel()])

    @property
    def extent(self):
        """(corner (2,), size (2,)) of the sheet in uv, mm."""
        rows, columns = self.bits.shape
        return np.zeros(2), self.pitch_mm * np.array([columns, rows], float)
