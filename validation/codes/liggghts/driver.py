"""Scenes in LIGGGHTS: driver.py LIGGGHTS answers requests until standard input ends, driver.py
LIGGGHTS request.json trajectory.csv one, and driver.py LIGGGHTS version names the version.

One LIGGGHTS runs all scenes, each from a clear start. It keeps no attitude of spheres: the
trajectory has the one at the start.
"""

import math
import sys
from functools import partial
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import border
import piped
import served
import triangle
from border import cannot
from triangle import is_along_an_axis

BOX = 1e6
"""Half the side of the box [m]; nothing must leave it."""
START = (
    "units si\natom_style granular\natom_modify map array sort 0 0\nboundary f f f\nnewton"
    " off\ncommunicate single vel yes\n"
)
START += f"neighbor {BOX!r} bin\nneigh_modify delay 0 every 1 check yes\nread_data data.liggghts"
NUMBERS = {
    "kn": "stiffness",
    "kt": "tangential_stiffness",
    "gamman_abs": "damping",
    "coefficientFriction": "friction",
}
DUMP = "dump.liggghts"
ATOM = "id x y z vx vy vz omegax omegay omegaz"


def joined(numbers):
    """Numbers with a blank between them, every digit of them."""
    return " ".join(map(repr, numbers))


def data(bodies):
    """The data file that read_data takes; masses are set later."""
    sides = "".join(f"{-BOX!r} {BOX!r} {a}lo {a}hi\n" for a in "xyz")
    atoms = "\n".join(
        f"{n} 1 {2 * b['shape'].get('radius', 0.0)!r} 1.0 {joined(b['position'])}"
        for n, b in enumerate(bodies, 1)
    )
    speeds = "\n".join(
        f"{n} {joined((*b['velocity'], *b['omega']))}" for n, b in enumerate(bodies, 1)
    )
    return (
        f"refdem\n\n{len(bodies)} atoms\n1 atom"
        f" types\n{sides}\nAtoms\n\n{atoms}\n\nVelocities\n\n{speeds}\n"
    )


def contact(request):
    """Pair style and walls: `model hooke/stiffness` or `model hertz`, no tangential damping."""
    planes = border.of_kind(request, "plane")
    law = border.contact_law(request, "linear", "hertz")
    if law is None:
        cannot(planes, "planes without a contact law")
        yield "pair_style none"
        return
    rubs = law["friction"] > 0
    pulls = law["damping"] > 0 and law["cutoff"] == "zero_overlap"
    cannot(
        rubs and law["tangential_stiffness"] == 0,
        "friction of full size at any slip: it goes through a tangential spring",
    )
    cannot(rubs and law["branch"] != "R-d/2", "a branch other than R - d/2")
    cannot(
        rubs and pulls,
        "no friction while the normal force pulls: the limit is friction times its size",
    )
    switches = f"tangential_damping off limitForce {'off' if pulls else 'on'}"
    if law["law"] == "hertz":
        words = "model hertz tangential history"
        yield from material(request, law, planes)
    else:
        words = "model hooke/stiffness tangential history"
        switches = f"absolute_damping on {switches}"
        yield from numbers(law)
    yield f"pair_style gran {words} {switches}\npair_coeff * *"
    yield from walls(request, words, switches)


def numbers(law):
    """The numbers of `model hooke/stiffness`."""
    for name, key in (NUMBERS | {"gammat_abs": None}).items():
        yield (
            f"fix {name} all property/global {name} peratomtypepair 1 {law[key] if key else 0.0!r}"
        )


def material(request, law, planes):
    """The material of `model hertz` that has the stiffnesses K and K_t of Hertz's law.

    K = 4/3 Y* sqrt(R*) and K_t = 8 G* sqrt(R*), with 1/Y* = 2 (1 - nu^2)/Y and 1/G* = 4 (2 - nu)
    (1 + nu)/Y, so that K_t/K = 3 (1 - nu)/(2 - nu).
    """
    radii = {body["shape"].get("radius", 0.0) for body in request["scene"]["bodies"]}
    several = len(request["scene"]["bodies"]) > 1
    cannot(len(radii) > 1 or (planes and several), "one material for several effective radii")
    (radius,) = radii
    effective = radius if planes else radius / 2
    nu = 0.0
    if law["friction"] > 0:
        ratio = law["tangential_stiffness"] / law["stiffness"]
        # nu = (3 - 2 r)/(3 - r) of the ratio r = K_t/K.
        nu = (3 - 2 * ratio) / (3 - ratio)
        cannot(not 0 <= nu <= 0.5, "a Poisson's ratio outside 0 to 1/2")
    # Y = 2 (1 - nu^2) Y*, Y* = 3 K/(4 sqrt(R*)).
    young = 1.5 * (1 - nu**2) * law["stiffness"] / math.sqrt(effective)
    # LIGGGHTS refuses moduli below 5e6 and above 1e9 Pa unless it is told to take them.
    yield "soft_particles yes\nhard_particles yes"
    for name, value in (("youngsModulus", young), ("poissonsRatio", nu)):
        yield f"fix {name} all property/global {name} peratomtype {value!r}"
    for name, value in (("coefficientRestitution", 1.0), ("coefficientFriction", law["friction"])):
        yield f"fix {name} all property/global {name} peratomtypepair 1 {value!r}"


