// A body that spins without torque spins faster in Rapier, by about 1e-7 of its speed a substep.
//
// Since version 0.20 of the package for JavaScript "gyroscopic forces are applied per-substep in the
// principal inertia frame" (Rapier's CHANGELOG.md): omega is turned into the principal axes and
// back, by a quaternion q that is made unit in single precision. What |q| lacks of 1 changes omega
// by |q|^4, in one direction more often than in the other. A twin of these lines, without any
// torque, gains as much in single precision and nothing in double. Package 0.19.3 gains nothing, and
// neither do the Python bindings 0.36.1 with `gyroscopic_forces(False)`; with True they gain 9e-8.
"use strict";
const RAPIER = require("@dimforge/rapier3d-compat");

const SECONDS = 10;
const SUBSTEPS = 4;
const ZERO = { x: 0, y: 0, z: 0 };

/** The angular speed at the end of a sphere that starts with 1 rad/s. */
function speed(step) {
  const world = new RAPIER.World(ZERO);
  world.timestep = step;
  const body = world.createRigidBody(
    RAPIER.RigidBodyDesc.dynamic()
      .setAngvel({ x: 0, y: 0, z: 1 })
      .setAdditionalMassProperties(1, ZERO, { x: 1, y: 1, z: 1 }, { x: 0, y: 0, z: 0, w: 1 })
      .setCanSleep(false),
  );
  for (let n = 0; n < Math.round(SECONDS / step); n++) world.step();
  return body.angvel().z;
}

/** The same of a twin about the axis z, whose numbers are rounded by a function. */
function twin(step, rounded) {
  const half = rounded(rounded(step / SUBSTEPS) / 2);
  let [omega, z, w] = [1, 0, 1];
  // q v q* of a vector along z, q = (0, 0, z, w): v (w^2 - z^2) + z (2 z v), which is |q|^2 v.
  const turned = (v) => {
    const kept = rounded(v * rounded(rounded(w * w) - rounded(z * z)));
    return rounded(kept + rounded(z * rounded(2 * rounded(z * v))));
  };
  for (let n = 0; n < Math.round((SUBSTEPS * SECONDS) / step); n++) {
    // Into the principal axes and back.
    omega = turned(turned(omega));
    const turn = rounded(omega * half);
    const [oldZ, oldW] = [z, w];
    z = rounded(oldZ + rounded(turn * oldW));
    w = rounded(oldW - rounded(turn * oldZ));
    const shrunk = rounded(1 / rounded(Math.sqrt(rounded(rounded(z * z) + rounded(w * w)))));
    z = rounded(z * shrunk);
    w = rounded(w * shrunk);
  }
  return omega;
}

RAPIER.init().then(() => {
  for (const step of [1e-2, 2.5e-3, 6.25e-4]) {
    const each = (omega) => ((omega - 1) / ((SUBSTEPS * SECONDS) / step)).toExponential(1);
    const single = each(twin(step, Math.fround));
    const double = each(twin(step, (x) => x));
    const gained = `${each(speed(step))} of the speed gained a substep`;
    console.log(`step ${step} s: ${gained}; by the twin ${single}, in double precision ${double}`);
  }
});
