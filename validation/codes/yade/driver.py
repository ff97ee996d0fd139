"""Scenes in YADE: start.py answers requests until standard input ends, and yade -x -n driver.py
request.json trajectory.csv one.
"""

import math
import sys
from pathlib import Path

sys.path.insert(0, str(Path(sys.argv[0]).resolve().parents[1]))
import border
import served
import triangle
from border import cannot
from yade import minieigenHP, utils
from yade import wrapper as y

LAWS = {
    "elastic": [[y.Ip2_FrictMat_FrictMat_FrictPhys()], [y.Law2_ScGeom_FrictPhys_CundallStrack()]],
    "damped": [[y.Ip2_ViscElMat_ViscElMat_ViscElPhys()], [y.Law2_ScGeom_ViscElPhys_Basic()]],
    "hertz": [[y.Ip2_FrictMat_FrictMat_MindlinPhys()], [y.Law2_ScGeom_MindlinPhys_Mindlin()]],
}
"""What makes the numbers of a contact, and its law, by the kind of contact."""
FACET = math.sqrt(3) / (4 - math.sqrt(3))
"""Young's modulus of a facet over that of the spheres under Hertz's law.

A sphere and a facet have R* = 2 R/3 in place of R/2, so that E* has to be sqrt(3)/2 as large: E_f/
(E + E_f) = sqrt(3)/4.
"""
LEAST_STEP = 1e-300
"""A step [s] in which nothing moves."""
POISSON = 0.25
"""Poisson's ratio of spheres under Hertz's law; their force does not depend on it."""
RUN = y.Omega()
ROWS = []
"""Sample, body, and its state."""


def kind_of(law):
    """The kind of a contact: a key of LAWS."""
    if law["law"] == "hertz":
        return "hertz"
    return "damped" if law["damping"] > 0 else "elastic"


def refuse(law, bodies):
    """Raises UnsupportedError for what no law here is."""
    cannot(
        law["law"] == "hertz" and law["friction"] > 0,
        "friction under Hertz's law: this driver does not say it yet",
    )
    rubs = law["friction"] > 0
    cannot(
        rubs and law["tangential_stiffness"] == 0,
        "friction of full size at any slip: it goes through a tangential spring",
    )
    cannot(rubs and law["branch"] != "R-d/2", "a branch other than R - d/2")
    cannot(
        law["damping"] > 0 and law["cutoff"] == "zero_overlap",
        "a force that pulls: the damped one ends where it would",
    )
    cannot(any(body["shape"]["kind"] != "sphere" for body in bodies), "contacts of points")


def material(law, radius, is_facet=False):
    """The material of a sphere, or of a facet that spheres of this radius touch; damped ones are in
    series, whatever its documentation says (reports/findings.md).

    A facet counts as a sphere of radius 2 R (Ig2_Facet_Sphere_ScGeom).
    """
    if law is None:
        return y.FrictMat()
    if law["law"] == "hertz":
        # K = 4/3 E* sqrt(R*), R* = R/2 in pairs and at walls, 1/E* = 2 (1 - nu^2)/E.
        effective = 0.75 * law["stiffness"] / math.sqrt(radius / 2)
        young = 2 * (1 - POISSON**2) * effective
        if is_facet:
            young *= FACET
        return y.FrictMat(young=young, poisson=POISSON, frictionAngle=0.0)
    numbers = [law[name] for name in ("stiffness", "tangential_stiffness", "damping")]
    angle = math.atan(law["friction"])
    (kn, ks, cn) = numbers
    if cn == 0:
        return y.FrictMat(
            young=kn / ((2 if is_facet else 1) * radius),
            poisson=ks / kn or 1.0,
            frictionAngle=angle,
        )  # of 0 NaN comes (reports/findings.md)
    return y.ViscElMat(kn=2 * kn, ks=2 * ks, cn=2 * cn, cs=0.0, frictionAngle=angle)


