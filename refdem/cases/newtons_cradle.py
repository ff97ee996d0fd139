"""Newton's cradle: rigid balls in a line, apart by gaps, that meet two at a time."""

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
from refdem.scene.elements.contact import Contact

if TYPE_CHECKING:
    from refdem.truth.closed_forms.newtons_cradle import Course

Array = NDArray[np.float64]
MOST_BALLS = 7
"""Length of the lists of masses, radii and velocities; toys have five balls."""
SOLID = 2 / 5
"""J/(m R^2) of the balls, which never turn."""
AFTER_LAST = (1.125, 1.5)
"""The run ends between these multiples of the time of the last impact."""


def _of_each(name: str, default: str, unit: str, doc: str, above: float | None = None) -> Parameter:
    """A number of each ball from left to right; those of more balls than there are do not count."""
    return Parameter(
        name=name,
        default=",".join([default] * MOST_BALLS),
        unit=unit,
        doc=f"{doc}, from left to right; only those of the first `balls` count",
        shape=(MOST_BALLS,),
        above=above,
    )


class NewtonsCradle(Case):
    """The balls lie on the x axis; the first centre is at the origin at the start."""

    id = "newtons-cradle"
    title = "Newton's cradle"
    words = ("chain", "balls", "collision", "momentum")
    motion = "colliding"
    statement = (
        "Rigid balls in a line start apart, by gaps, and meet two at a time; nothing else acts on"
        " them. In each impact the closing speed of the two is turned round and multiplied by the"
        " restitution, and their momentum stays. Equal balls that lose nothing pass the velocity"
        " on: the last one leaves with that of the first. With other masses or a restitution below"
        " one the balls that were hit meet again, until each is faster than the one on its left."
        " Impacts of different pairs at one time commute; balls that two others hit at once are"
        " refused, for the outcome would depend on an order that nothing decides."
    )
    latex = (
        r"v_1'=v_1-\frac{(1+e)\,m_2}{m_1+m_2}(v_1-v_2),\quad"
        r" v_2'=v_2+\frac{(1+e)\,m_1}{m_1+m_2}(v_1-v_2)"
    )
    source = (
        "Mariotte 1673, Traite de la percussion; Newton 1687, Principia, scholium to the laws;"
        " Herrmann and Schmaelzle 1981, Am. J. Phys. 49; McNamara and Young 1992, Phys. Fluids A 4"
    )
    parameters = (
        Parameter(
            name="balls",
            default="5",
            unit="1",
            doc="how many there are",
            at_least=2,
            at_most=MOST_BALLS,
            whole=True,
        ),
        _of_each("masses", "1", "kg", "of the balls", above=0),
        _of_each("radii", "1/2", "m", "of the balls", above=0),
        Parameter(
            name="gaps",
            default=",".join(["1/4"] * (MOST_BALLS - 1)),
            unit="m",
            doc="between the surfaces of neighbours at the start, from left to right",
            shape=(MOST_BALLS - 1,),
            above=0,
        ),
        Parameter(
            name="velocities",
            default=",".join(["1"] + ["0"] * (MOST_BALLS - 1)),
            unit="m/s",
            doc="of the balls along x at the start, from left to right",
            shape=(MOST_BALLS,),
        ),
        Parameter(
            name="restitution",
            default="1",
            unit="1",
            doc="closing speed after an impact over that before it",
            at_least=0,
            at_most=1,
        ),
    )
    chaotic_at = NEVER

    def refuse(self, p: Parameters) -> None:
        """Raises UsageError for balls that never meet, or whose impacts have no order or no end."""
        if not _course(p).times:
            raise UsageError(
                "parameter velocities: no two balls ever meet; expected one that comes nearer to"
                " its neighbour on the right"
            )

    def scene(self, p: Parameters) -> Scene:
        """The balls apart, and the rigid law without friction."""
        count = int(p.balls)
        # The first centre at 0, each further one by both radii and the gap.
        apart = p.radii[: count - 1] + p.gaps[: count - 1] + p.radii[1:count]
        places = np.concatenate([[0.0], np.cumsum(apart)])
        along = np.array([1.0, 0.0, 0.0])
        bodies = []
        for k in range(count):
            body = _rigid.sphere(
                mass=p.masses[k],
                factor=SOLID,
                radius=p.radii[k],
                position=places[k] * along,
                velocity=p.velocities[k] * along,
                omega=np.zeros(3),
            )
            bodies.append(body)
        return Scene.of(bodies, [Contact(law="rigid", restitution=p.restitution)])

    def scales(self, p: Parameters) -> Scales:
        """tau is the shortest time between two impacts of one ball, at most that of a flight over
        R_i + R_(i+1) of any neighbours, in which one could pass the other unseen; L = v tau with
        the largest speed that any ball has. The run ends after the last impact.
        """
        count = int(p.balls)
        samples = int(p.samples)
        course = _course(p)
        times = np.array([float(time) for time in course.times])
        least, most = (float(times[-1]) * part for part in AFTER_LAST)
        duration = _rigid.clear_of_all(times, samples, least=least, most=most)
        fastest = float(course.fastest)
        reaches = p.radii[: count - 1] + p.radii[1:count]
        tau = float(reaches.min()) / fastest
        if course.shortest_wait is not None:
            tau = min(tau, float(course.shortest_wait))
        return Scales(
            length=fastest * tau,
            tau=tau,
            duration=duration,
            mass=float(p.masses[:count].max()),
        )

    def quantities(self, p: Parameters) -> tuple[Quantity, ...]:
        """Place and velocity of each ball."""
        scales = self.scales(p)
        found = []
        for k in range(1, int(p.balls) + 1):
            found.append(Quantity(f"r{k}.x", "m", scales.length))
            found.append(Quantity(f"v{k}.x", "m/s", scales.speed))
        return tuple(found)

    def observe(self, p: Parameters, trajectory: Trajectory) -> dict[str, Array]:
        """Place and velocity of each ball at the samples, each (T,)."""
        found = {}
        for k in range(int(p.balls)):
            found[f"r{k + 1}.x"] = trajectory.position[:, k, 0]
            found[f"v{k + 1}.x"] = trajectory.velocity[:, k, 0]
        return found

    def truth(self, p: Parameters) -> Truth:
        """All impacts in rational arithmetic."""
        from refdem.truth.closed_forms.newtons_cradle import truth

        return truth(p, {q.name: q.scale for q in self.quantities(p)})


def _course(p: Parameters) -> "Course":
    """The times of the impacts and the largest speed; UsageError where they have no order or no
    end.
    """
    from refdem.truth.balls import UndecidedError
    from refdem.truth.closed_forms.newtons_cradle import course_of

    try:
        return course_of(p)
    except UndecidedError as error:
        raise UsageError(
            f"parameters gaps, velocities and restitution: {error}; take others"
        ) from None


CASE = NewtonsCradle()
