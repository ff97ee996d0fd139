// The inertia that cannon-es gives a body is that of the box around it, as it stands at that time.
//
// Body.updateMassProperties says "Approximate with AABB box". A solid sphere has 2/3 m R^2 in place
// of 2/5 m R^2, and a box that is turned when its shape is added has another inertia than one that
// is not. Varied here: the shape, and the turn.
"use strict";
const { Body, Box, Quaternion, Sphere, Vec3 } = require("cannon-es");

/** The moments of inertia of a body of 1 kg, as text. */
function inertia(shape, degrees = 0) {
  const quaternion = new Quaternion();
  quaternion.setFromAxisAngle(new Vec3(0, 0, 1), (degrees * Math.PI) / 180);
  const { x, y, z } = new Body({ mass: 1, shape, quaternion }).inertia;
  return [x, y, z].map((moment) => moment.toFixed(4)).join(", ");
}

console.log(`sphere, R = 1 m: ${inertia(new Sphere(1))}; a solid sphere: 0.4000`);
const half = new Vec3(1, 0.5, 0.25);
const sums = [0.5 ** 2 + 0.25 ** 2, 1 + 0.25 ** 2, 1 + 0.5 ** 2];
const right = sums.map((sum) => (sum / 3).toFixed(4)).join(", ");
for (const degrees of [0, 15, 45, 90]) {
  const found = inertia(new Box(half), degrees);
  console.log(`box, turned by ${degrees} degrees about z: ${found}; in its own axes ${right}`);
}
