// A scene in Jolt: free bodies, rigid spheres and boxes, planes, rods, uniform gravity.
//
// Jolt's bindings for JavaScript are in single precision. Of two surfaces the larger restitution and
// the geometric mean of the frictions count: both have the law's. Rods are distance constraints.
"use strict";
const { cannot, halfSides, moments, run } = require("../served.js");

const KNOWN = ["uniform_gravity", "plane", "contact", "rod"];
// The package is a module of ECMAScript, which `require` and NODE_PATH do not find.
const JOLT = `${process.env.NODE_PATH}/jolt-physics/dist/jolt-physics.wasm-compat.js`;
// Of a point [kg m^2], which feels no torque: a body without inertia cannot be made.
const LEAST_MOMENT = 1e-3;
// Of an impact that bounces [m/s], which Jolt wants to be positive.
const LEAST_BOUNCE = 1e-9;
const MOST_SPEED = 1e9;
// Half the extent [m] of a plane.
const FAR = 100;
// Layers: what rests, and what moves.
const RESTING = 0;
const MOVING = 1;

let Jolt;

/** A vector as Jolt has it, for as long as `use` needs it. */
function withVector([x, y, z], use, Kind = Jolt.Vec3) {
  const made = new Kind(x, y, z);
  const result = use(made);
  Jolt.destroy(made);
  return result;
}

/** Jolt's world for a scene, and its bodies. */
class World {
  constructor(scene) {
    this.law = scene.rigidContact();
    this.step = scene.step;
    const settings = new Jolt.JoltSettings();
    this.setLayers(settings);
    this.jolt = new Jolt.JoltInterface(settings);
    Jolt.destroy(settings);
    this.system = this.jolt.GetPhysicsSystem();
    this.setPhysics();
    this.bodies = this.system.GetBodyInterface();
    withVector(scene.gravity, (g) => this.system.SetGravity(g));
    this.made = scene.bodies.map((body) => this.putBody(body));
    scene.ofKind("plane").forEach((plane) => this.putPlane(plane));
    scene.ofKind("rod").forEach((rod) => this.putRod(rod, scene.bodies));
  }

  /** Two layers, of which the one that rests does not meet itself. */
  setLayers(settings) {
    const pairs = new Jolt.ObjectLayerPairFilterTable(2);
    pairs.EnableCollision(RESTING, MOVING);
    pairs.EnableCollision(MOVING, MOVING);
    const layers = new Jolt.BroadPhaseLayerInterfaceTable(2, 2);
    for (const layer of [RESTING, MOVING]) {
      layers.MapObjectToBroadPhaseLayer(layer, new Jolt.BroadPhaseLayer(layer));
    }
    settings.mObjectLayerPairFilter = pairs;
    settings.mBroadPhaseLayerInterface = layers;
    settings.mObjectVsBroadPhaseLayerFilter = new Jolt.ObjectVsBroadPhaseLayerFilterTable(
      layers,
      2,
      pairs,
      2,
    );
  }

  /** The settings of the audit in refdem.toml. */
  setPhysics() {
    const settings = this.system.GetPhysicsSettings();
    settings.mMinVelocityForRestitution = LEAST_BOUNCE;
    settings.mNumVelocitySteps = 200;
    this.system.SetPhysicsSettings(settings);
  }

  /** Puts a body of the scene into the world. */
  putBody(body) {
    const [w, x, y, z] = body.attitude;
    const attitude = new Jolt.Quat(x, y, z, w);
    const settings = withVector(
      body.position,
      (at) =>
        new Jolt.BodyCreationSettings(
          this.shapeOf(body),
          at,
          attitude,
          Jolt.EMotionType_Dynamic,
          MOVING,
        ),
      Jolt.RVec3,
    );
    settings.mOverrideMassProperties = Jolt.EOverrideMassProperties_MassAndInertiaProvided;
    settings.mMassPropertiesOverride.mMass = body.mass;
    this.setInertia(settings.mMassPropertiesOverride.mInertia, body);
    withVector(body.velocity, (v) => settings.set_mLinearVelocity(v));
    withVector(body.omega, (omega) => settings.set_mAngularVelocity(omega));
    settings.mLinearDamping = 0;
    settings.mAngularDamping = 0;
    settings.mMaxLinearVelocity = MOST_SPEED;
    settings.mMaxAngularVelocity = MOST_SPEED;
    settings.mApplyGyroscopicForce = true;
    settings.mAllowSleeping = false;
    Jolt.destroy(attitude);
    return this.add(settings);
  }

