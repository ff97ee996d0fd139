"""A break of billiards: a cue ball hits a rack of balls that lie apart by small gaps."""

from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from refdem.cases import _rigid
from refdem.core.case import NEVER, Case
from refdem.core.parameters import Parameter, Parameters
from refdem.core.quantity import Quantity, Scales
from refdem.core.trajectory import Trajectory
from refdem.core.truth import Truth
from refdem.errors import UsageError
from refdem.scene import Scene
from refdem.truth.exact import number, vector

if TYPE_CHECKING:
    from refdem.truth.closed_forms.billiard_break import Course

Array = NDArray[np.float64]
MOST_ROWS = 5
"""Rows of the rack: 15 balls, as in pool."""
AFTER_LAST = (1.125, 1.5)
"""A run that ends after the last of all impacts does so between these multiples of its time."""
TOLD_APART = 2.0**-24
"""Part of the time of an impact by which it must follow the one before it of one of its balls:
binary64 keeps 2^-52 of it, and impacts enlarge what is lost.
"""
WITHIN_WAIT = (1 / 4, 3 / 4)
"""Any other run ends between these parts of the wait for the impact that it does not show."""


class BilliardBreak(Case):
    """All centres lie in the plane z = 0; the apex of the rack is at the origin, its rows follow
    along +x, and the cue ball comes from -x.
    """

    id = "billiard-break"
    title = "Billiard break"
    words = ("billiards", "pool", "snooker", "rack", "collision")
    motion = "colliding"
    statement = (
        "A cue ball meets a rack of equal balls at rest: rows of 1, 2, ... balls, apart by gaps, so"
        " that they meet two at a time. Nothing else acts on them: there is no friction of the"
        " table. In each impact the closing speed of the two is turned round and multiplied by the"
        " restitution; friction between balls, if there is any, stops the slip of the points that"
        " touch, or reverses a part of it, and is cut at mu times the normal impulse. Momentum and"
        " total angular momentum stay, and energy falls in impacts only. An impact enlarges the"
        " errors of those before it, so that the order of impacts is proved one after another."
        " The rack is symmetric: hit along its axis of symmetry, the apex would meet two balls at"
        " one time, which is refused, for what comes out would depend on an order that nothing"
        " decides. The rows are 7/8 of the pitch of the balls in a row apart, which is sqrt(3)/2"
        " rounded up."
    )
    latex = (
        r"x_{kj}=\tfrac78\,k\,s,\quad y_{kj}=\left(j-\tfrac k2\right)s,\quad s=2R+\mathrm{gap};"
        r"\quad p_n=(1+e)\,\frac{\mathbf g\cdot\mathbf n}{1/m_1+1/m_2}"
    )
    source = (
        "Coriolis 1835, Theorie mathematique des effets du jeu de billard; Sinai 1970, Russ. Math."
        " Surv. 25, 137; Walton 1993, in Particulate two-phase flow, chapter 25"
    )
    parameters = (
        Parameter(
            name="rows",
            default="5",
            unit="1",
            doc="of the rack, of 1, 2, ... balls",
            at_least=2,
            at_most=MOST_ROWS,
            whole=True,
        ),
        Parameter(
            name="masses",
            default="1,1",
            unit="kg",
            doc="of the cue ball and of each ball of the rack",
            shape=(2,),
            above=0,
        ),
        Parameter(
            name="radii",
            default="1/2,1/2",
            unit="m",
            doc="of the cue ball and of each ball of the rack",
            shape=(2,),
            above=0,
        ),
        _rigid.INERTIA_FACTOR,
        Parameter(
            name="gap",
            default="1/16",
            unit="m",
            doc="between the surfaces of neighbours in a row",
            above=0,
        ),
        Parameter(
            name="distance",
            default="2",
            unit="1",
            doc="of the cue ball from the apex along -x at the start, in sums of the radii",
        ),
        Parameter(
            name="offset",
            default="1/8",
            unit="1",
            doc="of the cue ball along y at the start, in sums of the radii",
        ),
        Parameter(
            name="velocity",
            default="1,0",
            unit="m/s",
            doc="of the cue ball along x and y at the start",
            shape=(2,),
        ),
        Parameter(
            name="spin", default="0", unit="rad/s", doc="omega about z of the cue ball at the start"
        ),
        Parameter(
            name="restitution",
            default="15/16",
            unit="1",
            doc="closing speed after an impact over that before it",
            above=0,
            at_most=1,
        ),
        *_rigid.LAW[1:],
        Parameter(
            name="impacts",
            default="16",
            unit="1",
            doc="after so many the run ends, or after the last one, unless a duration is given",
            at_least=1,
            whole=True,
        ),
    )
    chaotic_at = NEVER

    def refuse(self, p: Parameters) -> None:
        """Raises UsageError for balls that overlap at the start or never meet, and for impacts
        whose order is not decided or that do not end.
        """
        if number(p, "offset") == 0 and vector(p, "velocity")[1] == 0:
            raise UsageError(
                "parameter offset: at 0 the cue ball comes along the rack's axis of symmetry, and"
                " the apex meets two balls at one time; expected any other offset"
            )
        if _overlaps_at_start(p):
            raise UsageError(
                "parameter distance: the cue ball touches or overlaps the rack at the start;"
                " expected it apart: take a larger distance"
            )
        course = _course(p)
        if not course.times:
            raise UsageError(
                "parameters velocity and offset: the cue ball passes the rack; expected a velocity"
                " that leads to it"
            )
        for time, wait in zip(course.times, course.waits, strict=True):
            if wait < TOLD_APART * time:
                raise UsageError(
                    f"parameters offset and velocity: near t = {time:.6g} s two impacts of one ball"
                    f" follow each other within {wait:.2g} s, so that rounding decides their order;"
                    " take others"
                )

    def scene(self, p: Parameters) -> Scene:
        """The cue ball, the rack row by row, and the rigid law."""
        from refdem.truth.closed_forms.billiard_break import centres

        velocity = np.array([*p.velocity, 0.0])
        omega = np.array([0.0, 0.0, p.spin])
        bodies = []
        for number_of_ball, (x, y) in enumerate(centres(p)):
            kind = min(number_of_ball, 1)
            body = _rigid.sphere(
                mass=p.masses[kind],
                factor=p.inertia_factor,
                radius=p.radii[kind],
                position=np.array([float(x), float(y), 0.0]),
                velocity=velocity,
                omega=omega,
            )
            bodies.append(body)
            # Only the cue ball moves.
            velocity = np.zeros(3)
            omega = np.zeros(3)
        return Scene.of(bodies, [_rigid.contact(p)])

    def scales(self, p: Parameters) -> Scales:
        """tau is that of a flight over one diameter, or shorter, so that the late detection of an
        impact does not change the order of impacts; L = V tau with V the largest speed that the
        energy allows.
        """
        course = _course(p)
        samples = int(p.samples)
        times = np.array(course.times)
        shown = int(p.impacts)
        if shown < len(times):
            wait = times[shown] - times[shown - 1]
            least, most = (float(times[shown - 1] + part * wait) for part in WITHIN_WAIT)
        else:
            least, most = (float(times[-1]) * part for part in AFTER_LAST)
        duration = _rigid.clear_of_all(times[:shown], samples, least=least, most=most)
        fastest = _fastest(p)
        longest = 2.0 * float(p.radii.min()) / fastest
        # A method that detects two impacts of one ball in one step may process them in the wrong
        # order.
        tau = _rigid.shortest_time(times, np.array(course.waits), longest)
        return Scales(length=fastest * tau, tau=tau, duration=duration, mass=float(p.masses.max()))

    def quantities(self, p: Parameters) -> tuple[Quantity, ...]:
        """Place and velocity of each ball; with friction also its angular velocity. Ball 0 is the
        cue ball.
        """
        scales = self.scales(p)
        spin = float(max(abs(p.spin), scales.speed / p.radii.min()))
        kinds = [("r{}.x", "m", scales.length), ("r{}.y", "m", scales.length)]
        kinds += [("v{}.x", "m/s", scales.speed), ("v{}.y", "m/s", scales.speed)]
        if p.friction > 0:
            kinds.append(("omega{}.z", "rad/s", spin))
        found = []
        for ball in range(_balls(p)):
            found += [Quantity(name.format(ball), unit, size) for name, unit, size in kinds]
        return tuple(found)

    def observe(self, p: Parameters, trajectory: Trajectory) -> dict[str, Array]:
        """Place and velocity of each ball at the samples, with friction also its angular velocity,
        each (T,).
        """
        found = {}
        for ball in range(_balls(p)):
            for axis, name in enumerate("xy"):
                found[f"r{ball}.{name}"] = trajectory.position[:, ball, axis]
                found[f"v{ball}.{name}"] = trajectory.velocity[:, ball, axis]
            if p.friction > 0:
                found[f"omega{ball}.z"] = trajectory.omega[:, ball, 2]
        return found

    def truth(self, p: Parameters) -> Truth:
        """Every impact in balls, in an order that is proved."""
        from refdem.truth.closed_forms.billiard_break import truth

        return truth(p, {q.name: q.scale for q in self.quantities(p)})


