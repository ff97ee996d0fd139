"""Two bobs on two rods, one below the other: regular at low energy, chaotic at high."""

import numpy as np
from numpy.typing import NDArray

from refdem.cases import _angles, _two_rods
from refdem.core.case import Case, given
from refdem.core.parameters import Parameter, Parameters
from refdem.core.quantity import Quantity, Scales
from refdem.core.trajectory import Trajectory
from refdem.core.truth import Truth
from refdem.scene import Body, Scene
from refdem.scene.elements.rod import Rod
from refdem.scene.elements.uniform_gravity import UniformGravity

Array = NDArray[np.float64]

OF_EQUAL_BOBS = 6.0
"""Largest squared rate of a rod over 2 E/I, for equal bobs on equal rods: 2 to 1/3."""


class DoublePendulum(Case):
    """Planar, gravity along -y; both angles from the downward vertical."""

    id = "double-pendulum"
    title = "Double pendulum"
    words = ("chaos", "robot", "arm", "linkage", "joint")
    motion = "swinging"
    statement = (
        "A second pendulum hangs from the bob of a first one. Its rods are constraints; energy is"
        " all that stays. Near the bottom it has two modes, at high energy its motion is chaotic:"
        " two neighbours part exponentially."
    )
    latex = (
        r"(m_1+m_2)l_1\ddot\theta_1+m_2l_2(\ddot\theta_2\cos\Delta+\dot\theta_2^2\sin\Delta)"
        r"+(m_1+m_2)g\sin\theta_1=0,\quad "
        r"l_2\ddot\theta_2+l_1(\ddot\theta_1\cos\Delta-\dot\theta_1^2\sin\Delta)+g\sin\theta_2=0,"
        r"\quad\Delta=\theta_1-\theta_2"
    )
    source = (
        "Matuttis and Chen 2014, chapter 1, section 1.6.4; Landau and Lifshitz, Mechanics, section"
        " 5, problem 1"
    )
    parameters = (
        Parameter(
            name="masses", default="1,1", unit="kg", doc="upper and lower bob", shape=(2,), above=0
        ),
        Parameter(
            name="lengths", default="1,1", unit="m", doc="upper and lower rod", shape=(2,), above=0
        ),
        Parameter(name="gravity", default="9.8125", unit="m/s^2", doc="along -y", above=0),
        Parameter(
            name="theta0", default="2,5/2", unit="rad", doc="angles at the start", shape=(2,)
        ),
        Parameter(
            name="thetadot0", default="0,0", unit="rad/s", doc="rates at the start", shape=(2,)
        ),
    )
    chaotic_at = given(theta0="3,3", duration="5", samples="96")

    def scene(self, p: Parameters) -> Scene:
        """The upper bob on a rod from the origin, the lower one on a rod from the upper.

        A rod at the angle theta has the direction (sin theta, -cos theta), and its end moves with l
        theta' (cos theta, sin theta) against its beginning.
        """
        # Unit vectors (2, 3) along the rods and across them.
        sine, cosine = _angles.sine_and_cosine(p, "theta0")
        zero = 0 * sine
        radial = np.stack([sine, -cosine, zero], axis=1)
        tangential = np.stack([cosine, sine, zero], axis=1)
        # The lower bob hangs from the upper: r2 = r1 + l2 radial2, and likewise its velocity.
        positions = np.cumsum(p.lengths[:, None] * radial, axis=0)
        velocities = np.cumsum((p.lengths * p.thetadot0)[:, None] * tangential, axis=0)
        columns = zip(p.masses, positions.tolist(), velocities.tolist(), strict=True)
        rods = [Rod(a=0, length=p.lengths[0]), Rod(a=1, b=0, length=p.lengths[1])]
        bobs = [Body(mass=m, position=tuple(r), velocity=tuple(v)) for m, r, v in columns]
        return Scene.of(bobs, [*rods, UniformGravity(g=(0.0, -p.gravity, 0.0))])

    def scales(self, p: Parameters) -> Scales:
        """L = l1 + l2, and 1/tau^2 = w1^2 + w2^2 + 2 E/I, or the rate of one rod if that is more.

        w1, w2 are the rates of the two modes at the bottom, w1^2 + w2^2 = g (m1 + m2)/m1 (1/l1 +
        1/l2). E is the energy above the bottom, I = (m1 + m2) l1^2 + m2 l2^2, so that 2 E/I is of
        the size of the squared rate at which all of the energy turns both rods. A light bob, or
        one on a short rod, is whipped round by the other: with all of the energy the rods turn at

            theta1'^2 <= 2 E/(m1 l1^2),   theta2'^2 <= 2 E (m1 + m2)/(m1 m2 l2^2),

        the largest values that T = E allows, which are up to 6 times 2 E/I for equal bobs and rods.
        The same part of them is taken as a rate of the motion. With the kinetic energy of the start
        alone, which one rod hands to the other soon, the largest values are taken themselves.
        """
        m1, m2 = p.masses
        l1, l2 = p.lengths
        total = p.masses.sum()
        # Each rod carries what hangs below it.
        carried = np.array([total, m2])
        # V = g (m1 + m2) l1 (1 - cos theta1) + g m2 l2 (1 - cos theta2).
        potential = p.gravity * (carried @ (p.lengths * (1 - np.cos(p.theta0))))
        # T = (m1 + m2) u1^2/2 + m2 u2^2/2 + m2 u1 u2 cos(theta1 - theta2), u = l theta'.
        u = p.lengths * p.thetadot0
        squares = 0.5 * carried @ u**2
        coupling = m2 * u.prod() * np.cos(p.theta0[0] - p.theta0[1])
        kinetic = squares + coupling
        energy = kinetic + potential
        modes = p.gravity * total / m1 * (1 / l1 + 1 / l2)
        of_both = modes + 2 * energy / (carried @ p.lengths**2)
        of_one = 2 * max(1 / (m1 * l1**2), total / (m1 * m2 * l2**2))
        whipped = of_one * max(energy / OF_EQUAL_BOBS, kinetic)
        tau = 1.0 / float(np.sqrt(max(of_both, whipped)))
        return Scales(length=float(l1 + l2), tau=tau, duration=20 * tau, mass=float(total))

    def quantities(self, p: Parameters) -> tuple[Quantity, ...]:
        """The quantities that are judged: angles [rad] and rates [rad/s]."""
        return _two_rods.quantities(self.scales(p).tau)

    def observe(self, p: Parameters, trajectory: Trajectory) -> dict[str, Array]:
        """Angles and their rates of the two rods: from the pivot to the upper bob, and from the
        upper to the lower bob.
        """
        # From the pivot, which rests at 0, and from the upper bob.
        r = np.diff(trajectory.position, axis=1, prepend=0.0)
        v = np.diff(trajectory.velocity, axis=1, prepend=0.0)
        return _two_rods.observe(r, v)

    def truth(self, p: Parameters) -> Truth:
        """The certified motion, by validated integration of the angles."""
        from refdem.truth.closed_forms.double_pendulum import truth

        return truth(p, {q.name: q.scale for q in self.quantities(p)})


CASE = DoublePendulum()
