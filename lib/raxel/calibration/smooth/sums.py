"""A smooth field fitted to values at pixels: sums over millions, then few unknowns.

The field is `raxel.cameras.tables.cubic_field`'s. Least squares needs of the data no
more than a band of the normal matrix, which is summed up pixel by pixel, in as many
parts as are kept out in turn.
"""

import numba
import numpy as np

from raxel.cameras.tables.cubic_field import control_shape, cubic_shares


class FieldSums:
    """Sums of one spacing of cells over an image, in `parts` parts.

    normal: (parts, rows, columns, 4, 7), products of a control value's share with those
    0 to 3 rows on and -3 to 3 columns on; right: (parts, rows, columns, 2); squares,
    weights: (parts,); cells: (rows - 3, columns - 3), how many pixels fell into each.
    """

    def __init__(self, width, height, spacing, parts):
        self.spacing, self.shape = float(spacing), control_shape(width, height, spacing)
        rows, columns = self.shape
        self.normal = np.zeros((parts, rows, columns, 4, 7))
        self.right = np.zeros((parts, rows, columns, 2))
        self.squares, self.weights = np.zeros(parts), np.zeros(parts)
        self.cells = np.zeros((rows - 3, columns - 3), np.int64)

    def add(self, pixels, values, weights, part):
        """Add values (N, 2) at pixels (N, 2) of the image, with weights (N,), each to
        the part (N,) it belongs to."""
        _add(
            pixels, values, weights, part, self.spacing,
            self.normal, self.right, self.squares, self.weights, self.cells,
        )  # fmt: skip

    def band(self, parts):
        """The lower band (3 columns + 4, rows * columns) of the sum over parts."""
        rows, columns = self.shape
        summed = self.normal[parts].sum(axis=0)
        band = np.zeros((3 * columns + 4, rows * columns))
        for down in range(4):
            for along in range(-3 if down else 0, 4):
                # The later value of a pair that would leave its row does not exist.
                band[down * columns + along] += summed[:, :, down, along + 3].ravel()
        return band

    def quadratic(self, part, control):
        """Sum over a part of weights times squared distances from the field (K, 2)."""
        product = band_product(self.band([part]), control)
        right = self.right[part].reshape(-1, 2)
        return float(
            self.squares[part] - 2 * np.vdot(right, control) + np.vdot(product, control)
        )


def band_of(matrix, width):
    """The lower band (width, K) of a sparse symmetric matrix (K, K)."""
    below = matrix.tocoo()
    row, column = below.coords
    keep = row >= column
    band = np.zeros((width, matrix.shape[0]))
    band[(row - column)[keep], column[keep]] = below.data[keep]
    return band


def band_product(band, values):
    """Symmetric matrix of this lower band times values (K, 2)."""
    product = band[0][:, None] * values
    for offset in range(1, len(band)):
        line = band[offset, : len(values) - offset, None]
        if line.any():
            product[offset:] += line * values[:-offset]
            product[:-offset] += line * values[offset:]
    return product


@numba.njit(cache=True)
def _add(pixels, values, weights, part, spacing, normal, right, squares, total, cells):
    # The loop over pixels sums one cell's products after the other: 16 x 16 of them.
    b, slope, d = np.empty(4), np.empty(4), np.empty(4)
    for n in range(len(pixels)):
        w = weights[n]
        if not w > 0:
            continue
        x, y = (pixels[n, 0] + 0.5) / spacing, (pixels[n, 1] + 0.5) / spacing
        i = min(max(int(x), 0), cells.shape[1] - 1)
        j = min(max(int(y), 0), cells.shape[0] - 1)
        cubic_shares(x - i, b, slope)
        cubic_shares(y - j, d, slope)
        f = part[n]
        cells[j, i] += 1
        total[f] += w
        squares[f] += w * (values[n, 0] ** 2 + values[n, 1] ** 2)
        for k in range(4):
            for m in range(4):
                share = w * d[k] * b[m]
                right[f, j + k, i + m, 0] += share * values[n, 0]
                right[f, j + k, i + m, 1] += share * values[n, 1]
                for p in range(k, 4):
                    first = m if p == k else 0
                    for q in range(first, 4):
                        normal[f, j + k, i + m, p - k, q - m + 3] += share * d[p] * b[q]
