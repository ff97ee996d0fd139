// A scene in cannon-es: free bodies, rigid spheres and boxes, planes, rods, springs, gravity.
//
// Mass and inertia are set on the body: what the code takes from a shape is the inertia of the box
// around it (deviations/inertia.js). Rods are distance constraints, springs the code's own springs.
"use strict";
const { cannot, halfSides, moments, run } = require("../served.js");
const CANNON = require("cannon-es");

const KNOWN = ["uniform_gravity", "plane", "contact", "rod", "spring"];
// Of a point [kg m^2], which feels no torque: 0 stands for a body that cannot turn.
const LEAST_MOMENT = 1e-3;
// Relaxation of all equations, in steps: at this many the velocity is what the law asks for, and
// nothing pushes an overlap or a stretch apart (deviations/bounce.js).
const RELAXATION = 1e15;
// Of all equations [N/m]: none yields.
const STIFFNESS = 1e30;
const Z = new CANNON.Vec3(0, 0, 1);

/** A vector as cannon-es has it. */
function vector([x, y, z]) {
  return new CANNON.Vec3(x, y, z);
}

/** A world of a scene, with the settings of the audit in refdem.toml. */
class World {
  constructor(scene) {
    this.law = scene.rigidContact();
    const hasFriction = Boolean(this.law && this.law.friction);
    cannot(scene.method === "friction-by-step" && !hasFriction, "no friction to be bound");
    this.step = scene.step;
    this.solver = new CANNON.GSSolver();
    this.solver.iterations = 200;
    this.solver.tolerance = 0;
    this.world = new CANNON.World({ gravity: vector(scene.gravity), solver: this.solver });
    this.setLaw(scene.method);
    this.made = scene.bodies.map((body) => this.putBody(body));
    this.ground = new CANNON.Body({ type: CANNON.Body.STATIC });
    this.world.addBody(this.ground);
    scene.ofKind("plane").forEach((plane) => this.putPlane(plane));
    scene.ofKind("rod").forEach((rod) => this.putRod(rod));
    this.springs = scene.ofKind("spring").map((spring) => this.spring(spring));
  }

  /** Sets the law of contact of all bodies. */
  setLaw(method) {
    if (!this.law) return;
    const law = this.world.defaultContactMaterial;
    law.restitution = this.law.restitution;
    law.friction = this.law.friction;
    law.contactEquationStiffness = STIFFNESS;
    law.frictionEquationStiffness = STIFFNESS;
    law.contactEquationRelaxation = RELAXATION;
    law.frictionEquationRelaxation = RELAXATION;
    // The bound of friction, mu m |frictionGravity|, is one of the impulse of a step
    // (deviations/friction.js).
    if (method === "friction-by-step") {
      this.world.frictionGravity = this.world.gravity.scale(this.step);
    }
  }

  /** Puts a body of the scene into the world. */
  putBody(body) {
    const [w, x, y, z] = body.attitude;
    const made = new CANNON.Body({
      mass: body.mass,
      position: vector(body.position),
      velocity: vector(body.velocity),
      quaternion: new CANNON.Quaternion(x, y, z, w),
      angularVelocity: vector(body.omega),
      linearDamping: 0,
      angularDamping: 0,
    });
    if (this.law && body.shape.kind === "sphere") {
      made.addShape(new CANNON.Sphere(body.shape.radius));
    } else if (this.law && body.shape.kind === "polyhedron") {
      made.addShape(new CANNON.Box(vector(halfSides(body.shape))));
    }
    const inertia = moments(body, LEAST_MOMENT);
    made.inertia = vector(inertia);
    made.invInertia = vector(inertia.map((moment) => 1 / moment));
    made.updateInertiaWorld(true);
    this.world.addBody(made);
    return made;
  }

  /** Puts a plane, which rests, into the world. */
  putPlane(plane) {
    cannot(!this.law, "planes without a contact law");
    const made = new CANNON.Body({
      type: CANNON.Body.STATIC,
      position: vector(plane.point),
      shape: new CANNON.Plane(),
    });
    made.quaternion.setFromVectors(Z, vector(plane.normal));
    this.world.addBody(made);
  }

  /** Puts a rod between centres, or from a centre to the world, as a distance constraint. */
  putRod(rod) {
    cannot(rod.anchor_a.some(Boolean), "anchors off the centre");
    cannot(rod.b >= 0 && rod.anchor_b.some(Boolean), "anchors off the centre");
    const other = rod.b >= 0 ? this.made[rod.b] : this.heldAt(rod.anchor_b);
    const made = new CANNON.DistanceConstraint(this.made[rod.a], other, rod.length);
    // Its own step would be 1/60 s at any step (deviations/rod.js).
    made.distanceEquation.setSpookParams(STIFFNESS, RELAXATION, this.step);
    this.world.addConstraint(made);
  }

  /** A body that rests at a place. */
  heldAt(place) {
    const made = new CANNON.Body({ type: CANNON.Body.STATIC, position: vector(place) });
    this.world.addBody(made);
    return made;
  }

  /** A linear spring without damping. */
  spring(element) {
    const isLinear = element.exponent === 1 && element.quadratic === 0 && element.cubic === 0;
    cannot(!isLinear, "springs that are not linear");
    const other = element.b >= 0 ? this.made[element.b] : this.ground;
    const made = new CANNON.Spring(this.made[element.a], other, {
      localAnchorA: vector(element.anchor_a),
      localAnchorB: vector(element.anchor_b),
      restLength: element.length,
    });
    // The constructor takes 0 for a number that was not given (deviations/spring.js).
    made.stiffness = element.stiffness;
    made.damping = 0;
    return made;
  }

  /** One step, in which the springs pull at the places of its start. */
  advance() {
    this.springs.forEach((spring) => spring.applyForce());
    this.world.step(this.step);
  }

  /** Position, velocity, attitude (w first) and omega of each body. */
  states() {
    return this.made.map((made) => {
      const { position: r, velocity: v, quaternion: q, angularVelocity: omega } = made;
      return [r.x, r.y, r.z, v.x, v.y, v.z, q.w, q.x, q.y, q.z, omega.x, omega.y, omega.z];
    });
  }
}

/** One run, in a world of its own. */
function solve(scene) {
  const world = new World(scene);
  scene.sampled(
    () => world.advance(),
    () => world.states(),
  );
}

run(solve, ...KNOWN);
