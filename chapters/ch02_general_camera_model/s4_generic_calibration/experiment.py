"""Table 2.1 as formulas: printed, and evaluated in exact arithmetic."""

import re
from fractions import Fraction

import numpy as np

# Cells as expressions: R31_2 is element (3, 1) of R of grid 2, t_z_2 its z.
TABLE_2_1 = (
    ("x", "x", "0", "R31_2", "0", "R31_3"),
    ("x", "y", "0", "R32_2", "0", "R32_3"),
    ("x", "w", "0", "-C_z + t_z_2", "0", "-C_z + t_z_3"),
    ("y", "x", "R31_2", "0", "R31_3", "0"),
    ("y", "y", "R32_2", "0", "R32_3", "0"),
    ("y", "w", "-C_z + t_z_2", "0", "-C_z + t_z_3", "0"),
    ("w", "x", "-C_y*R31_2 + C_z*R21_2", "-C_x*R31_2 + C_z*R11_2",
     "-C_y*R31_3 + C_z*R21_3", "-C_x*R31_3 + C_z*R11_3"),
    ("w", "y", "-C_y*R32_2 + C_z*R22_2", "-C_x*R32_2 + C_z*R12_2",
     "-C_y*R32_3 + C_z*R22_3", "-C_x*R32_3 + C_z*R12_3"),
    ("w", "w", "-C_y*t_z_2 + C_z*t_y_2", "-C_x*t_z_2 + C_z*t_x_2",
     "-C_y*t_z_3 + C_z*t_y_3", "-C_x*t_z_3 + C_z*t_x_3"),
)  # fmt: skip
VECTORS = ("V", "W", "M", "N")

# The two cells that the thesis prints with a superscript one too low; t_z
# of grid 1, the base grid, is zero.
AS_PRINTED = {(2, "W"): "-C_z + t_z_1", (2, "N"): "-C_z + t_z_2"}


def formula(row, vector, printed=False):
    """Return the expression in a cell of Table 2.1; rows count from 0."""
    if printed and (row, vector) in AS_PRINTED:
        return AS_PRINTED[row, vector]
    return TABLE_2_1[row][2 + VECTORS.index(vector)]


def as_maths(expression):
    """Return the expression as LaTeX; superscripts name the grid."""
    text = re.sub(r"R(\d\d)_(\d)", r"R_{\1}^\2", expression)
    text = re.sub(r"t_([xyz])_(\d)", r"t_\1^\2", text)
    return f"${text.replace('*', ' ')}$"


def rational_rotation(quaternion):
    """Return the exact rotation matrix of an integer quaternion."""
    a, b, c, d = (Fraction(int(part)) for part in quaternion)
    n = a * a + b * b + c * c + d * d
    rows = (
        (a * a + b * b - c * c - d * d, 2 * (b * c - a * d), 2 * (b * d + a * c)),
        (2 * (b * c + a * d), a * a - b * b + c * c - d * d, 2 * (c * d - a * b)),
        (2 * (b * d - a * c), 2 * (c * d + a * b), a * a - b * b - c * c + d * d),
    )
    return [[entry / n for entry in row] for row in rows]


def draw_scene(rng):
    """Return the names of Table 2.1 with exact values: a centre and two grid poses."""
    names = dict(zip(("C_x", "C_y", "C_z"), _whole(rng, 3), strict=True))
    names["t_z_1"] = Fraction(0)
    for grid in (2, 3):
        R = rational_rotation(rng.integers(1, 20, 4))
        for row in range(3):
            for column in range(3):
                names[f"R{row + 1}{column + 1}_{grid}"] = R[row][column]
        for axis, value in zip("xyz", _whole(rng, 3), strict=True):
            names[f"t_{axis}_{grid}"] = value
    return names


def _whole(rng, count):
    signs = rng.choice((-1, 1), count)
    return [Fraction(int(v)) for v in signs * rng.integers(50, 900, count)]


def meet(names, grid, base_point):
    """Return where the ray through a point of the base grid meets a grid, exactly.

    Solves C + s (Q - C) = R (x, y, 0) + t by Cramer's rule; None for a ray
    that is parallel to the grid.
    """
    centre = [names[f"C_{axis}"] for axis in "xyz"]
    through = [*base_point, Fraction(0)]
    ray = [q - c for q, c in zip(through, centre, strict=True)]
    t = [names[f"t_{axis}_{grid}"] for axis in "xyz"]
    columns = [[names[f"R{r}{c}_{grid}"] for r in (1, 2, 3)] for c in (1, 2)]
    system = [*columns, [-part for part in ray]]
    wanted = [c - shift for c, shift in zip(centre, t, strict=True)]
    whole = _determinant(system)
    if whole == 0:
        return None
    return [
        _determinant([wanted if k == i else system[k] for k in range(3)]) / whole
        for i in range(2)
    ]


def _determinant(columns):
    (a, b, c), (d, e, f), (g, h, i) = columns
    return a * (e * i - f * h) - d * (b * i - c * h) + g * (b * f - c * e)


def evaluated(vector, names, printed=False):
    """Return the nine coefficients of a vector in a scene, exactly."""
    return [
        eval(formula(row, vector, printed), {"__builtins__": {}}, names)
        for row in range(9)
    ]


def substitute(names, printed=False, rays=8):
    """Return the sums (2.14) of Table 2.1 over the rays of a scene, exactly.

    Returns {vector: (every sum is zero, largest |sum| / sum of |terms|)}.
    """
    outcome = {}
    for vector in VECTORS:
        grid = 2 if vector in "VW" else 3
        cells = evaluated(vector, names, printed)
        zero, largest = True, 0.0
        for base in _base_points(rays):
            point = meet(names, grid, base)
            if point is None:
                continue
            terms = _terms(cells, [*base, Fraction(1)], [*point, Fraction(1)])
            total, size = sum(terms), sum(abs(term) for term in terms)
            zero &= total == 0
            largest = max(largest, float(abs(total) / size))
        outcome[vector] = (zero, largest)
    return outcome


def _base_points(count):
    return [[Fraction(37 * k - 120), Fraction(91 - 53 * k)] for k in range(count)]


def _terms(cells, first, second):
    place = {"x": 0, "y": 1, "w": 2}
    return [
        first[place[row[0]]] * second[place[row[1]]] * cell
        for row, cell in zip(TABLE_2_1, cells, strict=True)
    ]


def library_difference(names):
    """Return the largest relative difference of formulas and library vectors."""
    from raxel.calibration import table_2_1
    from raxel.geometry import pose

    centre = np.array([float(names[f"C_{axis}"]) for axis in "xyz"])
    poses = []
    for grid in (2, 3):
        R = [[float(names[f"R{r}{c}_{grid}"]) for c in (1, 2, 3)] for r in (1, 2, 3)]
        t = [float(names[f"t_{axis}_{grid}"]) for axis in "xyz"]
        poses.append(pose(np.array(R), np.array(t)))
    worst = 0.0
    for printed in (False, True):
        exact = np.array(
            [[float(c) for c in evaluated(v, names, printed)] for v in VECTORS]
        )
        made = table_2_1(centre, *poses, row_3="printed" if printed else "corrected")
        worst = max(worst, np.abs(made - exact).max() / np.abs(exact).max())
    return worst