def _balls(p: Parameters) -> int:
    """The cue ball and n (n + 1)/2 of the rack."""
    rows = int(p.rows)
    return 1 + rows * (rows + 1) // 2


def _fastest(p: Parameters) -> float:
    """V = sqrt(2 T/m) [m/s], the speed of the lighter kind of balls with all of the energy T."""
    cue_moment = p.inertia_factor * p.masses[0] * p.radii[0] ** 2
    doubled_energy = p.masses[0] * float(p.velocity @ p.velocity) + cue_moment * p.spin**2
    return float(np.sqrt(doubled_energy / p.masses.min()))


def _overlaps_at_start(p: Parameters) -> bool:
    """True if the cue ball touches or overlaps a ball of the rack; exactly."""
    from refdem.truth.closed_forms.billiard_break import centres

    (x, y), *rack = centres(p)
    reach = sum(vector(p, "radii"), Fraction(0))
    return any((x - u) ** 2 + (y - v) ** 2 <= reach**2 for u, v in rack)


def _course(p: Parameters) -> "Course":
    """The times of the impacts; UsageError where they have no order or no end."""
    from refdem.truth.balls import UndecidedError
    from refdem.truth.closed_forms.billiard_break import course_of

    try:
        return course_of(p)
    except UndecidedError as error:
        raise UsageError(
            f"parameters offset, velocity and restitution: {error}; take others"
        ) from None


CASE = BilliardBreak()
