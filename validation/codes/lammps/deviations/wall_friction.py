"""LAMMPS 22 Jul 2025: the friction of `fix wall/gran hooke/history` depends on the unit of length.

python wall_friction.py LMP

A sphere of 1 kg meets a wall at 76 degrees from its normal, with mu = 1/2, and slides all along:
its velocity along the wall falls from sin to sin - 2 mu cos, in any unit of length L. What has a
length in it (radius, velocity) is written in L; kg, s and N/m = kg/s^2 are not.

The release of 2025 says vx/L = 0.9703 at L = 1e-4 m (hardly any friction), 0.8825 at 1 m and 0.7284
at 1e4 m. That of 29 Sep 2021, and `granular ... tangential linear_history` in both, say 0.7284 at
each L. In the words of `granular`, `tangential linear_history_classic` (2025) is as wrong as
hooke/history: the tangential model is the cause, and neither the wall nor the normal force.

The last column is a loop with two errors: k_t [N/m] is multiplied by the contact radius sqrt(R d)
[m], and a spring at the limit is kept as mu F_n/k_t without it. It has the numbers of 2025 at each
L to all digits that LAMMPS prints; with the right spring it has 0.7284.

Under Hertz's law the contact radius belongs to the spring, F_t = k_t sqrt(R d) s with k_t [N/m^2],
so that of the two errors the second is left: `hertz/history` of 2025 says 0.9304, 0.9280 and 0.8904
at these L, as the loop does, and `tangential mindlin` and the release of 2021 say 0.8904 at each.
"""

import math
import subprocess
import sys
import tempfile
from pathlib import Path

ANGLE = math.radians(76)
K_N, K_T, MU = 1e4, 8e3, 0.5  # [N/m, N/m, 1]; [N/(m L), N/(m L), 1] under Hertz's law
STEP, STEPS = 1e-5, 5000  # [s, 1]
LINEAR = f"granular hooke {K_N} 0 damping velocity tangential {{}} {K_T} 0 {MU}"
HERTZ = f"granular hertz {{{{k_n!r}}}} 0 damping velocity tangential {{}} {{{{k_t!r}}}} 0 {MU}"
WALLS = {
    "hooke/history": f"hooke/history {K_N} {K_T} 1e-300 0 {MU} 0",
    "granular, linear_history_classic": LINEAR.format("linear_history_classic"),
    "granular, linear_history": LINEAR.format("linear_history"),
    "hertz/history": "hertz/history {k_n!r} {k_t!r} 1e-300 0 " + f"{MU} 0",
    "granular, mindlin_classic": HERTZ.format("mindlin_classic"),
    "granular, mindlin": HERTZ.format("mindlin"),
}
SCRIPT = """
units si
atom_style sphere
atom_modify map array sort 0 0
comm_modify vel yes
boundary f f f
neighbor {box} nsq
region box block -{box} {box} -{box} {box} -{box} {box}
create_box 1 box
create_atoms 1 single 0 0 {radius}
set atom 1 diameter {diameter}
set atom 1 mass 1
velocity all set {along} 0 {towards}
pair_style zero 1
pair_coeff * *
fix wall all wall/gran {wall} zplane 0 NULL
fix move all nve/sphere
timestep {step}
run {steps}
write_dump all custom dump.txt vx modify format float %.9g
"""


def speed_along(lmp, wall, unit):
    """The velocity along the wall [L/s] after the impact at 1 L/s, L = `unit` [m]; or None."""
    words = SCRIPT.format(
        wall=wall.format(k_n=K_N / unit, k_t=K_T / unit),
        step=STEP,
        steps=STEPS,
        radius=0.5 * unit,
        diameter=unit,
        box=20 * max(1.0, unit),
        along=unit * math.sin(ANGLE),
        towards=-unit * math.cos(ANGLE),
    )
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "in.txt").write_text(words)
        subprocess.run([lmp, "-in", "in.txt", "-log", "none"], cwd=folder, capture_output=True)
        dump = Path(folder) / "dump.txt"
        if not dump.exists():
            return None
        return float(dump.read_text().split()[-1]) / unit


def loop(unit, is_hertz, is_wrong):
    """The same velocity [L/s] by velocity Verlet, with the right or the wrong spring.

    F_n = k_n d and F_t = k_t s, with sqrt(R d) in both under Hertz's law; |F_t| <= mu F_n.
    """
    radius = 0.5 * unit
    inertia = 0.4 * radius**2
    height = radius
    along, towards = unit * math.sin(ANGLE), -unit * math.cos(ANGLE)
    spin = spring = tangential = normal = 0.0
    for _ in range(STEPS):
        for half in (0, 1):
            along += tangential * STEP / 2
            towards += normal * STEP / 2
            spin -= tangential * radius / inertia * STEP / 2
            if half:
                break
            height += towards * STEP
            overlap = max(radius - height, 0.0)
            contact_radius = math.sqrt(radius * overlap)
            if is_hertz:
                normal = K_N / unit * contact_radius * overlap
                stiffness = K_T / unit
            else:
                normal = K_N * overlap
                stiffness = K_T
            used = stiffness * (contact_radius if is_hertz or is_wrong else 1.0)
            spring += (along - spin * radius) * STEP
            tangential = -used * spring
            if abs(tangential) > MU * normal:
                tangential = math.copysign(MU * normal, tangential)
                spring = -tangential / (stiffness if is_wrong else used)
    return along / unit


def main(lmp):
    """Prints a row a wall and unit of length."""
    print(f"sliding: {math.sin(ANGLE) - 2 * MU * math.cos(ANGLE):.6f}; LAMMPS, loop:")
    for name, wall in WALLS.items():
        is_hertz = "hertz" in wall
        is_wrong = not name.endswith(("linear_history", "mindlin"))
        for unit in (1e-4, 1e-2, 1.0, 1e2, 1e4):
            found = speed_along(lmp, wall, unit)
            said = "not a word of this release" if found is None else f"{found:.6f}"
            print(f"{name:32} L = {unit:6g} m: {said}, {loop(unit, is_hertz, is_wrong):.6f}")


main(*sys.argv[1:])
