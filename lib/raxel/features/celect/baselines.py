"""Two ways to order corners that are known as points: section 1.2.1 says they fail.

Both are right as long as the image is hardly bent. `row_margin` is the criterion by
which the first one is.
"""

import numpy as np

from raxel.geometry import apply_homography, homography_dlt


def order_by_joining_line(points, outer_corners, columns, rows):
    """Corners (rows, columns, 2) from unordered ones: row by row, nearest to a line.

    After J. Mallon and P. F. Whelan (2007a), as section 1.2.1 has it. The two upper
    corners of what is left are joined, the `columns` points nearest to the line through
    both are the row, ordered by their distance from the first of the two; they are
    taken away, and so on.

    points : (n, 2) px, at least rows * columns. outer_corners : (4, 2) px as for
    `celect`; they say where "upper" and "left" are: along the sides c1-c2 and c1-c4.
    """
    axes = np.column_stack(
        (outer_corners[1] - outer_corners[0], outer_corners[3] - outer_corners[0])
    )
    left = np.asarray(points, float)
    ordered = []
    for _ in range(rows):
        across, down = np.linalg.solve(axes, (left - outer_corners[0]).T)
        first = left[np.argmin(down + across)]
        last = left[np.argmin(down - across)]
        near = np.argsort(distance_to_join(left, first, last), kind="stable")
        row, left = left[near[:columns]], left[near[columns:]]
        along = np.argsort(np.linalg.norm(row - first, axis=1), kind="stable")
        ordered.append(row[along])
    return np.array(ordered)


def order_by_homography(points, outer_corners, columns, rows):
    """Corners (rows, columns, 2) from unordered ones: nearest to a flat prediction.

    As in the toolbox that section 1.2.1 names, without its distortion parameter: the
    homography of the four clicks puts every corner of the board into the image, and the
    nearest point is that corner. A point that is nearest to several places goes to the
    nearest of them; the others are nan.
    """
    ends = np.array([[0, 0], [columns - 1, 0], [columns - 1, rows - 1], [0, rows - 1]])
    H = homography_dlt(ends.astype(float), np.asarray(outer_corners, float))
    y, x = np.mgrid[0:rows, 0:columns]
    places = apply_homography(H, np.column_stack((x.ravel(), y.ravel())).astype(float))
    points = np.asarray(points, float)
    off = np.linalg.norm(places[:, None] - points[None], axis=2)
    nearest, apart = off.argmin(axis=1), off.min(axis=1)
    ordered = np.full((rows * columns, 2), np.nan)
    taken = set()
    for place in np.argsort(apart, kind="stable"):
        if nearest[place] not in taken:
            ordered[place] = points[nearest[place]]
            taken.add(nearest[place])
    return ordered.reshape(rows, columns, 2)


def row_margin(corners):
    """How safely rows can be told apart by the line that joins their ends, in px.

    corners (rows, columns, 2). Over the rows but the last: the distance of the nearest
    corner of a later row to the line, less that of the row's own farthest one. Negative
    where `order_by_joining_line` must take a corner of another row, even if it is given
    the right ends.
    """
    margins = []
    for k, row in enumerate(corners[:-1]):
        own = distance_to_join(row, row[0], row[-1]).max()
        later = distance_to_join(corners[k + 1 :].reshape(-1, 2), row[0], row[-1])
        margins.append(later.min() - own)
    return float(min(margins))


def distance_to_join(points, first, last):
    """Distance (n,) in px of points (n, 2) to the line through two points (2,).

    Distance to the point, if both are the same.
    """
    off, along = points - first, last - first
    length = np.linalg.norm(along)
    if length == 0:
        return np.linalg.norm(off, axis=1)
    return np.abs(off @ np.array([-along[1], along[0]])) / length
