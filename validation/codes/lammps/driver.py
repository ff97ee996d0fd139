"""Scenes in LAMMPS: driver.py LMP answers requests until standard input ends, driver.py LMP
request.json trajectory.csv one, and driver.py LMP version names the version.

One LAMMPS runs all scenes, each from a clear start. It keeps no attitude of spheres: the trajectory
has the one at the start.
"""

import sys
from functools import partial
from pathlib import Path

sys.path[:0] = [str(Path(__file__).resolve().parents[1]), str(Path(__file__).resolve().parent)]
import border  # noqa: E402
import piped  # noqa: E402
import served  # noqa: E402
from border import cannot  # noqa: E402
from elements import contact, joined, pushes  # noqa: E402

BOX = 1e6
"""Half the side of the box [m]; nothing must leave it, and no pair is ever dropped from the
neighbour list.
"""
START = (
    f"units si\natom_modify map array\nboundary f f f\nneighbor {BOX!r} nsq\nneigh_modify delay 0"
    " every 1 check yes"
)
KINDS = ("contact", "plane", "uniform_gravity", "spring", "central_field")
DUMP = "dump.lammps"
METHODS = {"gran": ("gran", "rigid/nve"), "granular": ("granular", "rigid")}
"""Pair style, and fix for bodies that are no spheres: LAMMPS has two codes for either."""
ATOM = "id x y z vx vy vz omegax omegay omegaz"
BODY = "mol x y z vx vy vz omegax omegay omegaz quatw quati quatj quatk"


def data(kind, atoms, speeds):
    """Writes the data file that read_data takes; spheres have masses of their own."""
    sides = "".join(f"{-BOX!r} {BOX!r} {a}lo {a}hi\n" for a in "xyz")
    parts = (
        f"Atoms # {kind}\n\n"
        + "\n".join(atoms)
        + ("\n\nVelocities\n\n" + "\n".join(speeds) if speeds else "")
    )
    if speeds:
        masses = ""
    else:
        masses = "Masses\n\n1 1.0\n\n"
    Path("data.lammps").write_text(
        f"refdem\n\n{len(atoms)} atoms\n1 atom types\n{sides}\n{masses}{parts}\n"
    )


def spheres(request, pair):
    """Input for points and solid spheres; a sphere of diameter 0 has its density for mass."""
    border.refuse_shapes(request)
    bodies = request["scene"]["bodies"]
    atoms = [
        f"{n} 1 {2 * b['shape'].get('radius', 0.0)!r} 1.0 {joined(b['position'])}"
        for n, b in enumerate(bodies, 1)
    ]
    data(
        "sphere",
        atoms,
        [f"{n} {joined((*b['velocity'], *b['omega']))}" for n, b in enumerate(bodies, 1)],
    )
    yield f"atom_style sphere\n{START}\nnewton off\ncomm_modify vel yes\nread_data data.lammps"
    yield from (f"set atom {n} mass {b['mass']!r}" for n, b in enumerate(bodies, 1))
    yield from contact(request, pair)
    yield from pushes(request)
    yield (
        "fix move all nve/sphere"
        if all("radius" in b["shape"] for b in bodies)
        else "fix move all nve"
    )


def rigid(request, fix):
    """Input for bodies of any inertia: two atoms each, whose mass and moments the body's own
    replace.
    """
    cannot(request["scene"]["elements"], "elements beside bodies that are no spheres")
    bodies = request["scene"]["bodies"]
    rows = []
    cannot(
        any(body["shape"]["kind"] != "point" or not all(body["inertia"]) for body in bodies),
        "bodies without a moment of inertia, or that touch",
    )
    for n, body in enumerate(bodies, 1):
        j = border.tensor(body)
        spin = [sum(a * w for a, w in zip(row, body["omega"], strict=True)) for row in j]
        moments = (j[0][0], j[1][1], j[2][2], j[0][1], j[0][2], j[1][2])
        rows.append(
            f"{n} {body['mass']!r}"
            f" {joined((*body['position'], *moments, *body['velocity'], *spin))} 0 0 0"
        )
    Path("bodies.lammps").write_text(f"{len(rows)}\n" + "\n".join(rows) + "\n")
    ends = [
        (n, [x + side, y, z])
        for n, (x, y, z) in enumerate((b["position"] for b in bodies), 1)
        for side in (-0.25, 0.25)
    ]
    data("molecular", [f"{k} {n} 1 {joined(place)}" for k, (n, place) in enumerate(ends, 1)], [])
    yield (
        f"atom_style molecular\n{START}\nread_data data.lammps\npair_style zero 1.0\npair_coeff * *"
    )
    yield (
        f"fix move all {fix}/small molecule infile bodies.lammps\ncompute body all rigid/local move"
        f" {BODY}"
    )


def version(program):
    """The name of the version, from the first line of the help."""
    title = next(line for line in piped.printed(program, "-h").splitlines() if line.strip())
    return f"LAMMPS {title.partition(' - ')[2]}"


def solve(lammps, scene):
    """Runs a scene and keeps its rows."""
    request, bodies, times = scene.request, scene.bodies, scene.times
    cannot(times[1] < times[0], "negative steps")
    (pair, fix) = METHODS[scene.method]
    turning = any(body["shape"]["kind"] == "point" and any(body["inertia"]) for body in bodies)
    if turning:
        columns = " ".join(f"c_body[{k}]" for k in range(1, 15))
        commands = [*rigid(request, fix), f"dump d all local {scene.stride} {DUMP} {columns}"]
    else:
        commands = [*spheres(request, pair), f"dump d all custom {scene.stride} {DUMP} {ATOM}"]
    commands += [
        "dump_modify d format float %.17g" + ("" if turning else " sort id"),
        "thermo_modify lost error",
        f"timestep {scene.step!r}",
        f"run {scene.stride * (len(times) - 1)}",
        "undump d",
    ]
    lammps.run("\n".join(commands))
    scene.rows.extend(rows(bodies, times, turning))


def rows(bodies, times, turning):
    """Rows of the trajectory from the dump.

    LAMMPS may order a body's principal axes its own way, which the start tells.
    """
    table = piped.states(DUMP)
    if turning:
        first = [
            border.product(border.conjugate(state[10:]), body["attitude"])
            for state, body in zip(table[0], bodies, strict=True)
        ]
    else:
        first = []
    for t, states in zip(times, table, strict=True):
        for n, (body, state) in enumerate(zip(bodies, states, strict=True)):
            if turning:
                attitude = border.product(state[10:], first[n])
            else:
                attitude = body["attitude"]
            yield t, n, state[1:4], state[4:7], attitude, state[7:10]


if __name__ == "__main__":
    program = sys.argv.pop(1)
    if sys.argv[1:] == ["version"]:
        # Standard output is for answers alone.
        print(version(program), file=served.ANSWERS)
    else:
        served.run(partial(solve, piped.Piped(program)), *KINDS)
