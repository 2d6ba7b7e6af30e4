"""What is expected of a smooth field before anything is measured.

Squared second differences of neighbouring control values count against it, and a share
TIE of the values' own squares. Control values about whose middle nothing was measured
are tied to zero besides: so the field fades where there is no target, and the rays to
the trend's. When errors are stated that tie does not count.

In a table of rays that tie is FAR of what the data of a cell would weigh: data of which
such a value sees a tail determine it less than that. Corners of boards are few, and
every tail counts: there the tie is FADE times their own squares, and weakens with
all else that is expected where corners are exact. Tied firmly next to data that know it
well, a field would be bent among them.

Polynomials to the third degree count as unknown when errors are stated: a trend that
was fitted to the same data has such errors, which no smoothness takes away.

Sources: P. Eilers and B. Marx 1996, doi:10.1214/ss/1038425655 (penalised splines);
G. Wahba 1983, doi:10.1111/j.2517-6161.1983.tb01239.x (the covariance of such a fit).
"""

import numpy as np

TIE, FAR, FADE = 1 / 4, 1e-3, 1.0


def penalty_matrix(shape):
    """(K, K) sparse, of the K = rows * columns control values of one coordinate."""
    from scipy.sparse import eye_array, kron

    rows, columns = shape
    down, along = eye_array(rows), eye_array(columns)
    bends = [
        kron(_differences(rows, (1.0, -2.0, 1.0)), along),
        kron(down, _differences(columns, (1.0, -2.0, 1.0))),
        np.sqrt(2) * kron(_differences(rows, (-1.0, 1.0)),
                          _differences(columns, (-1.0, 1.0))),
    ]  # fmt: skip
    total = sum(part.T @ part for part in bends)
    return (total + TIE * eye_array(rows * columns)).tocsr()


def far_from_data(covered):
    """(K,) bool: control values about whose middle no cell is covered.

    covered: (rows - 3, columns - 3) bool, cells in which something was measured. Cells
    beyond the image count as their neighbours in it.
    """
    framed = np.pad(covered, 2, mode="edge")
    pairs = framed[:-1] | framed[1:]
    return ~(pairs[:, :-1] | pairs[:, 1:]).ravel()


def _differences(count, steps):
    from scipy.sparse import diags_array

    order = len(steps) - 1
    return diags_array(steps, offsets=range(order + 1), shape=(count - order, count))


def free_polynomials(shape):
    """Control values (K, 10) of the polynomials in u and v to the third degree."""
    down, along = (_powers(count) for count in shape)
    columns = [
        np.outer(down[i], along[j]).ravel() for i in range(4) for j in range(4 - i)
    ]
    return np.column_stack(columns)


def _powers(count):
    """Control values of 1, x, x^2, x^3 on count values, x from -1 to 1."""
    knot, half = np.arange(count) - (count - 1) / 2, (count - 1) / 2
    return [
        np.ones(count),
        knot / half,
        (knot**2 - 1 / 3) / half**2,
        (knot**3 - knot) / half**3,
    ]


def node_places(shape, spacing):
    """Pixels (rows, columns, 2) at the corners of the cells and half-way between."""
    rows, columns = (2 * (count - 3) + 1 for count in shape)
    v, u = np.mgrid[:rows, :columns] * (spacing / 2) - 0.5
    return np.stack([u, v], axis=-1)
