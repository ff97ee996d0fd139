// A spring of cannon-es without damping has a damping of 1 N s/m.
//
// The documentation of Spring's option says "Damping of the spring. A number >= 0. @default 1"; its
// constructor has `options.damping || 1`, which takes 0 for a number that was not given, as it does
// with a stiffness of 0. Varied here: the damping, and where it is set.
"use strict";
const { Body, Spring, World } = require("cannon-es");

const STEP = 1e-3;

/** The amplitude after ten periods of an oscillator that starts at 1 m. */
function amplitude(options, after = {}) {
  const world = new World();
  const held = new Body({ type: Body.STATIC });
  const mass = new Body({ mass: 1, linearDamping: 0 });
  mass.position.x = 1;
  world.addBody(held);
  world.addBody(mass);
  const stiffness = (2 * Math.PI) ** 2; // a period of 1 s
  const spring = new Spring(held, mass, { restLength: 0, stiffness, ...options });
  Object.assign(spring, after);
  for (let n = 0; n < 10 / STEP; n++) {
    spring.applyForce();
    world.step(STEP);
  }
  return mass.position.x.toFixed(4);
}

for (const damping of [0, 1e-12, 0.5, 1]) {
  const found = amplitude({ damping });
  const law = Math.exp(-5 * damping).toFixed(4);
  const set = `damping ${damping} in the options`;
  console.log(`${set}: amplitude ${found} after 10 periods, the law: ${law}`);
}
console.log(`damping 0 set afterwards: ${amplitude({}, { damping: 0 })}`);