def walls(request, words, switches):
    """The walls: along an axis a primitive each, of other planes one of triangles, a mesh each."""
    meshes = []
    for n, plane in enumerate(border.of_kind(request, "plane")):
        if is_along_an_axis(plane):
            k = [abs(a) for a in plane["normal"]].index(1)
            place = f"primitive type 1 {'xyz'[k]}plane {plane['point'][k]!r}"
            yield f"fix wall{n} all wall/gran {words} {place} {switches}"
        else:
            corners = triangle.corners(plane, triangle.reach(request, plane))
            Path(f"mesh{n}.stl").write_text(stl(corners, plane["normal"]))
            yield f"fix mesh{n} all mesh/surface file mesh{n}.stl type 1"
            meshes.append(f"mesh{n}")
    if meshes:  # LIGGGHTS takes all meshes in one wall
        place = f"mesh n_meshes {len(meshes)} meshes {' '.join(meshes)}"
        yield f"fix meshes all wall/gran {words} {place} {switches}"


def unit_of_length(request):
    """The unit of length [m] for LIGGGHTS: 1, or for meshes a power of two near their size.

    LIGGGHTS refuses meshes of 1e-5 m ("dimensions too small - use different unit system") and
    aborts at some of up to 1e-3 m; a power of two rounds no number.
    """
    planes = border.of_kind(request, "plane")
    sizes = [triangle.reach(request, plane) for plane in planes]
    if all(map(is_along_an_axis, planes)):
        return 1.0
    return 2.0 ** math.floor(math.log2(max(sizes)))


def in_unit(request, unit):
    """The request with lengths in this unit [m]; those of mass and time, and so N/m, stay.

    Hertz's stiffnesses [N/m^(3/2) = kg m^(-1/2) s^-2] become sqrt(unit) as large.
    """
    lengths = {"position", "velocity", "radius", "point", "g", "anchor_b", "length"}

    def scaled(thing, is_length=False):
        if isinstance(thing, dict):
            return {key: scaled(value, key in lengths) for key, value in thing.items()}
        if isinstance(thing, list):
            return [scaled(value, is_length) for value in thing]
        return thing / unit if is_length else thing

    scene = scaled(request["scene"])
    for element in scene["elements"]:
        if element["kind"] == "contact" and element["law"] == "hertz":
            for name in ("stiffness", "tangential_stiffness"):
                element[name] *= math.sqrt(unit)
    return request | {"scene": scene}


def stl(corners, normal):
    """A triangle in the words of an STL file."""
    places = [f"vertex {joined(corner)}" for corner in corners]
    lines = ["solid wall", f"facet normal {joined(normal)}", "outer loop", *places]
    return "\n".join([*lines, "endloop", "endfacet", "endsolid wall", ""])


def pushes(request):
    """Gravity, and springs from a centre to the world."""
    for n, field in enumerate(border.of_kind(request, "uniform_gravity")):
        yield (
            f"fix gravity{n} all gravity {sum(g * g for g in field['g']) ** 0.5!r} vector"
            f" {joined(field['g'])}"
        )
    for n, spring in enumerate(border.of_kind(request, "spring")):
        linear = spring["b"] == -1 and spring["exponent"] == 1 and not any(spring["anchor_a"])
        cannot(not linear, "springs but linear ones from a centre to the world")
        tether = f"{spring['stiffness']!r} {joined(spring['anchor_b'])} {spring['length']!r}"
        yield f"group held{n} id {spring['a'] + 1}\nfix spring{n} held{n} spring tether {tether}"


def solve(liggghts, scene):
    """Runs a scene and keeps its rows."""
    cannot(scene.times[1] < scene.times[0], "negative steps")
    border.refuse_shapes(scene.request)
    unit = unit_of_length(scene.request)
    request = in_unit(scene.request, unit)
    bodies = request["scene"]["bodies"]
    Path("data.liggghts").write_text(data(bodies))
    are_spheres = all("radius" in body["shape"] for body in bodies)
    commands = [
        START,
        *(f"set atom {n} mass {b['mass']!r}" for n, b in enumerate(bodies, 1)),
        *contact(request),
        *pushes(request),
        f"fix move all nve{'/sphere' if are_spheres else ''}",
        f"dump d all custom {scene.stride} {DUMP} {ATOM}",
        f'dump_modify d format "%d{" %.17g" * 9}"',
        "thermo_modify lost error",
        f"timestep {scene.step!r}",
        f"run {scene.stride * (len(scene.times) - 1)}",
        "undump d",
    ]
    liggghts.run("\n".join(commands))
    for t, states in zip(scene.times, piped.states(DUMP), strict=True):
        for n, (body, state) in enumerate(zip(scene.bodies, states, strict=True)):
            place = [unit * x for x in state[1:4]]
            velocity = [unit * v for v in state[4:7]]
            scene.rows.append((t, n, place, velocity, body["attitude"], state[7:10]))


def version(program):
    """The version that LIGGGHTS says as it starts: "LIGGGHTS (Version LIGGGHTS-PUBLIC 3.8.0, ...)".

    `-h` would say it too, but LIGGGHTS 3.8.0 of Debian ends that with status 1.
    """
    first = piped.printed(program, "-log", "none").strip()
    return first.removeprefix("LIGGGHTS (Version ").partition(",")[0]


if __name__ == "__main__":
    program = sys.argv.pop(1)
    if sys.argv[1:] == ["version"]:
        # Standard output is for answers alone.
        print(version(program), file=served.ANSWERS)
    else:
        kinds = ("contact", "plane", "uniform_gravity", "spring")
        served.run(partial(solve, piped.Piped(program)), *kinds)
