"""The parts of the transparent engine by name and type: what its steps call, and what a fault
replaces (`inside`).

The modules of the engine call each other's functions only through this record, so that any of them
can be replaced. `correct_parts.py` has the correct ones.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, Protocol

from refdem.faults.iterating import MapParts
from refdem.faults.state import Loads, State
from refdem.faults.world import World
from refdem.mechanics.vectors import Number, Quaternion, Vector
from refdem.scene.element import Element
from refdem.scene.elements.catch import Catch
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.piecewise_field import PiecewiseField
from refdem.scene.elements.rod import Rod
from refdem.scene.elements.slider import Slider
from refdem.scene.elements.string_over_wheel import StringOverWheel
from refdem.scene.elements.wedge import Wedge


@dataclass(frozen=True, kw_only=True)
class HoldingParts:
    """The parts of motions with constraints, by name."""

    line_caught: Callable[[Catch, Number, float], Number]
    string_excess: Callable[[StringOverWheel, Number, Number], Number]
    string_speed: Callable[[StringOverWheel, Number, Number], Number]
    tip_torque: Callable[[Vector, Vector], Vector]


@dataclass(frozen=True, kw_only=True)
class PositionalParts:
    """The parts of positional forces, by name."""

    field_force: Callable[[PiecewiseField, Number], Number]
    wedge_force: Callable[[Wedge, Number, bool, Number], Number]


@dataclass(frozen=True, kw_only=True)
class ImpactParts:
    """The parts of impacts of the rigid law, by name."""

    normal_impulse: Callable[[Contact, Number, Number], Number]
    tangential_ease: Callable[[Number, Number, Number], Number]
    tangential_impulse: Callable[[Contact, Number, Vector, Number], Vector]
    corner_ease: Callable[[Number, Vector, Vector], Number]
    corner_torque: Callable[[Vector, Vector], Vector]
    meets: Callable[[Number], bool]


@dataclass(frozen=True, kw_only=True)
class RollingParts:
    """The parts of a rigid sphere that slides and rolls, by name."""

    pressing: Callable[[Vector, Vector], Number]
    rubbing: Callable[[Contact, Number, Vector], Vector]
    holding: Callable[[Vector, Number, Number], Vector]
    grips: Callable[[Contact, Number, Number], bool]
    slips_on: Callable[[Vector, Vector], Number]


@dataclass(frozen=True, kw_only=True)
class TangentParts:
    """The parts of the differentiated motion (`tangent.py`), by name."""

    time_to_impact: Callable[[Any], Any]
    time_left: Callable[[Any, Any], Any]
    reported_state: Callable[[Any, Any], Any]


class LoadsOfState(Protocol):
    """The loads of a state that was reached from one with the loads `before` in a step of h [s]."""

    def __call__(
        self,
        world: World,
        state: State,
        parts: "Parts",
        before: Loads | None = None,
        h: Number = 0.0,
        /,
    ) -> Loads:
        """Forces and torques on every body."""


AxisTurn = Callable[[int, Vector, Vector, Quaternion, Number], tuple[Vector, Quaternion]]
"""From an axis, moments of inertia, omega_body, attitude and h: omega_body and attitude after the
rotation.
"""
Located = Callable[[Callable[[float], float], float, float, float], float]
"""From a guard, its values at both ends and a resolution: the point at which it falls below 0."""


@dataclass(frozen=True, kw_only=True)
class Parts:
    """All parts of the engine, by name."""

    forces: Mapping[type[Element], Callable[..., Vector]]
    gyroscopic: Callable[[Vector, Vector], Vector]
    turn_rate: Callable[[Quaternion, Vector], Quaternion]
    turned: Callable[[Quaternion, Vector, Number], Quaternion]
    axis_turn: AxisTurn
    to_body: Callable[[Quaternion, Vector], Vector]
    to_space: Callable[[Quaternion, Vector], Vector]
    unit: Callable[[Quaternion], Quaternion]
    kicked: Callable[[Vector, Vector, Number, Number], Vector]
    spun_up: Callable[[Vector, Vector, Vector, Number], Vector]
    drifted: Callable[[Vector, Vector, Number], Vector]
    reaction: Callable[[Vector], Vector]
    away: Callable[[Vector, Vector], Vector]
    overlap: Callable[[Number, Number, Number], Number]
    normal_force: Callable[[Contact, Number, Number], Number]
    lever: Callable[[Number, Number, Number], Number]
    slip: Callable[[Vector, Vector, Vector], Vector]
    transported: Callable[[Vector, Vector, Vector], Vector]
    stretched: Callable[[Vector, Vector, Vector, Number], Vector]
    clipped: Callable[[Contact, Vector, Number], Vector]
    spring_friction: Callable[[Contact, Vector], Vector]
    sliding_friction: Callable[[Contact, Number, Vector, Number], Vector]
    torque_on: Callable[[Number, Vector, Vector], Vector]
    presses: Callable[[Contact, Number, Number], Number]
    slides_at: Callable[[Slider, Vector], Number]
    slider_force: Callable[[Slider, int, Number], Vector]
    holds: Callable[[Slider, Number], bool]
    rod_position: Callable[[Rod, Vector, Vector, Number], Number]
    rod_velocity: Callable[[Rod, Vector, Vector, Number], Number]
    rod_tension: Callable[[Rod, Vector, Vector, Vector, Number], Number]
    clock: Callable[[Number, int, Number], Number]
    fresh: Callable[[dict[str, Any]], None]
    output: Callable[[State], State]
    loads: LoadsOfState
    side_of: Callable[["Moving", State, int, Number], int]
    located: Located
    flow: Callable[[float, float, float, float, float], tuple[float, float]]
    maps: MapParts
    positional: PositionalParts
    holding: HoldingParts
    impacts: ImpactParts
    rolling: RollingParts
    tangent: TangentParts
    verlet_kicks: tuple[float, float]
    suzuki: tuple[float, ...]
    rk4_nodes: tuple[float, ...]
    rk4_weights: tuple[float, ...]

    def with_(self, **changed: Any) -> "Parts":
        """The same parts with some replaced."""
        return replace(self, **changed)


Step = Callable[["Moving", State, Loads, Number], tuple[State, Loads]]
"""One step of a method: from a state and its loads to the state and the loads at its end."""


class Moving:
    """A world, the parts of the engine, the direction of time (1, or -1 for steps back), and the
    events so far: time, kind, body.
    """

    def __init__(self, world: World, parts: Parts, sense: float = 1.0) -> None:
        self.world = world
        self.parts = parts
        self.sense = sense
        self.events: list[tuple[float, str, int]] = []
        self.turning = [i for i, turns in enumerate(world.turns) if turns and not world.fixed[i]]
        jointed = {joint.a for joint in world.joints}
        self.free = [i for i, fixed in enumerate(world.fixed) if not fixed and i not in jointed]
        self.tied = bool(world.rods or world.hooks or world.strings or world.joints)
        self.depends_on_velocity = world.depends_on_velocity
        self.reads_velocity = self.depends_on_velocity or world.reads_clock or not world.is_smooth
