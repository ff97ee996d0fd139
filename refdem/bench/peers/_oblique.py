"""Two spheres that touch, hold or slip, and part in a plane, by heyoka: a system of equations for
each mode of the contact, which lasts until an event.

The state is (d, g, q, a, w1, w2, s): overlap d and its rate g, transverse velocity q of the second
sphere from the first, angle a of the line of centres, spins w1 and w2 about z, stretch s of the
tangential spring. With the distance r = R1 + R2 - d of the centres, the normal force N = k d + c g,
the tangential force T and 1/m = 1/m1 + 1/m2

    d' = g,   g' = -q a' - N/m,   q' = g a' - T/m,   a' = q/r,   w_i' = A_i T/J_i,

where A_i is the lever of T on sphere i, and the slip is A1 w1 + A2 w2 - q. While the spring holds,
s' = slip and T = -k_t s; while it slips, T = -+mu N and s rests; without friction T = 0.
"""

from dataclasses import dataclass
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from refdem.core import discovery
from refdem.core.problem import Motion
from refdem.core.trajectory import Trajectory
from refdem.scene import Scene
from refdem.scene.elements.contact import Contact

Array = NDArray[np.float64]
HOLDS, SLIPS, FREE, APART = range(4)
"""Modes: the spring holds, the contact slips, it has no friction, the spheres have parted."""
INSIDE = 1 - 1e-14
"""A spring that begins to hold is shorter than its longest by this, so that no event is seen where
it begins.
"""


@dataclass(frozen=True)
class Friction:
    """Friction in one mode of the contact, in expressions of heyoka.

    The tangential force T, the rate s' of the spring, margins that end the mode where they fall to
    0, and first values of the integrator's parameters: the side of the slip, which only SLIPS has.
    """

    force: Any
    stretching: Any
    endings: tuple[Any, ...] = ()
    parameters: tuple[float, ...] = ()


