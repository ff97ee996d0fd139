"""Two pendulums whose bobs a spring joins: two modes, whose beats carry the energy to and fro."""

import numpy as np
from numpy.typing import NDArray

from refdem.cases import _angles, _two_rods
from refdem.core.case import Case
from refdem.core.parameters import Parameter, Parameters
from refdem.core.quantity import Quantity, Scales
from refdem.core.trajectory import Trajectory
from refdem.core.truth import Truth
from refdem.errors import UsageError
from refdem.scene import Body, Scene
from refdem.scene.elements.rod import Rod
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity

Array = NDArray[np.float64]
DURATION = 30.0
"""Duration in tau: at the default parameters the energy passes to the other pendulum within it."""
HIGHEST_ORDER = 8
"""The highest order of a method whose step is held to tau."""
PASS_STEP = 0.1
"""Step of the search for close passes of the bobs, in units of the shortest time of the moment."""
MOST_PASS_STEPS = 5_000
"""Steps after which the search ends."""
FASTEST_PASS = 1e6
"""The largest rate of a pass in units of that of the motion without it: no step resolves more, as
where the bobs meet.
"""


class CoupledPendulums(Case):
    """Planar, gravity along -y; the first pivot at the origin, the second at (d, 0)."""

    id = "coupled-pendulums"
    title = "Coupled pendulums"
    words = ("beat", "spring", "modes", "clocks")
    motion = "swinging"
    statement = (
        "Two bobs on rods swing side by side, joined by a spring. Alike, they have two modes: in"
        " step, where the spring never stretches, and against each other, where it makes them"
        " faster. A swing that begins in one pendulum is both modes at once: it passes to the other"
        " pendulum and back. The rods are constraints and the spring is a force: a code must have"
        " both right at the same body."
    )
    latex = (
        r"m_1l_1\ddot\theta_1=-m_1g\sin\theta_1+F\,\mathbf n\cdot\mathbf t_1,\quad"
        r" m_2l_2\ddot\theta_2=-m_2g\sin\theta_2-F\,\mathbf n\cdot\mathbf t_2,\quad"
        r" F=k(|\mathbf r_2-\mathbf r_1|-s),\quad\mathbf n=\frac{\mathbf r_2-\mathbf"
        r" r_1}{|\mathbf r_2-\mathbf r_1|},\quad\mathbf t_i=(\cos\theta_i,\sin\theta_i)"
    )
    source = "Landau and Lifshitz, Mechanics, section 23; French, Vibrations and Waves, chapter 5"
    parameters = (
        Parameter(name="masses", default="1,1", unit="kg", doc="of the bobs", shape=(2,), above=0),
        Parameter(name="lengths", default="1,1", unit="m", doc="of the rods", shape=(2,), above=0),
        Parameter(
            name="distance", default="3/4", unit="m", doc="between the pivots, along x", above=0
        ),
        Parameter(name="gravity", default="9.8125", unit="m/s^2", doc="along -y", above=0),
        Parameter(name="stiffness", default="2", unit="N/m", doc="of the spring", above=0),
        Parameter(
            name="spring_length",
            default="3/4",
            unit="m",
            doc="of the spring without force",
            at_least=0,
        ),
        Parameter(
            name="theta0", default="3/4,0", unit="rad", doc="angles at the start", shape=(2,)
        ),
        Parameter(
            name="thetadot0", default="0,0", unit="rad/s", doc="rates at the start", shape=(2,)
        ),
    )

    def refuse(self, p: Parameters) -> None:
        """Raises UsageError if the bobs start in one place, where the spring has no direction."""
        if not np.linalg.norm(self._spring_vector(p)) > 0:
            raise UsageError(
                "coupled-pendulums: both bobs start in one place, where the spring has no"
                " direction; change theta0, lengths or distance"
            )

    def _spring_vector(self, p: Parameters) -> Array:
        """The vector (2,) [m] from the first bob to the second at the start."""
        first, second = _positions(p)
        difference: Array = second[:2] - first[:2]
        return difference

    def scene(self, p: Parameters) -> Scene:
        """The two bobs on their rods, and the spring between them."""
        # A bob moves with l theta' along the tangent (cos theta, sin theta).
        sine, cosine = _angles.sine_and_cosine(p, "theta0")
        tangential = np.stack([cosine, sine, 0 * sine], axis=1)
        velocities = (p.lengths * p.thetadot0)[:, None] * tangential
        columns = zip(p.masses, _positions(p).tolist(), velocities.tolist(), strict=True)
        bobs = [Body(mass=m, position=tuple(r), velocity=tuple(v)) for m, r, v in columns]
        rods = [
            Rod(a=0, length=p.lengths[0]),
            Rod(a=1, length=p.lengths[1], anchor_b=(p.distance, 0.0, 0.0)),
        ]
        spring = Spring(a=0, b=1, stiffness=p.stiffness, length=p.spring_length)
        return Scene.of(bobs, [*rods, spring, UniformGravity(g=(0.0, -p.gravity, 0.0))])

    def _largest_force(self, p: Parameters, energy: float) -> float:
        """Bound [N] of the force of the spring: k s with k s^2/2 <= E, and s the farthest from its
        length without force that the rods let it be.
        """
        reach = float(p.lengths.sum())
        longest = p.distance + reach
        shortest = max(p.distance - reach, 0.0)
        by_rods = max(abs(longest - p.spring_length), abs(shortest - p.spring_length))
        by_energy = float(np.sqrt(2 * energy / p.stiffness))
        return float(p.stiffness * min(by_rods, by_energy))

    def scales(self, p: Parameters) -> Scales:
        """L = l1 + l2, and 1/tau^2 = g/l1 + g/l2 + k/m1 + k/m2 + 2 E/I, or the square of the faster
        rate at the start, or F/(m l), if that is more.

        The first four terms are the sum of the squared rates of the two modes near the bottom. E is
        the energy above rods that hang and a spring without force, I = m1 l1^2 + m2 l2^2, so that 2
        E/I is of the size of the squared rate at which all of the energy turns both rods. A light
        bob may begin faster than that. A spring that is stretched far pulls a light bob as a strong
        gravity does: F is the largest force that the energy and the lengths of the rods allow, m l
        that of the bob that it turns faster. Bobs that pass each other closely turn the spring
        faster than any of these, as `_rate_of_passes` finds.
        """
        slow = self._time_without_passes(p)
        duration = DURATION * slow
        return Scales(
            length=float(p.lengths.sum()),
            tau=1.0 / max(1.0 / slow, _rate_of_passes(p, slow, p.duration or duration)),
            duration=duration,
            mass=float(p.masses.sum()),
        )

    def _time_without_passes(self, p: Parameters) -> float:
        """The shortest time [s] of a motion in which the bobs do not pass each other closely."""
        inertia = float(p.masses @ p.lengths**2)
        kinetic = 0.5 * float(p.masses @ (p.lengths * p.thetadot0) ** 2)
        heights = p.lengths * (1 - np.cos(p.theta0))
        stretch = float(np.linalg.norm(self._spring_vector(p))) - p.spring_length
        potential = p.gravity * float(p.masses @ heights) + 0.5 * p.stiffness * stretch**2
        modes = p.gravity * float(np.sum(1 / p.lengths)) + p.stiffness * float(np.sum(1 / p.masses))
        energy = kinetic + potential
        of_both = modes + 2 * energy / inertia
        at_start = float(np.max(p.thetadot0**2))
        pulled = self._largest_force(p, energy) / float(np.min(p.masses * p.lengths))
        return 1.0 / float(np.sqrt(max(of_both, at_start, pulled)))

    def quantities(self, p: Parameters) -> tuple[Quantity, ...]:
        """The quantities that are judged: angles [rad] and rates [rad/s]."""
        return _two_rods.quantities(self._time_without_passes(p))

    def observe(self, p: Parameters, trajectory: Trajectory) -> dict[str, Array]:
        """Angles and their rates of the two rods, each from its pivot to its bob."""
        pivots = np.array([[0.0, 0.0, 0.0], [p.distance, 0.0, 0.0]])
        return _two_rods.observe(trajectory.position - pivots, trajectory.velocity)

    def truth(self, p: Parameters) -> Truth:
        """The certified motion, by validated integration of the angles."""
        from refdem.truth.closed_forms.coupled_pendulums import truth

        return truth(p, {q.name: q.scale for q in self.quantities(p)})