  /** The shape of a body; points, and all bodies without a law, have none. */
  shapeOf(body) {
    if (this.law && body.shape.kind === "sphere") return new Jolt.SphereShape(body.shape.radius);
    if (this.law && body.shape.kind === "polyhedron") {
      return withVector(halfSides(body.shape), (half) => new Jolt.BoxShape(half, 0));
    }
    return new Jolt.EmptyShape();
  }

  /** Sets the moments of inertia, a diagonal matrix. */
  setInertia(inertia, body) {
    const [a, b, c] = moments(body, LEAST_MOMENT);
    withVector([a, 0, 0], (axis) => inertia.SetAxisX(axis));
    withVector([0, b, 0], (axis) => inertia.SetAxisY(axis));
    withVector([0, 0, c], (axis) => inertia.SetAxisZ(axis));
  }

  /** Adds a body with the law's surface. */
  add(settings) {
    if (this.law) {
      settings.mRestitution = this.law.restitution;
      settings.mFriction = this.law.friction;
    }
    const made = this.bodies.CreateBody(settings);
    Jolt.destroy(settings);
    this.bodies.AddBody(made.GetID(), Jolt.EActivation_Activate);
    return made;
  }

  /** Puts a plane, which rests, into the world. */
  putPlane(plane) {
    cannot(!this.law, "planes without a contact law");
    const distance = plane.normal.reduce((sum, n, axis) => sum + n * plane.point[axis], 0);
    const flat = withVector(plane.normal, (normal) => new Jolt.Plane(normal, -distance));
    const shape = new Jolt.PlaneShape(flat, null, FAR);
    const unturned = new Jolt.Quat(0, 0, 0, 1);
    const settings = withVector(
      [0, 0, 0],
      (at) =>
        new Jolt.BodyCreationSettings(shape, at, unturned, Jolt.EMotionType_Static, RESTING),
      Jolt.RVec3,
    );
    Jolt.destroy(unturned);
    Jolt.destroy(flat);
    this.add(settings);
  }

  /** Puts a rod between centres, or from a centre to the world, as a distance constraint. */
  putRod(rod, bodies) {
    cannot(rod.anchor_a.some(Boolean), "anchors off the centre");
    cannot(rod.b >= 0 && rod.anchor_b.some(Boolean), "anchors off the centre");
    const end = rod.b >= 0 ? bodies[rod.b].position : rod.anchor_b;
    const settings = new Jolt.DistanceConstraintSettings();
    withVector(bodies[rod.a].position, (at) => settings.set_mPoint1(at), Jolt.RVec3);
    withVector(end, (at) => settings.set_mPoint2(at), Jolt.RVec3);
    settings.mMinDistance = rod.length;
    settings.mMaxDistance = rod.length;
    const other = rod.b >= 0 ? this.made[rod.b] : this.jolt.sGetFixedToWorldBody();
    this.system.AddConstraint(settings.Create(this.made[rod.a], other));
    Jolt.destroy(settings);
  }

  /** One step. */
  advance() {
    this.jolt.Step(this.step, 1);
  }

  /** Position, velocity, attitude (w first) and omega of each body. */
  states() {
    return this.made.map((made) => {
      // What Jolt answers with is one object for all answers of a kind: it is read at once.
      const r = made.GetPosition();
      const place = [r.GetX(), r.GetY(), r.GetZ()];
      const v = made.GetLinearVelocity();
      const velocity = [v.GetX(), v.GetY(), v.GetZ()];
      const q = made.GetRotation();
      const attitude = [q.GetW(), q.GetX(), q.GetY(), q.GetZ()];
      const omega = made.GetAngularVelocity();
      return [...place, ...velocity, ...attitude, omega.GetX(), omega.GetY(), omega.GetZ()];
    });
  }
}

/** One run, in a world of its own. */
function solve(scene) {
  const world = new World(scene);
  try {
    scene.sampled(
      () => world.advance(),
      () => world.states(),
    );
  } finally {
    Jolt.destroy(world.jolt);
  }
}

import(JOLT)
  .then((module) => module.default())
  .then((made) => {
    Jolt = made;
    run(solve, ...KNOWN);
  });
