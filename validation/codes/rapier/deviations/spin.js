// A body that spins without torque spins faster in Rapier, by about 1e-7 of its speed a substep.
//
// Single precision rounds by at most 6e-8 in both directions; here it is one direction, so that the
// error grows with the number of steps: it is larger at the finer step. Rapier corrects the angular
// velocity for gyroscopic torque in each substep, and says in the source of that correction that
// the angular momentum is to be preserved.
"use strict";
const RAPIER = require("@dimforge/rapier3d-compat");

const SECONDS = 10;
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

RAPIER.init().then(() => {
  for (const step of [1e-2, 2.5e-3, 6.25e-4]) {
    const gained = speed(step) - 1;
    const substeps = (4 * SECONDS) / step;
    const each = (gained / substeps).toExponential(1);
    console.log(`step ${step} s: ${gained.toExponential(1)} rad/s too fast, ${each} a substep`);
  }
});