def _positions(p: Parameters) -> Array:
    """The places (2, 3) [m] of the bobs at the start: r = pivot + l (sin theta, -cos theta)."""
    pivots = np.array([[0.0, 0.0, 0.0], [p.distance, 0.0, 0.0]])
    sine, cosine = _angles.sine_and_cosine(p, "theta0")
    radial = np.stack([sine, -cosine, 0 * sine], axis=1)
    positions: Array = pivots + p.lengths[:, None] * radial
    return positions


def _rate_of_passes(p: Parameters, slow: float, until: float) -> float:
    """The largest rate [1/s] that steps have to resolve since the bobs pass each other; 0 where the
    spring has no length without force, and so needs no direction.

    Bobs that pass at the distance s with the velocity v turn the spring at the rate w = v/s, during
    1/w. In that time a spring that gives a bob the acceleration a changes its velocity by a/w, and
    a step h of a method of order p errs by about (h w)^p of it. With `slow`, the shortest time
    without passes, and L = l1 + l2 that is (h r)^p of L/slow, the scale of velocities, where

        r = w (a slow/(w L))^(1/p).

    The motion is followed in binary64 until a time, by steps of Runge and Kutta that are short
    beside 1/w; no more than MOST_PASS_STEPS, for a motion of many passes is soon past foretelling.
    The rate is FASTEST_PASS/slow at most.
    """
    if p.spring_length == 0:
        return 0.0

    def tangents(theta: Array) -> NDArray[np.complex128]:
        # In the complex plane (cos th, sin th) is exp(i th), and a bob hangs at -i l exp(i th).
        along: NDArray[np.complex128] = np.exp(1j * theta)
        return along

    def spring(theta: Array) -> complex:
        first, second = -1j * p.lengths * tangents(theta)
        return complex(p.distance + second - first)

    def rates(y: Array) -> Array:
        theta, thetadot = y
        vector = spring(theta)
        force = p.stiffness * (1 - p.spring_length / abs(vector)) * vector
        on_bobs = np.array([force, -force])
        pulls = np.real(on_bobs * np.conj(tangents(theta)))
        accelerations = pulls / p.masses - p.gravity * np.sin(theta)
        return np.array([thetadot, accelerations / p.lengths])

    def rate_of_pass(y: Array) -> float:
        theta, thetadot = y
        first, second = p.lengths * thetadot * tangents(theta)
        return float(abs(second - first) / abs(spring(theta)))

    y = np.array([p.theta0, p.thetadot0])
    t = 0.0
    largest = 0.0
    for _ in range(MOST_PASS_STEPS):
        w = rate_of_pass(y)
        stretch = abs(spring(y[0])) - p.spring_length
        if w > 0:
            share = p.stiffness * abs(stretch) / min(p.masses) * slow / (w * p.lengths.sum())
            largest = max(largest, w * share ** (1 / HIGHEST_ORDER))
        if t >= until:
            break
        h = min(PASS_STEP / max(w, 1 / slow), until - t)
        k1 = rates(y)
        k2 = rates(y + h / 2 * k1)
        k3 = rates(y + h / 2 * k2)
        k4 = rates(y + h * k3)
        y = y + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        t += h
    return min(largest, FASTEST_PASS / slow)


CASE = CoupledPendulums()