def place(request, law):
    """Puts the bodies into YADE."""
    for body in request["scene"]["bodies"]:
        radius = body["shape"].get("radius", 1.0)
        sphere = utils.sphere(body["position"], radius, material=material(law, radius))
        sphere.state.mass = body["mass"]
        sphere.state.inertia = body["inertia"]
        sphere.state.vel, sphere.state.angVel, sphere.state.ori = (
            body["velocity"],
            body["omega"],
            minieigenHP.Quaternion(*body["attitude"]),
        )
        sphere.state.angMom = [
            sum(j * w for j, w in zip(row, body["omega"], strict=True))
            for row in border.tensor(body)
        ]
        sphere.aspherical = len(set(body["inertia"])) > 1
        if not any(body["inertia"]):
            # A point has no rotation: YADE would divide a torque of 0 by its moment of 0.
            sphere.state.blockedDOFs = "XYZ"
        RUN.bodies.append(sphere)


def place_planes(request, law):
    """Puts the planes into YADE: as a wall, or as a facet if they rub or lie along no axis.

    The lever of friction is R - d/2 at a facet; at a wall it is another for slip than for torque.
    """
    planes = border.of_kind(request, "plane")
    cannot(planes and law is None, "planes without a contact law")
    radii = {body["shape"].get("radius") for body in request["scene"]["bodies"]}
    cannot(planes and len(radii) > 1, "planes but with spheres of one radius")
    for plane in planes:
        inradius = triangle.reach(request, plane)
        if triangle.is_along_an_axis(plane) and law["friction"] == 0:
            axis = [abs(a) for a in plane["normal"]].index(1)
            sense = int(plane["normal"][axis])
            body = utils.wall(plane["point"], axis, sense=sense, material=material(law, *radii))
        else:
            (radius,) = radii
            corners = triangle.corners(plane, inradius)
            body = utils.facet(corners, material=material(law, radius, is_facet=True))
        RUN.bodies.append(body)


def record(stride):
    """Keeps the states of all spheres; YADE calls it by name."""
    for n, state in enumerate(
        body.state for body in RUN.bodies if isinstance(body.shape, y.Sphere)
    ):
        x = state.pos
        q = state.ori
        ROWS.append(
            (RUN.iter // stride, n, [*x], [*state.vel], (q[3], q[0], q[1], q[2]), [*state.angVel])
        )


def solve(scene):
    """Runs a scene and keeps its rows."""
    RUN.reset()
    ROWS.clear()
    request, bodies, times = scene.request, scene.bodies, scene.times
    step, stride = scene.step, scene.stride
    cannot(times[1] < times[0], "negative steps")
    law = border.contact_law(request, "linear", "hertz")
    if law:
        refuse(law, bodies)
    place(request, law)
    place_planes(request, law)
    g = minieigenHP.Vector3(
        *(
            sum(field["g"][k] for field in border.of_kind(request, "uniform_gravity"))
            for k in range(3)
        )
    )
    meet = [
        y.Ig2_Sphere_Sphere_ScGeom(avoidGranularRatcheting=False),
        y.Ig2_Wall_Sphere_ScGeom(),
        y.Ig2_Facet_Sphere_ScGeom(),
    ]
    bounds = [y.Bo1_Sphere_Aabb(), y.Bo1_Wall_Aabb(), y.Bo1_Facet_Aabb()]
    contact = [
        y.InsertionSortCollider(bounds, verletDist=0),
        y.InteractionLoop(meet, *(LAWS[kind_of(law)] if law else ([], []))),
    ]
    begin = [y.ForceResetter(), *(contact if law else [])]
    # Alone, forces add up (reports/findings.md). In a step of 0 Mindlin's law divides 0 by 0.
    RUN.engines, RUN.dt = [*begin, y.NewtonIntegrator(damping=0)], LEAST_STEP
    RUN.run(1, True)
    for n, body in enumerate(bodies):
        RUN.bodies[n].state.vel -= step / 2 * (RUN.forces.f(n) / body["mass"] + g)
    RUN.resetTime()
    RUN.engines = [
        y.PyRunner(command=f"record({stride})", iterPeriod=stride, initRun=True),
        *begin,
        y.NewtonIntegrator(damping=0, gravity=g),
    ]
    RUN.dt = step
    RUN.run(stride * (len(times) - 1) + 1, True)
    scene.rows.extend((times[sample], *row) for sample, *row in ROWS)


served.run(solve, "contact", "plane", "uniform_gravity")
