"""LAMMPS: pair gran/hooke (smooth) and gran/hooke/history (rough), on one core."""

import os
import re
import shutil
import subprocess
import tempfile
from pathlib import Path

from refdem.bench.crowds._crowd import Crowd, Gas
from refdem.errors import EngineError

SKIN = 0.5
"""Skin of neighbour lists in diameters; 0.3 to 0.7 were measured to cost the same within a tenth.
"""
INPUT = """
units si
atom_style sphere
boundary p p p
newton off
comm_modify vel yes
read_data data.lammps
set group all mass {mass!r}
neighbor {skin!r} bin
neigh_modify delay 0 every 1 check yes
pair_style {style} {stiffness!r} {tangential!r} {per_mass!r} 0 {friction!r} 0
pair_coeff * *
fix move all nve/sphere
timestep {step!r}
thermo 1000000000
run {steps}
"""


class Lammps(Crowd):
    """LAMMPS; the time is that of its own loop, as it reports it."""

    name = "LAMMPS gran/hooke"
    note = "gran/hooke/history with friction; keeps no attitudes"

    def missing(self) -> str | None:
        """None if there is a program `lmp` on the path, else what to install."""
        if shutil.which("lmp"):
            return None
        return "install LAMMPS (Debian: lammps)"

    def unsupported(self, gas: Gas) -> str | None:
        """None for a gas in a periodic box, else why it cannot be moved."""
        if gas.periodic:
            return None
        return "LAMMPS is benchmarked in a periodic box only"

    def seconds(self, gas: Gas, steps: int) -> float:
        """The seconds of its loop; raises EngineError with the end of its output if it fails."""
        law = gas.law
        if law.friction:
            style = "gran/hooke/history"
        else:
            style = "gran/hooke"
        words = INPUT.format(
            mass=gas.mass,
            skin=SKIN * gas.diameter,
            style=style,
            stiffness=law.stiffness,
            tangential=law.tangential_stiffness,
            per_mass=2 * law.damping / gas.mass,
            friction=law.friction,
            step=gas.step,
            steps=steps,
        )
        with tempfile.TemporaryDirectory(prefix="refdem-bench-") as name:
            folder = Path(name)
            (folder / "data.lammps").write_text(_data(gas))
            (folder / "in.lammps").write_text(words)
            environment = os.environ | {"OMP_NUM_THREADS": "1", "TMPDIR": name}
            command = ["lmp", "-in", "in.lammps", "-log", "none"]
            done = subprocess.run(
                command, cwd=folder, env=environment, capture_output=True, text=True, check=False
            )
        loop_time = re.search(r"Loop time of (\S+) on 1 procs", done.stdout)
        if done.returncode or loop_time is None:
            raise EngineError(f"lammps: {(done.stdout + done.stderr).strip()[-300:]}")
        return float(loop_time[1])


def _data(gas: Gas) -> str:
    """The data file of LAMMPS: the box, the spheres, and their velocities."""
    sides = "\n".join(f"0 {gas.size!r} {axis}lo {axis}hi" for axis in "xyz")
    atoms = []
    for number, (x, y, z) in enumerate(gas.position.tolist(), 1):
        atoms.append(f"{number} 1 {gas.diameter!r} 1.0 {x!r} {y!r} {z!r}")
    speeds = []
    for number, (x, y, z) in enumerate(gas.velocity.tolist(), 1):
        speeds.append(f"{number} {x!r} {y!r} {z!r} 0 0 0")
    parts = [
        "gas",
        f"{len(gas.position)} atoms\n1 atom types\n{sides}",
        "Atoms # sphere",
        "\n".join(atoms),
        "Velocities",
        "\n".join(speeds),
    ]
    return "\n\n".join(parts) + "\n"


CROWD = Lammps()
