// A body of cannon-es that spins freely keeps its angular velocity, not its angular momentum.
//
// Body.integrate adds dt J^-1 torque to omega and leaves the term omega x J omega of Euler's
// equations out. Varied here: the inertia (the term vanishes where all moments are the same), and
// the term itself, given to the body as a torque before each step.
"use strict";
const { Body, Vec3, World } = require("cannon-es");

const STEP = 1e-4;
const SECONDS = 10;

/** The angular momentum of a body, in space axes. */
function momentum(body) {
  const inside = body.vectorToLocalFrame(body.angularVelocity);
  return body.vectorToWorldFrame(inside.vmul(body.inertia));
}

/** The change of omega and of the angular momentum, each over its size at the start. */
function changes(moments, hasTerm) {
  const world = new World();
  const body = new Body({ mass: 1, angularDamping: 0 });
  body.inertia = new Vec3(...moments);
  body.invInertia = new Vec3(...moments.map((moment) => 1 / moment));
  body.updateInertiaWorld(true);
  body.angularVelocity.set(0.9, 1.1, 1.3);
  world.addBody(body);
  const [omega, start] = [body.angularVelocity.clone(), momentum(body)];
  for (let n = 0; n < SECONDS / STEP; n++) {
    if (hasTerm) body.torque.vsub(body.angularVelocity.cross(momentum(body)), body.torque);
    world.step(STEP);
  }
  const turned = body.angularVelocity.distanceTo(omega) / omega.length();
  const lost = momentum(body).distanceTo(start) / start.length();
  return `omega ${turned.toExponential(1)}, angular momentum ${lost.toExponential(1)}`;
}

for (const moments of [[1, 1, 1], [1, 1, 2], [1, 2, 3]]) {
  for (const hasTerm of [false, true]) {
    const words = hasTerm ? "with the term as a torque" : "as shipped";
    console.log(`inertia ${moments}, ${words}: change of ${changes(moments, hasTerm)}`);
  }
}
