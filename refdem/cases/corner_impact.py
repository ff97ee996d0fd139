"""A box that does not turn meets a plane with one corner, without friction, and turns away from it
(section 1.7.4).
"""

import numpy as np
from numpy.typing import NDArray

from refdem.cases import _plane, _rigid
from refdem.core.case import NEVER, Case
from refdem.core.parameters import Parameter, Parameters
from refdem.core.quantity import Quantity, Scales
from refdem.core.trajectory import Trajectory
from refdem.core.truth import Truth
from refdem.errors import UsageError
from refdem.scene import Body, Scene, box
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.plane import Plane

Array = NDArray[np.float64]
DEPTH = 1.0
"""The side of the box along z [m], which nothing depends on."""
SAFE = 0.875
"""The part of the time in which no corner can come down that a run lasts at most."""
ROUNDED = 2.0**-20
"""More than the part of it by which a duration may be rounded up."""
LEAST_APART = 1 / 64
"""Part of L that a second corner is at least above the plane at the impact: fixed steps see the
impact up to a step late, and a program may see two corners in the plane by then.
"""
MOST_TURNED = 3.0
"""The largest turn [rad] between samples: of half a turn the sense would not be known."""


class Meeting:
    """The impact of the lowest corner: its arm from the centre, when it comes, what it leaves, and
    for how long no corner comes down after it.
    """

    def __init__(self, p: Parameters) -> None:
        half = p.sides / 2
        sine = float(np.sin(p.angle))
        cosine = float(np.cos(p.angle))
        # The corner (-a/2, -b/2) is the lowest one for 0 < angle < pi/2.
        self.arm = np.array(
            [-half[0] * cosine + half[1] * sine, -half[0] * sine - half[1] * cosine]
        )
        self.time = float((p.height + self.arm[1]) / -p.velocity[1])
        self.moment = moment(p)
        closing = float(-p.velocity[1])
        # J = (1 + e) c/(1/m + x^2/I), with the arm x across the normal.
        ease = 1 / p.mass + self.arm[0] ** 2 / self.moment
        self.impulse = float((1 + p.restitution) * closing / ease)
        self.rise = float(p.velocity[1] + self.impulse / p.mass)
        self.omega = float(self.arm[0] * self.impulse / self.moment)
        # A corner at (x, y) from the centre is at least
        #     g + u s - R omega^2 s^2/2
        # above the plane at s after the impact, g being its height there, u = v + omega x, and R
        # its distance from the centre.
        self.radius = float(np.hypot(*half))
        turn = np.array([[cosine, -sine], [sine, cosine]])
        signs = np.array([[-1, -1], [-1, 1], [1, -1], [1, 1]])
        x, y = turn @ (signs * half).T
        gap = y - self.arm[1]
        gap[0] = 0.0
        self.second = float(gap[1:].min())
        rising = self.rise + self.omega * x
        bend = self.radius * self.omega**2
        roots = [root(g, u, bend) for g, u in zip(gap, rising, strict=True)]
        self.clear = min(roots)

    def duration(self, samples: int) -> float:
        """About twice the time [s] to the impact, or less where a second corner may come down; the
        impact is a third of an interval after a sample.
        """
        if self.is_clear_for_ever:
            return _rigid.clear_of(self.time, samples)
        latest = self.time + SAFE * self.clear
        intervals = max(samples // 2, int(np.ceil(self.time * samples / latest - 1 / 3)))
        return self.time * samples / (intervals + 1 / 3)

    @property
    def latest(self) -> float:
        """The time [s] until which no second corner can have met the plane, a little less for the
        last sample, which is rounded.
        """
        if self.is_clear_for_ever:
            return np.inf
        return (self.time + self.clear) * (1 - ROUNDED)

    @property
    def is_clear_for_ever(self) -> bool:
        """True if the centre is above all corners' reach before any can come down."""
        if not self.rise > 0:
            return False
        return bool((self.radius + self.arm[1]) / self.rise < self.clear)


def root(gap: float, rising: float, bend: float) -> float:
    """The time [s] > 0 up to which gap + rising s - bend s^2/2 stays above 0; infinite if it does
    for ever.
    """
    if bend == 0:
        if rising >= 0:
            return np.inf
        return -gap / rising
    return float((rising + np.sqrt(rising**2 + 2 * bend * gap)) / bend)


def moment(p: Parameters) -> float:
    """The moment of inertia m (a^2 + b^2)/12 [kg m^2] about z."""
    return float(p.mass * (p.sides @ p.sides) / 12)


class CornerImpact(Case):
    """The plane is y = 0, below the box; nothing acts but the impact, and the motion stays in the
    plane x-y.
    """

    id = "corner-impact"
    title = "Impact of a corner"
    words = ("box", "polyhedron", "collision", "impact", "restitution", "bounce", "floor")
    motion = "colliding"
    statement = (
        "A rigid box comes straight down, turned by an angle, and strikes a smooth plane with one"
        " corner. The impulse does not pass through its centre: a part of the motion goes into"
        " rotation, and the box leaves slower than a sphere would, and turning."
    )
    latex = (
        r"J=\frac{-(1+e)\,v_n}{1/m+(\mathbf r\times\mathbf n)\cdot I^{-1}(\mathbf r\times\mathbf"
        r" n)},\quad v'=v+\frac{J}{m}\mathbf n,\quad\omega'=I^{-1}(\mathbf r\times J\mathbf n)"
    )
    source = "Brach 1991, Mechanical impact dynamics"
    parameters = (
        Parameter(name="mass", default="2", unit="kg", doc="of the box", above=0),
        Parameter(
            name="sides",
            default="1,3/4",
            unit="m",
            doc="along its first and second axis",
            shape=(2,),
            above=0,
        ),
        Parameter(
            name="angle",
            default="5/8",
            unit="rad",
            doc="of its first axis from x; below pi/2",
            above=0,
            at_most=1.5,
        ),
        Parameter(name="height", default="3/2", unit="m", doc="of the centre, at first", above=0),
        Parameter(
            name="velocity", default="1/4,-1", unit="m/s", doc="of the centre, down", shape=(2,)
        ),
        Parameter(
            name="restitution",
            default="3/4",
            unit="1",
            doc="of the corner's velocity along the normal",
            above=0,
            at_most=1,
        ),
    )
    chaotic_at = NEVER

    def refuse(self, p: Parameters) -> None:
        """Raises UsageError for a box that does not come down, starts in the plane, or may come to
        meet it with another corner.
        """
        if not p.velocity[1] < 0:
            raise UsageError(
                f"parameter velocity: got {p.texts()['velocity']}; expected a box that comes down"
            )
        meeting = Meeting(p)
        if not p.height + meeting.arm[1] > 0:
            raise UsageError(
                f"parameter height: got {p.height:g} m; expected more than {-meeting.arm[1]:g} m,"
                " a box above the plane"
            )
        scales = self.scales(p)
        least = LEAST_APART * scales.length
        if meeting.second < least:
            raise UsageError(
                f"parameter angle: got {p.angle:g} rad, with which a second corner is"
                f" {meeting.second:.3g} m above the plane at the impact; expected at least"
                f" {least:.3g} m, so that steps which see the impact late see one corner"
            )
        lasts = p.duration or scales.duration
        latest = meeting.latest
        if lasts > latest:
            raise UsageError(
                f"parameter duration: got {lasts:.6g} s; expected at most {latest:.6g} s, after"
                " which a second corner may meet the plane"
            )
        turned = abs(meeting.omega) * lasts / p.samples
        if turned > MOST_TURNED:
            raise UsageError(
                f"parameter samples: got {int(p.samples)}, between which the box turns by"
                f" {turned:.3g} rad; expected so many that it turns by at most {MOST_TURNED:g} rad"
            )

    def scene(self, p: Parameters) -> Scene:
        """The box, the plane, and the rigid law without friction."""
        a, b = p.sides.tolist()
        inertia = (
            p.mass * (b * b + DEPTH**2) / 12,
            p.mass * (a * a + DEPTH**2) / 12,
            moment(p),
        )
        body = Body(
            mass=p.mass,
            inertia=inertia,
            shape=box(a, b, DEPTH),
            position=(0.0, p.height, 0.0),
            velocity=(*p.velocity.tolist(), 0.0),
            attitude=(float(np.cos(p.angle / 2)), 0.0, 0.0, float(np.sin(p.angle / 2))),
        )
        return Scene.of(
            [body],
            [Contact(law="rigid", restitution=p.restitution), Plane(normal=(0.0, 1.0, 0.0))],
        )

    def scales(self, p: Parameters) -> Scales:
        """L is the larger of height and radius, tau = L/v with the faster of centre and corner; it
        lasts twice the time to the impact, or as long as no corner can come down.
        """
        meeting = Meeting(p)
        length = max(p.height, meeting.radius)
        fastest = max(float(np.hypot(*p.velocity)), meeting.radius * abs(meeting.omega))
        return Scales(
            length=length,
            tau=length / fastest,
            duration=meeting.duration(int(p.samples)),
            mass=p.mass,
        )

    def quantities(self, p: Parameters) -> tuple[Quantity, ...]:
        """Place and velocity of the centre, angle of the first axis, and angular velocity."""
        s = self.scales(p)
        spin = s.speed / Meeting(p).radius
        turn = Quantity("theta", "rad", 1.0)
        return (*_plane.quantities(s.length, s.speed), turn, Quantity("omega", "rad/s", spin))

    def observe(self, p: Parameters, trajectory: Trajectory) -> dict[str, Array]:
        """The quantities (T,); theta without jumps by whole turns."""
        w = trajectory.attitude[:, 0, 0]
        z = trajectory.attitude[:, 0, 3]
        seen = _plane.observe_with_spin(trajectory)
        return seen | {"theta": np.unwrap(2 * np.arctan2(z, w))}

    def truth(self, p: Parameters) -> Truth:
        """Straight lines, one impulse, and a turn at a constant rate."""
        from refdem.truth.closed_forms.corner_impact import truth

        return truth(p, {q.name: q.scale for q in self.quantities(p)})


CASE = CornerImpact()
