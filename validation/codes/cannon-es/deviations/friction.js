// Friction in cannon-es is bounded by mu m g as an impulse of each step, at each point of contact.
//
// The constructor of FrictionEquation says of its bound: "slipForce should be +-F_friction =
// +-mu * F_normal = +-mu * m * g". GSSolver bounds by it what it adds to velocities over the
// masses, an impulse [N s], whatever the step: friction is 1/h times the law's.
// `world.frictionGravity` ("Gravity to use when approximating the friction max force
// (mu*mass*gravity)") times the step makes the impulse the law's. Varied here: the step, the load,
// the number of points that touch, and the direction, as each of two tangents has its own bound.
"use strict";
const { Body, Box, Plane, Sphere, Vec3, World } = require("cannon-es");

const FRICTION = 0.5;
const G = 10;
const FAST = 1e6; // [m/s], so that friction stops nothing in one step

/** A world with a floor and one body that touches it and cannot turn. */
function scene(shape, height, step, isByStep, gravity = new Vec3(0, 0, -G)) {
  const world = new World({ gravity });
  world.defaultContactMaterial.friction = FRICTION;
  world.solver.iterations = 1000;
  if (isByStep) world.frictionGravity = gravity.scale(step);
  world.addBody(new Body({ type: Body.STATIC, shape: new Plane() }));
  const body = new Body({ mass: 1, fixedRotation: true, linearDamping: 0, shape });
  body.position.set(0, 0, height);
  world.addBody(body);
  return { world, body };
}

/** The speed that one step takes from a body, over mu g h, which the law says. */
function braked(step, { isByStep = false, load = 0, angle = 0, isBox = false } = {}) {
  const shape = isBox ? new Box(new Vec3(0.5, 0.5, 0.5)) : new Sphere(0.5);
  const { world, body } = scene(shape, 0.5, step, isByStep);
  body.velocity.set(FAST * Math.cos(angle), FAST * Math.sin(angle), 0);
  body.applyForce(new Vec3(0, 0, -load));
  world.step(step);
  return ((FAST - body.velocity.length()) / (FRICTION * G * step)).toFixed(3);
}

for (const step of [1 / 60, 1 / 120, 1 / 600]) {
  const tuned = braked(step, { isByStep: true });
  const found = `friction is ${braked(step)} of the law's, ${tuned} with frictionGravity g h`;
  console.log(`step 1/${Math.round(1 / step)} s: ${found}`);
}
const step = 1 / 60;
for (const load of [0, G, 3 * G]) {
  const found = braked(step, { isByStep: true, load });
  console.log(`weight 10 N, load ${load} N: ${found} mu m g; the law: ${1 + load / G}`);
}
const box = braked(step, { isByStep: true, isBox: true });
console.log(`a sphere, 1 point: ${braked(step, { isByStep: true })}; a box, 4 points: ${box}`);
for (const degrees of [0, 15, 30, 45]) {
  const found = braked(step, { isByStep: true, angle: (degrees * Math.PI) / 180 });
  console.log(`a sphere, ${degrees} degrees from a tangent: ${found}; the law: 1`);
}
// A slope of tan = 3/4 that friction of 1/2 cannot hold.
for (const isByStep of [false, true]) {
  const slope = new Vec3(0.6 * G, 0, -0.8 * G);
  const { world, body } = scene(new Box(new Vec3(1, 1, 0.125)), 0.125, step, isByStep, slope);
  for (let n = 0; n < 60; n++) world.step(step);
  const words = isByStep ? "with frictionGravity g h" : "as shipped";
  console.log(`box on a slope, 1 s, ${words}: ${body.position.x.toFixed(3)} m; the law: 1.000 m`);
}
