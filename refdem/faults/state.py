"""What changes in a motion of the transparent engine: the state of the bodies and the loads on
them.
"""

from dataclasses import dataclass, field

from refdem.mechanics.vectors import Number, Quaternion, Vector
from refdem.scene.elements.rod import Rod


@dataclass(slots=True)
class State:
    """Position `r` [m], velocity `v` [m/s], attitude `q` and omega_body `w` [rad/s] of every body;
    the tangential spring `stretch` [m] of every pair; the dissipated `work` [J]; the time `t` [s].

    Modes, constant within a step: which pairs act, which of them press, which tangential springs
    slide at Coulomb's limit, the direction of slip of every slider (0: sticks), and the line (a
    rod, or None) of every hook.
    """

    r: list[Vector]
    v: list[Vector]
    q: list[Quaternion]
    w: list[Vector]
    stretch: list[Vector]
    work: Number = 0.0
    acting: list[bool] = field(default_factory=list)
    pressing: list[bool] = field(default_factory=list)
    sliding: list[bool] = field(default_factory=list)
    side: list[int] = field(default_factory=list)
    t: float = 0.0
    caught: list[Rod | None] = field(default_factory=list)

    def moved(
        self, r: list[Vector], v: list[Vector], q: list[Quaternion], w: list[Vector], t: float
    ) -> "State":
        """The state with other positions, velocities, attitudes and omegas at the time t.

        It shares all other lists with this state, and the given lists are not copied. A list of a
        state must therefore be replaced and not changed in place, except in a `copy`.
        """
        return State(
            r,
            v,
            q,
            w,
            self.stretch,
            self.work,
            self.acting,
            self.pressing,
            self.sliding,
            self.side,
            t,
            self.caught,
        )

    def copy(self) -> "State":
        """A state that can be changed without changing this one."""
        copied = self.moved(list(self.r), list(self.v), list(self.q), list(self.w), self.t)
        copied.stretch = list(self.stretch)
        copied.acting = list(self.acting)
        copied.pressing = list(self.pressing)
        copied.sliding = list(self.sliding)
        copied.side = list(self.side)
        copied.caught = list(self.caught)
        return copied


@dataclass(slots=True)
class Loads:
    """Force [N] (space axes) and torque [N m] (body axes) on every body; normal, slip [m/s] and
    tangential spring [m] of every pair; and the power [W] that is lost.
    """

    force: list[Vector]
    torque: list[Vector]
    normal: list[Vector]
    slip: list[Vector]
    stretch: list[Vector]
    power: Number
