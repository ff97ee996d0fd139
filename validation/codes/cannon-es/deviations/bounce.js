// A ball in cannon-es bounces with less than its restitution: with 11/13 where 1 is set.
//
// ContactEquation says of its restitution: "bounciness": u1 = -e*u0. What it asks for is
// b (1 + e) u0 - u0 with b = 4 d/(1 + 4 d), d being contactEquationRelaxation ("Relaxation time of
// the produced contact equations", by default 3, in steps): 12/13 (1 + e) - 1. On top comes a push
// 4 g/(h (1 + 4 d)) out of an overlap g. Varied here: d, and the overlap at the step of contact.
"use strict";
const { Body, Plane, Sphere, World } = require("cannon-es");

const STEP = 1 / 128;

/** The restitution that is seen of a ball that touches a floor at 1 m/s, at an overlap [m]. */
function bounced(restitution, relaxation, overlap) {
  const world = new World();
  world.defaultContactMaterial.restitution = restitution;
  world.defaultContactMaterial.contactEquationRelaxation = relaxation;
  world.defaultContactMaterial.contactEquationStiffness = 1e30;
  world.addBody(new Body({ type: Body.STATIC, shape: new Plane() }));
  const ball = new Body({ mass: 1, linearDamping: 0, shape: new Sphere(0.5) });
  ball.position.z = 0.5 - overlap;
  ball.velocity.z = -1;
  world.addBody(ball);
  world.step(STEP);
  return ball.velocity.z;
}

for (const restitution of [1, 0.75]) {
  for (const relaxation of [3, 30, 300, 1e15]) {
    const b = (4 * relaxation) / (1 + 4 * relaxation);
    const found = [0, STEP / 2].map((g) => bounced(restitution, relaxation, g).toFixed(5));
    const formula = (b * (1 + restitution) - 1).toFixed(5);
    const set = `restitution ${restitution}, relaxation ${relaxation}`;
    console.log(`${set}: ${found[0]} (formula ${formula}); ${found[1]} at half a step of overlap`);
  }
}
