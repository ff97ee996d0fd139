"""Kinetic theory of a dilute gas of equal smooth spheres with constant restitution e (Haff 1983;
Brilliantov and Poeschel 2004).

Temperature is in units of energy: 3 T/2 is the mean kinetic energy of a sphere. w_c is the
collision frequency of one sphere, proportional to sqrt(T).
"""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def haff_temperature(t: Array, t0: float, tau: float) -> Array:
    """Haff's law T0/(1 + t/tau)^2 (T,) [J] at times t (T,) [s]; T0 for tau = inf."""
    return np.asarray(t0 / (1 + t / tau) ** 2)


def collisions(t: Array, temperature: Array, rate: float, n: int) -> Array:
    """Mean number of collisions (T,) among n spheres up to t (T,) [s]: the integral of (n - 1)/2
    w_c.

    w_c = rate sqrt(T), rate in [J^-1/2/s]; n - 1 because a sphere has n - 1 partners. Between
    samples 1/sqrt(T) is interpolated linearly, which is exact for Haff's law.
    """
    u = 1 / np.sqrt(temperature)
    u_before = u[:-1]
    u_after = u[1:]
    u_change = np.diff(u)
    # With u = 1/sqrt(T) linear, the mean of 1/u = sqrt(T) over an interval is
    # ln(u_after/u_before)/(u_after - u_before). That cancels where u hardly changes; there it is
    # 2/(u_after + u_before), to second order.
    with np.errstate(divide="ignore", invalid="ignore"):
        is_flat = np.abs(u_change) < 1e-6 * u_before
        logarithmic = np.log(u_after / u_before) / u_change
        mean = np.where(is_flat, 2 / (u_after + u_before), logarithmic)
    # N = (n - 1)/2 rate <sqrt(T)> dt.
    per_interval = 0.5 * (n - 1) * rate * mean * np.diff(t)
    return np.concatenate([[0.0], np.cumsum(per_interval)])


def loss_error(restitution: float, n: int, n_collisions: Array) -> Array:
    """Standard error (T,) of ln T after `n_collisions` (T,) collisions.

    A collision dissipates the energy (1 - e^2) m v_n^2/4 of a total of 3 (n - 1) T/2, where v_n^2
    is distributed exponentially with mean 4 T/m. The sum over collisions is a compound Poisson sum,
    whose variance is their number times the mean square, 2 ((1 - e^2) T)^2. A colder gas cools more
    slowly, which reduces the scatter; this effect is neglected.
    """
    # Mean loss (1 - e^2) T of a collision over the energy 3 (n - 1) T/2.
    relative_loss = 2 * (1 - restitution**2) / (3 * (n - 1))
    return np.asarray(relative_loss * np.sqrt(2 * n_collisions))


def velocity_kurtosis(velocity: Array) -> float:
    """Excess kurtosis of the components of velocities (N, 3) [m/s] relative to their mean; 0 for
    Maxwell's distribution.
    """
    peculiar = velocity - velocity.mean(axis=0)
    # <c^4>/<c^2>^2 - 3.
    variance = np.mean(peculiar**2)
    return float(np.mean(peculiar**4) / variance**2 - 3)


def kurtosis_error(n: int) -> float:
    """Size of |excess kurtosis| to expect of M = 3 (n - 1) Gaussian numbers: its standard error
    sqrt(24/M) plus the size 6/M of its mean.
    """
    count = 3 * (n - 1)
    return float(np.sqrt(24 / count) + 6 / count)


def rough_temperatures(
    t: Array, t0: float, frequency: float, inertia: float
) -> tuple[Array, Array]:
    """Translational and rotational temperatures (T,) [J] at t (T,) [s] of elastic, perfectly rough
    spheres without initial spin.

    `frequency` is w_c at the start [1/s], `inertia` q = 4 J/(m d^2). The sum of both temperatures
    is T0; their difference D decays as D' = -8/3 w_c q/(1 + q)^2 D (Huthmann and Zippelius 1997,
    with e = beta = 1), where w_c is proportional to sqrt(T_translational). With u =
    sqrt(T_translational/T0), D = T0 (2 u^2 - 1) and D' = 4 T0 u u', so that

      u' = -rate/2 (2 u^2 - 1),   rate = 4/3 w_c(0) q/(1 + q)^2.
    """
    rate = 4 / 3 * frequency * inertia / (1 + inertia) ** 2
    root = np.sqrt(2)
    # The solution with u(0) = 1 is u = 1/(sqrt 2 tanh(rate t/sqrt 2 + artanh(1/sqrt 2))).
    phase = rate * t / root + np.arctanh(1 / root)
    u = 1 / (root * np.tanh(phase))
    flight: Array = t0 * u * u
    return flight, t0 - flight
