// A scene in Rapier: free bodies, rigid spheres and boxes, planes, uniform gravity.
//
// Rapier's bindings for JavaScript are in single precision. Mass and inertia are set on the body and
// not by densities. The coefficients of two surfaces are averaged by default: both have the law's.
"use strict";
const { cannot, halfSides, moments, run } = require("../served.js");
const RAPIER = require("@dimforge/rapier3d-compat");

const KNOWN = ["uniform_gravity", "plane", "contact"];
// Of a point [kg m^2], which feels no torque: Rapier takes 0 for a body that cannot turn.
const LEAST_MOMENT = 1e-3;
// Of a unit quaternion (x, y, z, w): principal axes are those of the body.
const UNTURNED = { x: 0, y: 0, z: 0, w: 1 };

/** A vector as Rapier has it. */
function vector([x, y, z]) {
  return { x, y, z };
}

/** The collider of a shape with the law's surface, and no mass of its own. */
function collider(shape, law) {
  return new RAPIER.ColliderDesc(shape)
    .setDensity(0)
    .setRestitution(law.restitution)
    .setFriction(law.friction);
}

/** The shape of a body; undefined for a point. */
function shapeOf(body) {
  if (body.shape.kind === "sphere") return new RAPIER.Ball(body.shape.radius);
  if (body.shape.kind === "polyhedron") return new RAPIER.Cuboid(...halfSides(body.shape));
  return undefined;
}

/** Puts a body of the scene into Rapier's world. */
function putBody(world, body, law) {
  const [w, x, y, z] = body.attitude;
  const inertia = vector(moments(body, LEAST_MOMENT));
  const made = world.createRigidBody(
    RAPIER.RigidBodyDesc.dynamic()
      .setTranslation(...body.position)
      .setRotation({ x, y, z, w })
      .setLinvel(...body.velocity)
      .setAngvel(vector(body.omega))
      .setAdditionalMassProperties(body.mass, vector([0, 0, 0]), inertia, UNTURNED)
      .setCanSleep(false),
  );
  const shape = shapeOf(body);
  if (law && shape) world.createCollider(collider(shape, law), made);
  return made;
}

/** Puts a plane, which rests, into Rapier's world. */
function putPlane(world, plane, law) {
  cannot(!law, "planes without a contact law");
  const shape = new RAPIER.HalfSpace(vector(plane.normal));
  world.createCollider(collider(shape, law).setTranslation(...plane.point));
}

/** Position, velocity, attitude (w first) and omega of a body. */
function state(made) {
  const [r, v, q, omega] = [made.translation(), made.linvel(), made.rotation(), made.angvel()];
  return [r.x, r.y, r.z, v.x, v.y, v.z, q.w, q.x, q.y, q.z, omega.x, omega.y, omega.z];
}

/** One run, in a world of its own. */
function solve(scene) {
  const law = scene.rigidContact();
  const world = new RAPIER.World(vector(scene.gravity));
  try {
    world.timestep = scene.step;
    const made = scene.bodies.map((body) => putBody(world, body, law));
    scene.ofKind("plane").forEach((plane) => putPlane(world, plane, law));
    scene.sampled(
      () => world.step(),
      () => made.map(state),
    );
  } finally {
    world.free();
  }
}

RAPIER.init().then(() => run(solve, ...KNOWN));
