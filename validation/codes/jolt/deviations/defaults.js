// Bodies of Jolt as shipped: no bounce below 1 m/s, a drag of 5 % a second, no gyroscopic torque.
//
// All are settings, and Jolt's headers tell what they come with: mMinVelocityForRestitution of
// PhysicsSettings ("This lets an object settle sooner"), and mLinearDamping, mAngularDamping and
// mApplyGyroscopicForce of BodyCreationSettings. Here each is varied, and what it does follows.
"use strict";
const JOLT = `${process.env.NODE_PATH}/jolt-physics/dist/jolt-physics.wasm-compat.js`;
const STEP = 1e-3;

/** A world without gravity, of one layer. */
function worldOf(Jolt, change = () => {}) {
  const pairs = new Jolt.ObjectLayerPairFilterTable(1);
  pairs.EnableCollision(0, 0);
  const layers = new Jolt.BroadPhaseLayerInterfaceTable(1, 1);
  layers.MapObjectToBroadPhaseLayer(0, new Jolt.BroadPhaseLayer(0));
  const settings = new Jolt.JoltSettings();
  settings.mObjectLayerPairFilter = pairs;
  settings.mBroadPhaseLayerInterface = layers;
  settings.mObjectVsBroadPhaseLayerFilter = new Jolt.ObjectVsBroadPhaseLayerFilterTable(
    layers,
    1,
    pairs,
    1,
  );
  const world = new Jolt.JoltInterface(settings);
  world.GetPhysicsSystem().SetGravity(new Jolt.Vec3(0, 0, 0));
  const physics = world.GetPhysicsSystem().GetPhysicsSettings();
  change(physics);
  world.GetPhysicsSystem().SetPhysicsSettings(physics);
  return world;
}

/** A body of a shape at a height, with changes to its settings. */
function bodyOf(Jolt, world, shape, height, kind, change) {
  const at = new Jolt.RVec3(0, height, 0);
  const attitude = new Jolt.Quat(0, 0, 0, 1);
  const settings = new Jolt.BodyCreationSettings(shape, at, attitude, kind, 0);
  change(settings);
  const bodies = world.GetPhysicsSystem().GetBodyInterface();
  const body = bodies.CreateBody(settings);
  bodies.AddBody(body.GetID(), Jolt.EActivation_Activate);
  return body;
}

/** Steps for some seconds. */
function run(world, seconds) {
  for (let n = 0; n < Math.round(seconds / STEP); n++) world.Step(STEP, 1);
}

/** The restitution that is seen of a ball that meets a floor, where 0.75 is set. */
function bounce(Jolt, speed, threshold) {
  const world = worldOf(Jolt, (settings) => {
    settings.mMinVelocityForRestitution = threshold;
  });
  const surface = (settings) => {
    settings.mRestitution = 0.75;
    settings.mLinearDamping = 0;
  };
  const floor = new Jolt.BoxShape(new Jolt.Vec3(5, 1, 5), 0);
  bodyOf(Jolt, world, floor, -1, Jolt.EMotionType_Static, surface);
  const ball = bodyOf(Jolt, world, new Jolt.SphereShape(0.5), 1, Jolt.EMotionType_Dynamic, (s) => {
    surface(s);
    s.mLinearVelocity = new Jolt.Vec3(0, -speed, 0);
  });
  run(world, 0.6 / speed);
  const found = ball.GetLinearVelocity().GetY() / speed;
  Jolt.destroy(world);
  return found;
}

/** The velocity, and omega, of a long box after ten seconds without any force. */
function coast(Jolt, change = () => {}) {
  const world = worldOf(Jolt);
  const shape = new Jolt.BoxShape(new Jolt.Vec3(1, 0.25, 0.1), 0);
  const body = bodyOf(Jolt, world, shape, 0, Jolt.EMotionType_Dynamic, (settings) => {
    settings.mLinearVelocity = new Jolt.Vec3(1, 0, 0);
    settings.mAngularVelocity = new Jolt.Vec3(0.1, 1, 0);
    change(settings);
  });
  run(world, 10);
  const omega = body.GetAngularVelocity();
  const turn = [omega.GetX(), omega.GetY(), omega.GetZ()].map((w) => w.toFixed(3));
  const found = [body.GetLinearVelocity().GetX().toFixed(3), turn.join(", ")];
  Jolt.destroy(world);
  return found;
}

import(JOLT)
  .then((module) => module.default())
  .then((Jolt) => {
    for (const threshold of [1, 0.5, 1e-9]) {
      const found = [2, 1.1, 0.9, 0.6, 0.4].map(
        (speed) => `${bounce(Jolt, speed, threshold).toFixed(3)} at ${speed} m/s`,
      );
      const set = `mMinVelocityForRestitution ${threshold} (default: 1)`;
      console.log(`${set}: restitution ${found.join(", ")} (set: 0.75)`);
    }
    const changes = {
      "as shipped": () => {},
      "without damping": (settings) => {
        settings.mLinearDamping = 0;
        settings.mAngularDamping = 0;
      },
      "without damping, with gyroscopic torque": (settings) => {
        settings.mLinearDamping = 0;
        settings.mAngularDamping = 0;
        settings.mApplyGyroscopicForce = true;
      },
    };
    for (const [name, change] of Object.entries(changes)) {
      const [velocity, omega] = coast(Jolt, change);
      console.log(`${name}, 10 s without a force: velocity ${velocity} after 1 m/s at the start`);
      console.log(`  omega ${omega} rad/s after 0.1, 1, 0`);
    }
  });
