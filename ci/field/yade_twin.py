"""The twin of YADE's exactAsphericalRot of reports/findings.md: prints its rows, steps and errors
[rad] with both attitudes.

Free body J = (1, 2, 3), omega_body = (0.9, 1.1, 1.3), T = 20/|omega|. The momentum of the middle of
a step is taken into the body by the attitude at its beginning, as YADE does, or by that of the half
step, which makes the method of second order.
"""

import numpy as np

from refdem.core.problem import Motion, Request
from refdem.engines.reference import ENGINE
from refdem.mechanics.quaternion import matrix, product
from refdem.scene import Body, Scene

J = np.array([1.0, 2.0, 3.0])
OMEGA = np.array([0.9, 1.1, 1.3])
T = 20.0 / float(np.linalg.norm(OMEGA))
STEPS = (1000, 2000, 4000)
START = np.array([1.0, 0.0, 0.0, 0.0])


def rate(q: np.ndarray, omega_body: np.ndarray) -> np.ndarray:
    """dq/dt = q omega/2, omega in body axes."""
    return 0.5 * product(q, np.concatenate([[0.0], omega_body]))


def turned(steps: int, *, by_half: bool) -> np.ndarray:
    """Attitude after T; `by_half`: the half step's attitude takes the momentum into the body."""
    q = START
    h = T / steps
    momentum = J * OMEGA
    for _ in range(steps):
        q_half = q + 0.5 * h * rate(q, matrix(q).T @ momentum / J)
        of_half = q_half / np.linalg.norm(q_half)
        omega_half = matrix(of_half if by_half else q).T @ momentum / J
        q = q + h * rate(q_half, omega_half)
        q = q / np.linalg.norm(q)
    return q


def angle(q: np.ndarray, other: np.ndarray) -> float:
    """The angle [rad] between two attitudes."""
    between = product(other * [1.0, -1.0, -1.0, -1.0], q)
    return 2.0 * float(np.arctan2(np.linalg.norm(between[1:]), abs(between[0])))


def rows() -> list[tuple[str, str, str]]:
    """Steps, error with the attitude at the beginning and with that of the half step, as text."""
    scene = Scene.of([Body(mass=1.0, inertia=tuple(J), omega=tuple(OMEGA))])
    exact, _ = ENGINE.run(
        Request(problem=Motion(scene, np.array([0.0, T])), method="exact-free-body")
    )
    right = exact.attitude[1, 0]
    found = []
    for steps in STEPS:
        first, second = (angle(turned(steps, by_half=half), right) for half in (False, True))
        found.append((str(steps), f"{first:.3f}", f"{second:.1e}".replace("e-0", "e-")))
    return found


if __name__ == "__main__":
    print(
        "\n".join(
            f"| {steps} | {first} | agrees with YADE to 15 digits | {second} |"
            for steps, first, second in rows()
        )
    )
