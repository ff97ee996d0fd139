// A box that friction holds on a slope moves by up to 1e-4 m in Rapier, and then creeps.
//
// The box of 2 m, 0.25 m and 2 m starts at rest on a plane with a coefficient of friction of 0.75.
// Gravity leans, so that the slope is 0.75 or less: the law of friction has the box at rest.
"use strict";
const RAPIER = require("@dimforge/rapier3d-compat");

const FRICTION = 0.75;

/** The way down the slope [m] of the box after some seconds. */
function way(slope, step, seconds) {
  const gravity = { x: 8 * slope, y: -8, z: 0 };
  const world = new RAPIER.World(gravity);
  world.timestep = step;
  const plane = new RAPIER.HalfSpace({ x: 0, y: 1, z: 0 });
  world.createCollider(new RAPIER.ColliderDesc(plane).setFriction(FRICTION));
  const body = world.createRigidBody(
    RAPIER.RigidBodyDesc.dynamic().setTranslation(0, 0.125, 0).setCanSleep(false),
  );
  world.createCollider(RAPIER.ColliderDesc.cuboid(1, 0.125, 1).setFriction(FRICTION), body);
  for (let n = 0; n < Math.round(seconds / step); n++) world.step();
  return body.translation().x;
}

RAPIER.init().then(() => {
  for (const slope of [0.75, 0.7, 0.5]) {
    for (const step of [1 / 60, 1e-3]) {
      const [early, late] = [way(slope, step, 0.25), way(slope, step, 0.5)];
      const creep = ((late - early) / 0.25).toExponential(1);
      const where = `slope ${slope}, step ${step.toFixed(4)} s`;
      console.log(`${where}: ${early.toExponential(1)} m after 0.25 s, then ${creep} m/s`);
    }
  }
});
