"""Collisions to round-off: Bulirsch and Stoer's extrapolation (1966) from event to event of the
contact law.
"""

from math import ceil, log2, pi, sqrt

from refdem.core.engine import Method
from refdem.core.problem import Motion, Request
from refdem.scene import Scene
from refdem.scene.elements.contact import Contact
from refdem.solvers import _particles
from refdem.solvers._particles import Array
from refdem.solvers.rk4 import METHOD as RK4


class ContactEvents(_particles.ParticleSolver):
    """Oblique, spinning, damped collisions with friction; contact, stick, slip and release are
    located to round-off.
    """

    claims = Method(
        name="contact-events",
        summary=(
            "extrapolated midpoint rule to round-off; contact, stick, slip and release as events"
        ),
        control="exact",
        conserves=frozenset({"momentum", "angular-momentum"}),
        backward=True,
        cost_rank=20,
    )

    def unsupported_values(self, problem: Motion) -> str | None:
        """None for linear contact between shapes that can meet, else the reason."""
        law = _particles.contact_of(problem.scene)
        if law is None:
            return "no shapes that can meet"
        if law.law != "linear":
            return f"contact law {law.law}: not smooth at its onset"
        return RK4.unsupported_values(problem)

    def origin(self, scene: Scene) -> Array:
        """The middle of the shapes: far from the origin, rounding of positions would keep a step
        from converging.
        """
        return _particles.middle(scene)

    def stride(self, request: Request) -> int:
        """Steps per sample: a power of two for which a step is at most 1/20 of the shortest
        contact.

        Events inside a step are found from sign changes between its ends.
        """
        scene = request.problem.scene
        # A contact lasts half a period, pi sqrt(m_eff/k); two bodies of the least mass m have the
        # effective mass m_eff = m/2.
        lightest = float(scene.bodies.mass.min())
        stiffness = scene.all(Contact)[0].stiffness
        longest = pi * sqrt(lightest / 2 / stiffness) / 20
        halvings = max(0, ceil(log2(abs(request.problem.interval) / longest)))
        return int(2**halvings)


METHOD = ContactEvents()