@dataclass(frozen=True, eq=False)
class Oblique:
    """A scene of two spheres that touch, centres along x, moving in the plane z = 0."""

    scene: Scene
    law: Contact

    @property
    def key(self) -> tuple[Any, ...]:
        """The numbers on which the equations depend."""
        bodies = self.scene.bodies
        return (
            self.law,
            *bodies.mass.tolist(),
            *bodies.radius.tolist(),
            *bodies.inertia[:, 0].tolist(),
        )

    @property
    def longest_stretch(self) -> float:
        """mu/k_t, the length of the tangential spring at Coulomb's limit over the normal force
        [m/N]; 0 without friction.
        """
        if self.law.friction:
            return self.law.friction / self.law.tangential_stiffness
        return 0.0

    def start(self) -> tuple[list[float], int, float]:
        """The initial state, the mode of the contact and the side of the slip, 1 or -1."""
        bodies = self.scene.bodies
        relative = bodies.velocity[1] - bodies.velocity[0]
        spin1, spin2 = bodies.omega[:, 2]
        overlap_rate = -relative[0]
        slip = float(bodies.radius[0] * spin1 + bodies.radius[1] * spin2 - relative[1])
        state = [0.0, overlap_rate, relative[1], 0.0, spin1, spin2, 0.0]
        side = -1.0
        if slip > 0:
            side = 1.0
        if not self.law.friction:
            return state, FREE, side
        # The spring holds if k_t |slip|, the rate of its force, is at most that of Coulomb's limit,
        # mu k g; with a dashpot the limit is above 0 at once.
        longest_rate = self.longest_stretch * self.law.stiffness * overlap_rate
        if self.law.damping or abs(slip) <= longest_rate:
            return state, HOLDS, side
        return state, SLIPS, side

    def integrators(self, tolerance: float | None) -> list[Any]:
        """heyoka's integrators of the modes HOLDS, SLIPS and FREE; without friction of FREE alone.

        Each stops at the events that end its mode.
        """
        modes: tuple[int, ...] = (FREE,)
        if self.law.friction:
            modes = (HOLDS, SLIPS, FREE)
        return [self._integrator(mode, tolerance) for mode in modes]

    def _integrator(self, mode: int, tolerance: float | None) -> Any:
        """heyoka's integrator of one mode: the equations of the module's docstring, and as events
        what ends the mode where it falls to 0, the overlap first.
        """
        import heyoka

        bodies = self.scene.bodies
        law = self.law
        variables = heyoka.make_vars("d", "g", "q", "a", "w1", "w2", "s")
        d, g, q, _, spin1, spin2, s = variables
        radius1, radius2 = bodies.radius.tolist()
        inertia1, inertia2 = bodies.inertia[:, 0].tolist()
        inverse_mass = float(np.sum(1 / bodies.mass))
        normal_force = law.stiffness * d + law.damping * g
        # a' = q/r, r = R1 + R2 - d.
        angle_rate = q / (radius1 + radius2 - d)
        # g' = d'' = -q a' - N/m.
        overlap_acceleration = -q * angle_rate - inverse_mass * normal_force
        lever1 = radius1 - law.torque_shortening * d
        lever2 = radius2 - law.torque_shortening * d
        slip = lever1 * spin1 + lever2 * spin2 - q
        force_rate = law.stiffness * g + law.damping * overlap_acceleration
        friction = self._friction(mode, normal_force, force_rate, slip, s)
        rates = [
            g,
            overlap_acceleration,
            g * angle_rate - inverse_mass * friction.force,
            angle_rate,
            lever1 * friction.force / inertia1,
            lever2 * friction.force / inertia2,
            friction.stretching,
        ]
        system = []
        for variable, rate in zip(variables, rates, strict=True):
            if isinstance(rate, float):
                rate = heyoka.expression(rate)
            system.append((variable, rate))
        falling = heyoka.event_direction.negative
        events = [heyoka.t_event(margin, direction=falling) for margin in (d, *friction.endings)]
        return heyoka.taylor_adaptive(
            system,
            [0.0] * len(variables),
            pars=friction.parameters,
            t_events=events,
            tol=tolerance,
        )

    def _friction(
        self, mode: int, normal_force: Any, force_rate: Any, slip: Any, stretch: Any
    ) -> "Friction":
        """The friction of a mode in expressions of heyoka: the normal force N and its rate, slip
        and stretch s of the tangential spring.
        """
        import heyoka

        law = self.law
        if mode == HOLDS:
            # |k_t s| reaches mu N, on either side.
            longest = self.longest_stretch * normal_force
            force = -law.tangential_stiffness * stretch
            return Friction(force, slip, endings=(longest - stretch, longest + stretch))
        if mode == SLIPS:
            side = heyoka.par[0]
            # The spring of length mu N/k_t holds again once N grows faster than the slip stretches
            # it: side slip - (mu/k_t) N' falls below 0.
            endings = [side * slip - self.longest_stretch * force_rate]
            if law.damping:
                endings.append(normal_force)
            force = -side * law.friction * normal_force
            return Friction(force, 0.0, endings=tuple(endings), parameters=(1.0,))
        return Friction(0.0, 0.0)

    def followed(self, integrators: list[Any], t: Array) -> tuple[list[Array], int, float]:
        """States in touch at the samples, then the one at which they part, if they do, with its
        time as last number; steps; seconds.

        The seconds are those of heyoka's own loops alone: what sets them up between events is no
        part of a compiled program's time.
        """
        state, mode, side = self.start()
        states = [np.array(state)]
        now = t[0]
        steps = 0
        seconds = 0.0
        while len(states) < len(t):
            # Without friction there is one mode, and one integrator.
            number = 0
            if self.law.friction:
                number = mode
            integrator = integrators[number]
            integrator.time = now
            integrator.state[:] = state
            if mode == SLIPS:
                integrator.pars[0] = side
            event, new_steps, new_seconds = _propagated(integrator, t, states)
            steps += new_steps
            seconds += new_seconds
            if len(states) == len(t):
                break
            now = integrator.time
            state = integrator.state.copy()
            mode, side = self._after(mode, side, event, state)
            if mode == APART:
                states.append(np.array([*state, now]))
                break
        return states, steps, seconds

    def _after(self, mode: int, side: float, event: int, state: Array) -> tuple[int, float]:
        """Mode and side of the slip after event number `event` of the mode; the spring of the state
        is set in place where it begins to hold.
        """
        # The first event of every mode is the end of the overlap.
        if event == 0:
            return APART, side
        if mode == HOLDS and event == 1:
            return SLIPS, 1.0
        if mode == HOLDS:
            return SLIPS, -1.0
        # The second event of a slip is the end of a force that a dashpot would turn round.
        if event != 1:
            return FREE, side
        overlap = state[0]
        rate = state[1]
        force = self.law.stiffness * overlap + self.law.damping * rate
        state[6] = side * INSIDE * self.longest_stretch * force
        return HOLDS, side

    def trajectory(self, t: Array, states: list[Array]) -> Trajectory:
        """The motion of both spheres, straight on once they have parted."""
        bodies = self.scene.bodies
        # Numbers 0 to 6 are the state; a last state of 8 has the time at which they part, too.
        has_parted = len(states[-1]) == 8
        d, g, q, angle, spin1, spin2, _ = np.array([row[:7] for row in states]).T
        # The branch vector r (cos a, sin a), r = R1 + R2 - d, and its rate.
        distance = bodies.radius.sum() - d
        c = np.cos(angle)
        s = np.sin(angle)
        branch = distance * np.array([c, s])
        branch_rate = np.array([-g * c - q * s, -g * s + q * c])
        spins = np.array([spin1, spin2])
        if has_parted:
            # Straight on with the last velocities, from the time at which they part.
            since = t[len(states) - 1 :] - states[-1][7]
            flight = branch[:, -1:] + branch_rate[:, -1:] * since
            branch = np.concatenate([branch[:, :-1], flight], axis=1)
            branch_rate = _held(branch_rate, len(since))
            spins = _held(spins, len(since))
        # About the centre of mass: r1 = -m2/(m1 + m2) of the branch vector, r2 = m1/(m1 + m2).
        total = bodies.mass.sum()
        share = np.array([-bodies.mass[1], bodies.mass[0]])[:, None] / total
        centre = bodies.mass @ bodies.position / total
        drift = bodies.mass @ bodies.velocity / total
        position = np.zeros((len(t), 2, 3))
        velocity = np.zeros((len(t), 2, 3))
        omega = np.zeros((len(t), 2, 3))
        position[:, :, :2] = branch.T[:, None] * share
        velocity[:, :, :2] = branch_rate.T[:, None] * share
        omega[:, :, 2] = spins.T
        position += centre + drift * (t - t[0])[:, None, None]
        velocity += drift
        attitude = np.broadcast_to(bodies.attitude, (len(t), 2, 4)).copy()
        return Trajectory(t=t, position=position, velocity=velocity, attitude=attitude, omega=omega)


