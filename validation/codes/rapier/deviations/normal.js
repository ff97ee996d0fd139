// Oblique balls bounce in Rapier along the normal of when they were 0.02 m apart, at every small step.
//
// Contacts begin at the prediction distance, by default 0.02 lengthUnit, and the impulse acts along
// the normal of that time. Of two balls of 1 m one passes the other by half a diameter: along the
// normal of the touch they part with 0.760 of their speed in place of 0.75, and their angular
// momentum changes. Smaller steps do not help; a smaller prediction distance does.
"use strict";
const RAPIER = require("@dimforge/rapier3d-compat");

const NORMAL = { x: Math.sqrt(0.75), y: 0.5 }; // of the touch

/** The restitution that is seen, and the relative change of the angular momentum of both balls. */
function impact(step, prediction) {
  const world = new RAPIER.World({ x: 0, y: 0, z: 0 });
  world.timestep = step;
  world.integrationParameters.normalizedPredictionDistance = prediction;
  const balls = [-1, 1].map((side) => {
    const start = RAPIER.RigidBodyDesc.dynamic()
      .setTranslation((side * (NORMAL.x + 0.1)) / 2, (side * NORMAL.y) / 2, 0)
      .setLinvel(-side * 0.5, 0, 0);
    const ball = world.createRigidBody(start);
    world.createCollider(RAPIER.ColliderDesc.ball(0.5).setRestitution(0.75).setFriction(0), ball);
    return ball;
  });
  const before = turning(balls);
  for (let i = 0; i < 0.4 / step; i++) world.step();
  const [a, b] = balls.map((ball) => ball.linvel());
  const apart = (b.x - a.x) * NORMAL.x + (b.y - a.y) * NORMAL.y;
  return [apart / NORMAL.x, turning(balls) / before - 1];
}

/** The angular momentum about z, over the mass; a ball of 0.5 m has the moment 0.4 m (0.5 m)^2. */
function turning(balls) {
  let sum = 0;
  for (const ball of balls) {
    const r = ball.translation();
    const v = ball.linvel();
    sum += r.x * v.y - r.y * v.x + 0.4 * 0.25 * ball.angvel().z;
  }
  return sum;
}

RAPIER.init().then(() => {
  console.log("prediction [m]  step [s]  restitution  change of angular momentum");
  for (const prediction of [0.02, 0.002, 0.0002]) {
    for (const power of [6, 9, 12, 14]) {
      const [restitution, change] = impact(2 ** -power, prediction);
      console.log(prediction, `2^-${power}`, restitution.toFixed(4), change.toExponential(1));
    }
  }
});
