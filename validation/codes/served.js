// What the drivers in JavaScript share: requests as lines, what a scene says, and trajectories; what
// served.py is for those in Python.
//
// Require it before the code: what the code prints then goes to standard error.
"use strict";
const fs = require("fs");
const readline = require("readline");

const COLUMNS = "t,body,x,y,z,vx,vy,vz,qw,qx,qy,qz,wx,wy,wz";
const NOT_SUPPORTED = 77;
const STANDARD_OUTPUT = 1;
const AXES = [0, 1, 2];

/** The code cannot run this scene; the message says why. */
class Unsupported extends Error {}

/** Throws Unsupported if the code cannot say what the scene says. */
function cannot(condition, why) {
  if (condition) throw new Unsupported(why);
}

// Standard output is for answers alone.
console.log = console.error;
console.info = console.error;

/** One line of answer. */
function say(words) {
  fs.writeSync(STANDARD_OUTPUT, JSON.stringify(words) + "\n");
}

/** A request, as drivers read it: the same names and units as in served.py. */
class Scene {
  constructor(request, known) {
    this.bodies = request.scene.bodies;
    this.elements = request.scene.elements;
    this.times = request.times;
    this.method = request.method;
    this.step = request.step;
    this.stride = request.stride;
    this.rows = [COLUMNS];
    for (const element of this.elements) {
      cannot(!known.includes(element.kind), `element ${element.kind}`);
    }
    cannot(
      this.bodies.some((body) => body.fixed),
      "fixed bodies",
    );
    const fields = this.ofKind("uniform_gravity");
    this.gravity = AXES.map((axis) => fields.reduce((sum, field) => sum + field.g[axis], 0));
  }

  /** The elements of one kind. */
  ofKind(kind) {
    return this.elements.filter((element) => element.kind === kind);
  }

  /** The rigid contact law, or undefined; throws Unsupported for another. */
  rigidContact() {
    const laws = this.ofKind("contact");
    cannot(
      laws.some((law) => law.law !== "rigid"),
      "contact laws other than the rigid one",
    );
    cannot(
      laws.some((law) => law.tangential_restitution),
      "a tangential restitution",
    );
    return laws[0];
  }

  /**
   * Steps by `advance()`, `stride` of them from sample to sample, and keeps the rows of all bodies
   * at each: numbers of position, velocity, attitude (w first) and omega from `states()`.
   */
  sampled(advance, states) {
    this.times.forEach((t, sample) => {
      for (let step = 0; sample > 0 && step < this.stride; step++) advance();
      states().forEach((state, number) => {
        // A number as text has all of its digits.
        this.rows.push([t, number, ...state].join(","));
      });
    });
  }
}

/** The principal moments of inertia (3) [kg m^2]; those of a point become `least`. */
function moments(body, least) {
  return body.inertia.map((moment) => moment || least);
}

/** The half sides (3) [m] of a polyhedron that is a box along the axes of its body. */
function halfSides(shape) {
  const half = AXES.map((axis) => Math.max(...shape.vertices.map((corner) => corner[axis])));
  const seen = new Set(shape.vertices.map((corner) => corner.map(Math.sign).join()));
  const isCorner = (corner) => AXES.every((axis) => Math.abs(corner[axis]) === half[axis]);
  const isBox = seen.size === 8 && shape.vertices.every(isCorner);
  cannot(!isBox, "polyhedra other than boxes about their centre");
  return half;
}

/** One run; throws Unsupported. */
function answer(solve, known, request, trajectory) {
  const scene = new Scene(JSON.parse(fs.readFileSync(request, "utf8")), known);
  solve(scene);
  fs.writeFileSync(trajectory, scene.rows.join("\n") + "\n");
}

/** What became of a request that came as a line. */
function outcome(solve, known, asked) {
  try {
    answer(solve, known, asked.request, asked.trajectory);
    return { done: true };
  } catch (error) {
    if (error instanceof Unsupported) return { unsupported: error.message };
    return { failed: String(error) };
  }
}

/**
 * Answers requests until standard input ends, or the one request of the command line.
 *
 * `solve(scene)` fills `scene.rows`; scenes with elements of kinds other than `known` are refused.
 */
function run(solve, ...known) {
  const files = process.argv.slice(2);
  if (files.length === 2) {
    try {
      answer(solve, known, ...files);
    } catch (error) {
      if (!(error instanceof Unsupported)) throw error;
      console.error(error.message);
      process.exitCode = NOT_SUPPORTED;
    }
    return;
  }
  say({ ready: true });
  readline.createInterface({ input: process.stdin }).on("line", (line) => {
    const asked = JSON.parse(line);
    say({ id: asked.id, ...outcome(solve, known, asked) });
  });
}

module.exports = { cannot, halfSides, moments, run };
