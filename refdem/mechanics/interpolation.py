"""Motion between samples: Hermite's interpolation through positions and velocities of neighbours.

A polynomial of degree 2 m - 1 interpolates the positions and velocities of m samples (Hermite
1878).
"""

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

Array = NDArray[np.float64]


def between_samples(
    t: Array, position: Array, velocity: Array, nodes: Array, window: int
) -> tuple[Array, Array, Array]:
    """Times (T - 1, G), positions and velocities (T - 1, G, ...) inside the T - 1 intervals.

    t (T,) [s] is strictly monotonic, position and velocity (T, ...) are those of its samples, nodes
    (G,) are points in each interval, from -1 (its start) to 1 (its end). Every interval uses the
    polynomial of the `window` samples nearest to it. The error of a position is
    x^(2m) prod (t - t_j)^2 / (2m)!, m = window: of order H^(2m) in the distance H of the samples.
    Raises ValueError if there are fewer samples than the window needs.
    """
    if len(t) < window:
        raise ValueError(f"{len(t)} samples, expected at least {window}")
    intervals = np.arange(len(t) - 1)
    # The window lies around its interval, or at an end of the run.
    first = np.clip(intervals - (window // 2 - 1), 0, len(t) - window)
    members = first[:, None] + np.arange(window)

    # Each window is mapped to u in [-1, 1], where Chebyshev polynomials are well conditioned.
    # u = (t - centre)/half_width.
    centre = (t[members[:, 0]] + t[members[:, -1]]) / 2
    half_width = (t[members[:, -1]] - t[members[:, 0]]) / 2
    u_samples = (t[members] - centre[:, None]) / half_width[:, None]
    degree = 2 * window - 1
    # Columns: the coefficients of T_0', T_1', ... in Chebyshev polynomials.
    derivative = chebyshev.chebder(np.eye(degree + 1))

    # The coefficients c of x(u) = sum c_k T_k(u) solve, for each sample j of the window,
    #     sum c_k T_k(u_j) = x_j,   sum c_k T_k'(u_j) = half_width v_j.
    of_position = chebyshev.chebvander(u_samples, degree)
    of_velocity = chebyshev.chebvander(u_samples, degree - 1) @ derivative
    conditions = np.concatenate([of_position, of_velocity], axis=1)
    flat_position = position.reshape(len(t), -1)[members]
    flat_velocity = velocity.reshape(len(t), -1)[members] * half_width[:, None, None]
    values = np.concatenate([flat_position, flat_velocity], axis=1)
    coefficients = np.linalg.solve(conditions, values)

    # t = t_n + (t_(n+1) - t_n) (1 + node)/2.
    begin = t[:-1, None]
    times = begin + (t[1:, None] - begin) * (1 + nodes) / 2
    u_nodes = (times - centre[:, None]) / half_width[:, None]
    found_position = chebyshev.chebvander(u_nodes, degree) @ coefficients
    # x = sum c_k T_k(u), v = sum c_k T_k'(u)/half_width.
    slope = chebyshev.chebvander(u_nodes, degree - 1) @ derivative @ coefficients
    found_velocity = slope / half_width[:, None, None]
    shape = (*times.shape, *position.shape[1:])
    return times, found_position.reshape(shape), found_velocity.reshape(shape)