def _propagated(integrator: Any, t: Array, states: list[Array]) -> tuple[int, int, float]:
    """Runs one mode until an event or the last sample, and appends the states at the samples until
    then; number of the event, steps, seconds.
    """
    later = t[len(states) :]
    if len(later) == 1:
        started = perf_counter()
        outcome = integrator.propagate_until(t[-1])
        seconds = perf_counter() - started
    else:
        grid = np.concatenate([[integrator.time], later])
        started = perf_counter()
        outcome = integrator.propagate_grid(grid)
        seconds = perf_counter() - started
        states += list(outcome[-1][1:])
    # Samples within the step that an event has cut.
    while len(states) < len(t) and t[len(states)] <= integrator.time:
        sample = integrator.update_d_output(t[len(states)])
        states.append(sample.copy())
    # heyoka reports event number n that stops it as -n - 1.
    event = -int(outcome[0]) - 1
    steps = int(outcome[3])
    return event, steps, seconds


def _held(column: Array, samples: int) -> Array:
    """A quantity (2, M) whose last value is repeated so that it stands for `samples` samples."""
    repeated = np.repeat(column[:, -1:], samples, axis=1)
    return np.concatenate([column[:, :-1], repeated], axis=1)


def oblique(scene: Scene) -> Oblique | None:
    """The pair of the scene, or None where these equations are not those of the scene.

    They need two spheres along x in the plane z = 0 and a contact that ends where the overlap does;
    for the rest the pair is supported where the reference's series support it.
    """
    laws = scene.all(Contact)
    if not laws or laws[0].cutoff != "zero_overlap" or len(scene.bodies) != 2:
        return None
    reference = discovery.engine("reference")
    motion = Motion(scene, np.array([0.0, 1.0]))
    if reference.unsupported_motion(motion, reference.method("oblique-contact")):
        return None
    branch = np.diff(scene.bodies.position, axis=0)[0]
    velocity = scene.bodies.velocity
    omega = scene.bodies.omega
    out_of_plane = (*branch[1:], *velocity[:, 2], *omega[:, :2].ravel())
    if branch[0] > 0 and not any(out_of_plane):
        return Oblique(scene, laws[0])
    return None
