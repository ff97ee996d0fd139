"""Two spheres that touch, hold or slip, and part in a plane: equations between events, those of the
mode that a contact is in.

State: overlap d, its rate g, transverse velocity q of the second from the first, angle of the line
of centres, spins, tangential spring s.
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
BRANCH = {"R": 0.0, "R-d": 1.0, "R-d/2": 0.5}
HOLDS, SLIPS, FREE, APART = range(4)
INSIDE = 1 - 1e-14
"""A spring that begins to hold is shorter than its longest by this, so that no event is seen where
it begins.
"""


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
    def share(self) -> float:
        """The spring at its longest over the normal force [m/N]."""
        if self.law.friction:
            return self.law.friction / self.law.tangential_stiffness
        return 0.0

    def start(self) -> tuple[list[float], int, float]:
        """The initial state, the mode of the contact and the side of the slip."""
        bodies = self.scene.bodies
        relative = bodies.velocity[1] - bodies.velocity[0]
        p, r = bodies.omega[:, 2]
        overlap_rate = -relative[0]
        slip = float(bodies.radius[0] * p + bodies.radius[1] * r - relative[1])
        state = [0.0, overlap_rate, relative[1], 0.0, p, r, 0.0]
        if slip > 0:
            side = 1.0
        else:
            side = -1.0
        if not self.law.friction:
            return state, FREE, side
        # It holds while k_t |slip| grows no faster than mu k g; with a dashpot the normal force
        # is above 0 at once.
        most = self.share * self.law.stiffness * overlap_rate
        is_held = bool(self.law.damping) or abs(slip) <= most
        if is_held:
            mode = HOLDS
        else:
            mode = SLIPS
        return state, mode, side

    def integrators(self, tolerance: float | None) -> list[Any]:
        """heyoka's integrators: the spring holds; it slips to the side of par[0]; no friction.

        Each stops at what ends it.
        """
        import heyoka

        bodies = self.scene.bodies
        law = self.law
        down = {"direction": heyoka.event_direction.negative}
        r1, r2 = bodies.radius.tolist()
        j1, j2 = bodies.inertia[:, 0].tolist()
        d, g, q, _, spin1, spin2, s = names = heyoka.make_vars("d", "g", "q", "a", "u", "v", "s")
        force = law.stiffness * d + law.damping * g
        side = heyoka.par[0]
        ease = float(np.sum(1 / bodies.mass))
        turn = q / (r1 + r2 - d)
        arm1 = r1 - BRANCH[law.branch] * d
        arm2 = r2 - BRANCH[law.branch] * d
        slip = arm1 * spin1 + arm2 * spin2 - q
        bend = -q * turn - ease * force
        ends = side * slip - self.share * (law.stiffness * g + law.damping * bend)
        slip_ends = [ends]
        if law.damping:
            slip_ends.append(force)
        # What ends each mode where it falls to 0, after the overlap itself.
        watched = {
            HOLDS: [self.share * force - s, self.share * force + s],
            SLIPS: slip_ends,
            FREE: [],
        }
        # The tangential force in each mode.
        acting = {
            HOLDS: -law.tangential_stiffness * s,
            SLIPS: -side * law.friction * force,
            FREE: 0.0,
        }
        integrators = []
        modes: tuple[int, ...] = (FREE,)
        if law.friction:
            modes = (HOLDS, SLIPS, FREE)
        for mode in modes:
            across = acting[mode]
            # d' = g, and so on in the order of the names; the spring stretches while it holds.
            if mode == HOLDS:
                stretching = slip
            else:
                stretching = 0.0
            rates = [
                g,
                bend,
                g * turn - ease * across,
                turn,
                arm1 * across / j1,
                arm2 * across / j2,
                stretching,
            ]
            events = [heyoka.t_event(what, **down) for what in (d, *watched[mode])]
            expressions = []
            for rate in rates:
                if isinstance(rate, float):
                    expressions.append(heyoka.expression(rate))
                else:
                    expressions.append(rate)
            system = list(zip(names, expressions, strict=True))
            # Only a slip has a side.
            if mode == SLIPS:
                pars = [1.0]
            else:
                pars = []
            integrator = heyoka.taylor_adaptive(
                system, [0.0] * 7, pars=pars, t_events=events, tol=tolerance
            )
            integrators.append(integrator)
        return integrators

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
            if self.law.friction:
                number = mode
            else:
                number = 0
            integrator = integrators[number]
            integrator.time = now
            integrator.state[:] = state
            if mode == SLIPS:
                integrator.pars[0] = side
            grid = np.concatenate([[now], t[len(states) :]])
            if len(grid) == 2:
                started = perf_counter()
                outcome = integrator.propagate_until(t[-1])
                seconds += perf_counter() - started
            else:
                started = perf_counter()
                outcome = integrator.propagate_grid(grid)
                seconds += perf_counter() - started
                states += list(outcome[-1][1:])
            # Samples within the step that an event has cut.
            while len(states) < len(t) and t[len(states)] <= integrator.time:
                sample = integrator.update_d_output(t[len(states)])
                states.append(sample.copy())
            steps += int(outcome[3])
            if len(states) == len(t):
                break
            now = integrator.time
            state = integrator.state.copy()
            mode, side = self._after(mode, side, -int(outcome[0]) - 1, state)
            if mode == APART:
                states.append(np.array([*state, now]))
                break
        return states, steps, seconds

    def _after(self, mode: int, side: float, event: int, state: Array) -> tuple[int, float]:
        """Mode and side after an event; the spring where it begins to hold."""
        if event == 0:
            return APART, side
        if mode == HOLDS:
            if event == 1:
                new_side = 1.0
            else:
                new_side = -1.0
            return SLIPS, new_side
        if event != 1:
            return FREE, side
        overlap = state[0]
        rate = state[1]
        force = self.law.stiffness * overlap + self.law.damping * rate
        state[6] = side * INSIDE * self.share * force
        return HOLDS, side

    def trajectory(self, t: Array, states: list[Array]) -> Trajectory:
        """The motion of both, straight on once they have parted."""
        bodies = self.scene.bodies
        parted = len(states[-1]) == 8
        touch = np.array([row[:7] for row in states])
        d, _, q, angle, p, r, _ = touch.T
        reach = bodies.radius.sum() - d
        g = touch[:, 1]
        c = np.cos(angle)
        s = np.sin(angle)
        place = reach * np.array([c, s])
        speed = np.array([-g * c - q * s, -g * s + q * c])
        spins = np.array([p, r])
        if parted:
            # Straight on with the last velocities, from the time at which they part.
            since = t[len(states) - 1 :] - states[-1][7]
            flown = place[:, -1:] + speed[:, -1:] * since
            place = np.concatenate([place[:, :-1], flown], axis=1)
            speed = _held(speed, len(since))
            spins = _held(spins, len(since))
        # Of the way from the first to the second, m1/(m1 + m2) is ahead of the centre of mass.
        total = bodies.mass.sum()
        share = np.array([-bodies.mass[1], bodies.mass[0]])[:, None] / total
        centre = bodies.mass @ bodies.position / total
        drift = bodies.mass @ bodies.velocity / total
        position = np.zeros((len(t), 2, 3))
        velocity = np.zeros((len(t), 2, 3))
        omega = np.zeros((len(t), 2, 3))
        position[:, :, :2] = place.T[:, None] * share
        velocity[:, :, :2] = speed.T[:, None] * share
        omega[:, :, 2] = spins.T
        position += centre + drift * (t - t[0])[:, None, None]
        still = np.broadcast_to(bodies.attitude, (len(t), 2, 4)).copy()
        return Trajectory(
            t=t, position=position, velocity=velocity + drift, attitude=still, omega=omega
        )


def _held(column: Array, samples: int) -> Array:
    """A quantity (2, M) whose last value stays for so many samples, in place of that one."""
    later = np.repeat(column[:, -1:], samples, axis=1)
    return np.concatenate([column[:, :-1], later], axis=1)


def oblique(scene: Scene) -> Oblique | None:
    """The pair, if it parts where the overlap ends, and the reference's series say it too."""
    laws = scene.all(Contact)
    reference = discovery.engine("reference")
    if not laws or laws[0].cutoff != "zero_overlap" or len(scene.bodies) != 2:
        return None
    if reference.unsupported_motion(
        Motion(scene, np.array([0.0, 1.0])), reference.method("oblique-contact")
    ):
        return None
    line = np.diff(scene.bodies.position, axis=0)[0]
    velocity = scene.bodies.velocity
    spins = scene.bodies.omega
    aside = (*line[1:], *velocity[:, 2], *spins[:, :2].ravel())
    if line[0] > 0 and not any(aside):
        return Oblique(scene, laws[0])
    return None
