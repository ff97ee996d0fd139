// A rod in cannon-es has a time of its own: what it is off by decays in 0.07 s at any step.
//
// Constraints keep what the constructor of Equation sets: "`timeStep`= 1 / 60, _note the hardcoded
// refresh rate._" World.step does not set it anew, so that a stretch g is pulled back by
// g 4/(h0 (1 + 4 d)) = 14.1 g a second with h0 = 1/60 s and d = 4. Varied here: the step, and h0 by
// setSpookParams, which every equation has (with a stiffness that does not count).
"use strict";
const { Body, DistanceConstraint, World } = require("cannon-es");

/** The speed at which a rod that starts 1 % too long pulls its end back, over the stretch [1/s]. */
function pull(step, own) {
  const world = new World();
  const held = new Body({ type: Body.STATIC });
  const end = new Body({ mass: 1, linearDamping: 0 });
  end.position.x = 1.01;
  world.addBody(held);
  world.addBody(end);
  const rod = new DistanceConstraint(held, end, 1);
  if (own) rod.distanceEquation.setSpookParams(1e30, 4, own);
  world.addConstraint(rod);
  world.step(step);
  return (-end.velocity.x / 0.01).toFixed(1);
}

for (const step of [1 / 60, 1 / 600, 1 / 6000]) {
  const words = `step 1/${Math.round(1 / step)} s`;
  console.log(`${words}: ${pull(step)} of the stretch a second, ${pull(step, step)} with h0 = h`);
}
