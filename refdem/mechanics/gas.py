"""Kinetic theory of a dilute gas of equal smooth spheres with constant restitution (Haff 1983;
Brilliantov and Poeschel 2004).
"""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def haff_temperature(t: Array, t0: float, tau: float) -> Array:
    """T0/(1 + t/tau)^2 (T,) [J] at t (T,) [s]; T0 for tau = inf."""
    return np.asarray(t0 / (1 + t / tau) ** 2)


def collisions(t: Array, temperature: Array, rate: float, n: int) -> Array:
    """Mean number (T,) of collisions of n spheres up to t (T,) [s]: integral of (n - 1)/2 rate
    sqrt(T), rate = w_c/sqrt(T) [J^-1/2/s].

    Between samples 1/sqrt(T) is taken as linear, as Haff's law has it. A sphere has n - 1 partners,
    not n.
    """
    u = 1 / np.sqrt(temperature)
    before = u[:-1]
    after = u[1:]
    step = np.diff(u)
    # The mean of 1/u between samples is ln(after/before)/step, which cancels where u hardly
    # changes; there it is 2/(after + before), to second order.
    with np.errstate(divide="ignore", invalid="ignore"):
        is_flat = np.abs(step) < 1e-6 * before
        logarithmic = np.log(after / before) / step
        mean = np.where(is_flat, 2 / (after + before), logarithmic)
    each = 0.5 * (n - 1) * rate * mean * np.diff(t)
    return np.concatenate([[0.0], np.cumsum(each)])


def loss_error(restitution: float, n: int, met: Array) -> Array:
    """Standard error (T,) of ln T after `met` (T,) collisions.

    Each takes (1 - e^2) m v_n^2/4 with v_n^2 exponential, of mean 4 T/m, from 3 (n - 1) T/2: a
    compound Poisson sum, whose variance is the number times the mean square, 2 ((1 - e^2) T)^2.
    That a gas that is too cold cools less makes it smaller yet.
    """
    part_lost = 2 * (1 - restitution**2) / (3 * (n - 1))
    return np.asarray(part_lost * np.sqrt(2 * met))


def velocity_kurtosis(velocity: Array) -> float:
    """Excess kurtosis of the components of velocities (N, 3) [m/s] about those of the centre of
    mass; 0 for Maxwell's.
    """
    own = velocity - velocity.mean(axis=0)
    variance = np.mean(own**2)
    return float(np.mean(own**4) / variance**2 - 3)


def kurtosis_error(n: int) -> float:
    """Standard error sqrt(24/M) of the excess kurtosis of M = 3 (n - 1) Gaussian numbers, and its
    mean -6/M.
    """
    count = 3 * (n - 1)
    return float(np.sqrt(24 / count) + 6 / count)


def rough_temperatures(
    t: Array, t0: float, frequency: float, inertia: float
) -> tuple[Array, Array]:
    """Temperatures (T,) [J] of flight and of spin at t (T,) [s] of elastic, perfectly rough spheres
    that do not spin at first.

    `frequency` is that of collisions at the start, `inertia` = 4 J/(m d^2). Both are Maxwellian;
    their difference falls by 8/3 w_c inertia/(1 + inertia)^2, where w_c goes with the square root
    of the first; their sum is kept (Huthmann and Zippelius 1997, with e = beta = 1). u =
    sqrt(T_flight/t0) obeys u' = -rate/2 (2 u^2 - 1), which tanh solves.
    """
    rate = 4 / 3 * frequency * inertia / (1 + inertia) ** 2
    root = np.sqrt(2)
    # u = 1/(sqrt 2 tanh(rate t/sqrt 2 + artanh(1/sqrt 2))), so that u(0) = 1.
    phase = rate * t / root + np.arctanh(1 / root)
    u = 1 / (root * np.tanh(phase))
    flight: Array = t0 * u * u
    return flight, t0 - flight
