// Replays the motions of several methods beside truth, frame by frame; nothing moves before a reader presses Play, and nothing between frames is made up.
"use strict";
(function () {
  const calm = window.matchMedia("(prefers-reduced-motion: reduce)");
  const dark = window.matchMedia("(prefers-color-scheme: dark)");
  // Frames a second at speed 1, and where the system asks for less motion.
  const PACE = 12;
  const CALM_PACE = 1;
  const STEPS = 32767;
  const POINT = 6;
  // The part of the picture that the largest enlarged error takes, and the room around what moves.
  const ARROW = 0.2;
  const ROOM = 0.12;
  // How far the eye is from the middle of a motion in space, in widths of the picture, and where light comes from: left, above and the reader.
  const EYE = 3;
  const LIGHT = [-0.4, 0.6, 0.7];
  // Lines [px] of a method: a method that lies beneath others is drawn wider, so that all are seen where they agree.
  const LINE = 3;
  const WIDER = 2.5;
  const WIDEST = 12;
  const TRUTH_LINE = 1.2;
  // Parts of a half circle that is drawn as a polygon.
  const PARTS = 24;
  // The shapes of methods, as in the charts, of about a radius of 1.
  const SHAPES = {
    "circle": "M1 0A1 1 0 1 1 -1 0A1 1 0 1 1 1 0Z",
    "square": "M-.9 -.9H.9V.9H-.9Z",
    "triangle-up": "M0 -1L1 .8H-1Z",
    "diamond": "M0 -1.2L.85 0L0 1.2L-.85 0Z",
    "cross": "M-.35 -1H.35V-.35H1V.35H.35V1H-.35V.35H-1V-.35H-.35Z",
    "triangle-down": "M0 1L1 -.8H-1Z",
    "triangle-right": "M1 0L-.8 1V-1Z",
    "triangle-left": "M-1 0L.8 1V-1Z",
  };

  // Vectors of three numbers.
  const dot = function (u, v) { return u[0] * v[0] + u[1] * v[1] + u[2] * v[2]; };
  const plus = function (u, v, factor = 1) { return [u[0] + factor * v[0], u[1] + factor * v[1], u[2] + factor * v[2]]; };
  const times = function (u, factor) { return [u[0] * factor, u[1] * factor, u[2] * factor]; };
  const cross = function (u, v) { return [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]; };
  const length = function (u) { return Math.hypot(u[0], u[1], u[2]); };

  // v turned by the unit quaternion q = (w, x, y, z): v + w s + u x s with s = 2 u x v.
  function turned(q, v) {
    const u = [q[1], q[2], q[3]];
    const s = times(cross(u, v), 2);
    return plus(plus(v, s, q[0]), cross(u, s));
  }

  // v turned by a rotation vector (Rodrigues).
  function turnedBy(turn, v) {
    const angle = length(turn);
    if (angle < 1e-4) return plus(v, cross(turn, v));
    const axis = times(turn, 1 / angle);
    const along = times(axis, dot(axis, v) * (1 - Math.cos(angle)));
    return plus(plus(times(v, Math.cos(angle)), cross(axis, v), Math.sin(angle)), along);
  }

  // The columns of a grid, each a function of the frame; a column that is not there is 0.
  function grid(packed, frames) {
    const bytes = Uint8Array.from(atob(packed.data), function (letter) { return letter.charCodeAt(0); });
    const view = new DataView(bytes.buffer);
    const starts = new Map(packed.columns.map(function (column, index) { return [column, index * frames]; }));
    if (bytes.length !== 2 * frames * packed.columns.length) throw new Error("a grid has " + bytes.length + " bytes");
    return function (frame, column) {
      if (!starts.has(column)) return 0;
      return view.getInt16(2 * (starts.get(column) + frame), true) * packed.scale / STEPS;
    };
  }

  const three = function (get, frame, body) { return [get(frame, 3 * body), get(frame, 3 * body + 1), get(frame, 3 * body + 2)]; };

  const nowhere = function () { return 0; };

  // Truth at every frame, its places and attitudes, and the errors of places and the turns of a track; without one, these are 0.
  function motion(data, track) {
    const frames = data.t.length;
    const place = grid(data.place, frames);
    const turn = grid(data.turn, frames);
    const away = track ? grid(track.place, frames) : nowhere;
    const twist = track ? grid(track.turn, frames) : nowhere;
    return data.t.map(function (_, frame) {
      return data.bodies.map(function (body, number) {
        const q = body.attitude.map(function (start, k) { return start + turn(frame, 4 * number + k); });
        const size = Math.hypot(...q) || 1;
        return {
          place: plus(body.position, three(place, frame, number)),
          attitude: q.map(function (part) { return part / size; }),
          away: three(away, frame, number),
          twist: three(twist, frame, number),
        };
      });
    });
  }

  // Body points whose turns are seen: on the body's axes x and y, at its surface.
  function marks(body) {
    if (body.radius > 0) return [[body.radius, 0, 0], [0, body.radius, 0]];
    if (!body.vertices.length) return [];
    const reach = [0, 1].map(function (axis) { return Math.max(...body.vertices.map(function (v) { return v[axis]; })); });
    return [[reach[0], 0, 0], [0, reach[1], 0]];
  }

  // Where a body and a point of it are: in the run, or in truth, whose errors are 0.
  const centre = function (state) { return plus(state.place, state.away); };
  const reached = function (state, point) { return plus(centre(state), turnedBy(state.twist, turned(state.attitude, point))); };

  // The points whose errors are drawn: the centre, and the marks of what turns.
  function errors(body, state) {
    const found = [{ from: state.place, error: state.away }];
    if (length(state.twist) === 0) return found;
    for (const mark of marks(body)) {
      const arm = turned(state.attitude, mark);
      found.push({ from: plus(state.place, arm), error: plus(plus(state.away, turnedBy(state.twist, arm)), arm, -1) });
    }
    return found;
  }

  // 1, 2 or 5 times a power of ten that is not above a number.
  function roundFactor(number) {
    const power = Math.pow(10, Math.floor(Math.log10(number)));
    const first = [5, 2, 1].find(function (digit) { return digit * power <= number; });
    return (first || 1) * power;
  }

  const said = function (number) {
    if (number === 0) return "0";
    return number >= 1e-3 && number < 1e5 ? String(Number(number.toPrecision(3))) : number.toExponential(1).replace(".0e", "e").replace("e+", "e");
  };

  // The ends (low, high) of discs around points, each given by its place right, up and towards the reader, and how much larger it is there.
  function ends(discs, seen) {
    const low = [Infinity, Infinity, Infinity];
    const high = [-Infinity, -Infinity, -Infinity];
    for (const [point, radius] of discs) {
      const { at, larger } = seen(point);
      at.forEach(function (value, k) {
        low[k] = Math.min(low[k], value - radius * larger);
        high[k] = Math.max(high[k], value + radius * larger);
      });
    }
    return { low: low, high: high, middle: low.map(function (value, k) { return (value + high[k]) / 2; }), size: low.map(function (value, k) { return high[k] - value; }) };
  }

  // The part of space that truth reaches, and how it is seen: in parallel where everything moves in the plane of the picture, else in perspective.
  function sceneOf(data, states) {
    const discs = [];
    for (const row of states) {
      row.forEach(function (state, number) {
        discs.push([state.place, data.bodies[number].radius]);
        for (const vertex of data.bodies[number].vertices) discs.push([reached(state, vertex), 0]);
      });
    }
    for (const link of data.links) {
      if (link.a < 0) discs.push([link.anchor_a, 0]);
      if (link.b < 0) discs.push([link.anchor_b, 0]);
    }
    const flat = function (point) { return { at: data.view.map(function (row) { return dot(row, point); }), larger: 1 }; };
    const whole = ends(discs, flat);
    const widest = Math.max(whole.size[0], whole.size[1]) || 1;
    const isSpatial = !data.view[2].some(function (part) { return Math.abs(part) === 1; });
    const eye = EYE * widest;
    // Lengths at a depth d are E/(E - d) times as large; a run that comes close to the eye, or goes behind it, grows no more.
    const deep = function (point) {
      const { at } = flat(point);
      const larger = eye / Math.max(eye / 4, eye - (at[2] - whole.middle[2]));
      return { at: [whole.middle[0] + larger * (at[0] - whole.middle[0]), whole.middle[1] + larger * (at[1] - whole.middle[1]), at[2]], larger: larger };
    };
    const seen = isSpatial ? deep : flat;
    const { middle, size } = ends(discs, seen);
    return { isSpatial: isSpatial, seen: seen, middle: middle, size: size, widest: Math.max(size[0], size[1]) || 1 };
  }

  // Where bodies of a run touch at a frame, by what it told and by where they are: points and words.
  function contacts(data, list, row, frame, near) {
    const found = [];
    const place = function (number) { return centre(row[number]); };
    for (const [at, number] of list) {
      if (at === frame && row[number]) found.push({ at: place(number), words: "body " + (number + 1) + " has just met something" });
    }
    if (!data.touches) return found;
    data.bodies.forEach(function (body, one) {
      for (let other = one + 1; body.radius > 0 && other < data.bodies.length; other += 1) {
        const apart = plus(place(other), place(one), -1);
        const radius = data.bodies[other].radius;
        if (radius > 0 && length(apart) <= body.radius + radius + near) {
          found.push({ at: plus(place(one), apart, body.radius / (length(apart) || 1)), words: "bodies " + (one + 1) + " and " + (other + 1) + " touch" });
        }
      }
      for (const plane of data.planes) {
        const size = length(plane.normal) || 1;
        const height = function (point) { return dot(plus(point, plane.point, -1), plane.normal) / size; };
        const words = "body " + (one + 1) + " touches the plane";
        if (body.radius > 0 && height(place(one)) <= body.radius + near) found.push({ at: plus(place(one), plane.normal, -body.radius / size), words: words });
        const low = body.is_inertia ? [] : body.vertices.map(function (v) { return reached(row[one], v); }).filter(function (point) { return height(point) <= near; });
        for (const point of low) found.push({ at: point, words: words });
      }
    });
    return found;
  }

  function element(name, properties, ...children) {
    const made = Object.assign(document.createElement(name), properties);
    made.append(...children);
    return made;
  }

  function choice(label, options) {
    const select = element("select", {}, ...options.map(function ([text, value]) { return element("option", { value: String(value), textContent: text }); }));
    return [element("label", {}, label + " ", select), select];
  }

  // The symbol of a method before its name in the legend; that of truth is a filled body.
  function swatch(layer) {
    const made = document.createElementNS("http://www.w3.org/2000/svg", "svg");
    const path = document.createElementNS("http://www.w3.org/2000/svg", "path");
    made.setAttribute("viewBox", "-1.3 -1.3 2.6 2.6");
    made.setAttribute("aria-hidden", "true");
    path.setAttribute("d", SHAPES[layer.shape]);
    path.style.fill = layer.colour || "var(--line)";
    path.style.stroke = layer.colour || "var(--ink)";
    path.style.strokeWidth = "0.2";
    made.append(path);
    return made;
  }

  // Of two colours #rrggbb, the one that has a share of the first.
  function mixed(one, other, share) {
    const parts = [1, 3, 5].map(function (k) {
      const value = parseInt(one.slice(k, k + 2), 16) * share + parseInt(other.slice(k, k + 2), 16) * (1 - share);
      return Math.round(value).toString(16).padStart(2, "0");
    });
    return "#" + parts.join("");
  }

  // What a picture is drawn with: from points in space to the canvas.
  function pen(canvas, data, scene) {
    const context = canvas.getContext("2d");
    const style = getComputedStyle(canvas);
    const ink = {};
    for (const name of ["ink", "quiet", "line", "card"]) ink[name] = style.getPropertyValue("--" + name).trim();
    const ratio = window.devicePixelRatio || 1;
    const width = canvas.clientWidth;
    const height = canvas.clientHeight;
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.lineJoin = "round";
    const inner = 1 - 2 * ROOM;
    const scale = Math.min(width * inner / (scene.size[0] || scene.widest / 10), height * inner / (scene.size[1] || scene.widest / 10));
    const at = function (point) {
      const [right, up] = scene.seen(point).at;
      return [width / 2 + scale * (right - scene.middle[0]), height / 2 - scale * (up - scene.middle[1])];
    };
    const path = function (points, closed) {
      context.beginPath();
      for (const point of points) context.lineTo(...at(point));
      if (closed) context.closePath();
    };
    // The colour of truth where it is lit from 0 to 1: light is nearer to white on both pages.
    const tone = function (lit) { return mixed(ink.ink, ink.card, dark.matches ? 0.05 + 0.2 * lit : 0.36 - 0.3 * lit); };
    return { context, data, scene, scale, at, path, ink, tone };
  }

  // The faces that are seen, as their corners in space.
  function seenFaces(tool, body, state) {
    const corners = body.faces.map(function (face) { return face.map(function (number) { return reached(state, body.vertices[number]); }); });
    return corners.filter(function (face) {
      // A face that looks towards the reader turns counter-clockwise, which is clockwise where y points down.
      const flat = face.map(tool.at);
      const area = flat.reduce(function (sum, point, k) { const next = flat[(k + 1) % flat.length]; return sum + point[0] * next[1] - point[1] * next[0]; }, 0);
      return area < 0;
    });
  }

  // How much light falls on a face, from 0 to 1.
  function lightOn(tool, face) {
    const normal = cross(plus(face[1], face[0], -1), plus(face[2], face[0], -1));
    const facing = dot(tool.data.view.map(function (row) { return dot(row, normal); }), LIGHT);
    return Math.max(0, facing / (length(normal) * length(LIGHT) || 1));
  }

  // A ball or a point on the canvas: a circle.
  function disc(tool, body, state) {
    const [x, y] = tool.at(centre(state));
    const { larger } = tool.scene.seen(centre(state));
    return { x: x, y: y, radius: body.radius > 0 ? Math.max(2, body.radius * tool.scale * larger) : POINT * larger };
  }

  function fillBody(tool, body, state) {
    const context = tool.context;
    if (body.vertices.length) {
      for (const face of seenFaces(tool, body, state)) {
        context.fillStyle = tool.tone(lightOn(tool, face));
        tool.path(face, true);
        context.fill();
      }
      return;
    }
    const { x, y, radius } = disc(tool, body, state);
    context.fillStyle = tool.tone(0.7);
    if (tool.scene.isSpatial) {
      const gradient = context.createRadialGradient(x - 0.35 * radius, y - 0.45 * radius, 0, x, y, radius);
      gradient.addColorStop(0, tool.tone(1));
      gradient.addColorStop(1, tool.tone(0));
      context.fillStyle = gradient;
    }
    context.beginPath();
    context.arc(x, y, radius, 0, 2 * Math.PI);
    context.fill();
  }

  function outlineBody(tool, body, state) {
    if (body.vertices.length) {
      for (const face of seenFaces(tool, body, state)) {
        tool.path(face, true);
        tool.context.stroke();
      }
      return;
    }
    const { x, y, radius } = disc(tool, body, state);
    tool.context.beginPath();
    tool.context.arc(x, y, radius, 0, 2 * Math.PI);
    tool.context.stroke();
  }

  // Lines on a body by which its spin is seen: spokes to its marks; on a ball in space a meridian from pole to pole, and the equator.
  function spinLines(tool, body) {
    if (!(tool.scene.isSpatial && body.radius > 0)) return marks(body).map(function (mark) { return [[0, 0, 0], mark]; });
    const r = body.radius;
    const angles = Array.from({ length: PARTS + 1 }, function (_, k) { return k * Math.PI / PARTS; });
    const meridian = angles.map(function (angle) { return [r * Math.sin(angle), 0, r * Math.cos(angle)]; });
    const equator = angles.map(function (angle) { return [r * Math.cos(2 * angle), r * Math.sin(2 * angle), 0]; });
    return [meridian, equator];
  }

  // Those parts that lie behind the centre are thin.
  function drawSpin(tool, body, state, width) {
    const middle = centre(state);
    tool.context.lineCap = "round";
    for (const line of spinLines(tool, body)) {
      const points = line.map(function (point) { return reached(state, point); });
      for (let k = 1; k < points.length; k += 1) {
        const depth = dot(tool.data.view[2], plus(plus(points[k - 1], points[k]), middle, -2));
        tool.context.lineWidth = depth < -1e-9 * tool.scene.widest ? 0.3 * width : width;
        tool.path([points[k - 1], points[k]], false);
        tool.context.stroke();
      }
    }
    tool.context.lineCap = "butt";
  }

  // From a point of truth to where the run has it, enlarged, with the symbol of the method at its end.
  function drawError(tool, layer, from, vector) {
    const context = tool.context;
    const [x, y] = tool.at(from);
    const [u, v] = tool.at(plus(from, vector));
    if (Math.hypot(u - x, v - y) < 1) return;
    context.lineWidth = 2;
    context.strokeStyle = layer.colour;
    context.fillStyle = layer.colour;
    context.beginPath();
    context.moveTo(x, y);
    context.lineTo(u, v);
    context.stroke();
    context.save();
    context.translate(u, v);
    context.scale(5, 5);
    context.fill(new Path2D(SHAPES[layer.shape]));
    context.restore();
  }

  function drawPlanes(tool) {
    tool.context.strokeStyle = tool.ink.quiet;
    tool.context.lineWidth = 1;
    for (const plane of tool.data.planes) {
      const normal = times(plane.normal, 1 / (length(plane.normal) || 1));
      const least = [0, 1, 2].sort(function (i, j) { return Math.abs(normal[i]) - Math.abs(normal[j]); })[0];
      const across = cross(normal, [0, 1, 2].map(function (k) { return k === least ? 1 : 0; }));
      const one = times(across, tool.scene.widest / length(across));
      const other = cross(normal, one);
      tool.path([[1, 1], [1, -1], [-1, -1], [-1, 1]].map(function ([i, j]) { return plus(plus(plane.point, one, i), other, j); }), true);
      tool.context.stroke();
    }
  }

  // The ends of a link in a run.
  function linkEnds(link, row) {
    const end = function (number, anchor) { return row[number] ? reached(row[number], anchor) : anchor; };
    return [end(link.a, link.anchor_a), end(link.b, link.anchor_b)];
  }

  // The lines of layers, the first of which lie beneath the others; those of truth are the topmost.
  function widths(layers) {
    const methods = layers.filter(function (layer) { return layer.track; });
    const wider = Math.min(WIDER, (WIDEST - LINE) / Math.max(1, methods.length - 1));
    methods.forEach(function (layer, k) { layer.width = LINE + wider * (methods.length - 1 - k); });
  }

  // The links and bodies of a layer, each with the depth at which it is painted: that of truth where the two differ too little to be seen.
  function parts(tool, layer, truth) {
    const { context, data } = tool;
    const { row, width } = layer;
    const depth = function (point, ofTruth) {
      const [own, same] = [point, ofTruth].map(function (p) { return dot(data.view[2], p); });
      return Math.abs(own - same) < 0.02 * tool.scene.widest ? same : own;
    };
    const middle = function (points) { return times(plus(points[0], points[1]), 0.5); };
    const colour = layer.colour || tool.ink.ink;
    const links = data.links.map(function (link) {
      const points = linkEnds(link, row);
      return {
        depth: depth(middle(points), middle(linkEnds(link, truth))),
        paint: function () {
          context.strokeStyle = colour;
          context.lineWidth = width;
          context.setLineDash(link.kind === "rod" || link.kind === "ball_joint" ? [] : [5, 4]);
          tool.path(points, false);
          context.stroke();
          context.setLineDash([]);
        },
      };
    });
    const bodies = data.bodies.map(function (body, number) {
      return {
        depth: depth(centre(row[number]), truth[number].place),
        paint: function (step) {
          context.strokeStyle = colour;
          context.lineWidth = width;
          if (step === "fill") { fillBody(tool, body, row[number]); return; }
          outlineBody(tool, body, row[number]);
          drawSpin(tool, body, row[number], width);
        },
      };
    });
    return { links, bodies };
  }

  // Everything that is painted, what is farther away first; at one depth links come before bodies, and truth is filled beneath the lines of methods and outlined above them.
  function painted(tool, layers, truth) {
    const [ofMethods, ofTruth] = [true, false].map(function (isMethod) {
      return layers.filter(function (layer) { return Boolean(layer.track) === isMethod; }).map(function (layer) { return parts(tool, layer, truth); });
    });
    const all = [];
    for (const { links } of [...ofMethods, ...ofTruth]) all.push(...links);
    tool.data.bodies.forEach(function (_, number) {
      for (const { bodies } of ofTruth) all.push({ depth: bodies[number].depth, paint: function () { bodies[number].paint("fill"); } });
      for (const { bodies } of [...ofMethods, ...ofTruth]) all.push(bodies[number]);
    });
    return all.sort(function (one, other) { return one.depth - other.depth; });
  }

  // The paths of the centres: those of truth to their ends, and those of methods as far as they are shown.
  function drawPaths(tool, layers, frame) {
    const context = tool.context;
    for (const layer of layers) {
      const states = layer.track ? layer.states.slice(0, frame + 1) : layer.states;
      context.strokeStyle = layer.colour || tool.ink.quiet;
      context.globalAlpha = layer.track ? 0.5 : 1;
      context.lineWidth = layer.track ? layer.width / 3 : 1;
      tool.data.bodies.forEach(function (_, number) {
        tool.path(states.map(function (row) { return centre(row[number]); }), false);
        context.stroke();
      });
    }
    context.globalAlpha = 1;
  }

  // Draws a frame; the answer is what touches, each in words with the names of the layers where it does.
  function draw(canvas, shown, layers) {
    const { data, scene, frame, factor } = shown;
    const tool = pen(canvas, data, scene);
    const context = tool.context;
    const truth = shown.truth.states[frame];
    for (const layer of layers) layer.row = layer.states[frame];
    widths(layers);
    drawPlanes(tool);
    drawPaths(tool, layers, frame);
    for (const part of painted(tool, layers, truth)) part.paint();
    for (const layer of layers) {
      layer.row.forEach(function (state, number) {
        for (const one of errors(data.bodies[number], state)) drawError(tool, layer, one.from, times(one.error, factor));
      });
    }
    const touching = new Map();
    for (const layer of layers) {
      context.strokeStyle = layer.colour || tool.ink.ink;
      context.lineWidth = 2;
      for (const contact of contacts(data, layer.contacts, layer.row, frame, 1e-6 * scene.widest)) {
        context.beginPath();
        context.arc(...tool.at(contact.at), 9, 0, 2 * Math.PI);
        context.stroke();
        if (!touching.has(contact.words)) touching.set(contact.words, new Set());
        touching.get(contact.words).add(layer.name);
      }
    }
    return touching;
  }

  // The sentences below the picture: what truth is drawn from, and what is not to scale.
  function explained(data) {
    const from = data.certified.length
      ? "Certified values of " + data.certified.join(", ") + " are drawn as they are; all other coordinates of truth"
      : "No compared quantity is a coordinate of a body. Coordinates of truth";
    const boxed = data.bodies.some(function (body) { return body.is_inertia; }) ? " A body without a shape is drawn as the box that has its inertia." : "";
    return from + " are those of the reference's " + data.anchor + ", whose compared quantities differ from truth by at most " + said(data.anchor_error) +
      " of their scales." + boxed + " Frames are samples of the runs; nothing between them is made up.";
  }

  // Truth and every method, each a layer of the picture that its reader switches.
  function layersOf(data) {
    const truth = { name: "truth", track: null, width: TRUTH_LINE, colour: "", shape: "circle", contacts: data.contacts, states: motion(data, null), isOn: true };
    const methods = data.tracks.map(function (track) {
      return { name: track.engine + " " + track.method, track: track, colour: track.colour, shape: track.shape, contacts: track.contacts, states: null, isOn: false };
    });
    // A method of each engine is shown at first, and one of the reference if it stands alone.
    const others = methods.filter(function (layer) { return !layer.track.is_reference; });
    const engines = new Set();
    for (const layer of others.length ? others : methods) {
      layer.isOn = !engines.has(layer.track.engine);
      engines.add(layer.track.engine);
    }
    return [truth, ...methods];
  }

  // What a legend says of a method at a frame: its distance from truth, if it is shown, the largest one, and what it was run with.
  function toldOf(layer, frame) {
    const track = layer.track;
    const distance = function (metres, radians) { return said(metres) + " m" + (track.largest_turn > 0 ? ", " + said(radians) + " rad" : ""); };
    const largest = distance(track.largest, track.largest_turn);
    const control = { step: "step " + said(track.level) + " s", tolerance: "tolerance " + said(track.level) }[track.control] || "exact";
    const source = control + (track.is_anchor ? "; truth is drawn from it" : "");
    if (!layer.isOn) return ["", largest, source];
    const row = layer.states[frame];
    const away = Math.max(...row.map(function (state) { return length(state.away); }));
    const twist = Math.max(...row.map(function (state) { return length(state.twist); }));
    return [distance(away, twist), largest, source];
  }

  // The legend: a box to tick for each layer, by mouse or keyboard, with its symbol and name, and what is told of it.
  function legendOf(layers, switched) {
    const rows = layers.map(function (layer) {
      const box = element("input", { type: "checkbox", checked: layer.isOn });
      box.addEventListener("change", function () { layer.isOn = box.checked; switched(); });
      layer.cells = ["n", "n", "quiet"].map(function (className) { return element("td", { className: className }); });
      return element("tr", {}, element("th", { scope: "row" }, element("label", {}, box, swatch(layer), " " + layer.name)), ...layer.cells);
    });
    const heads = ["Shown", "Distance from truth", "Largest", "Run with"].map(function (text) { return element("th", { scope: "col", textContent: text }); });
    const table = element("table", {}, element("thead", {}, element("tr", {}, ...heads)), element("tbody", {}, ...rows));
    return element("div", { className: "scroll tracks" }, table);
  }

  function player(place, data) {
    const [speedLabel, speed] = choice("Speed", [["1/4", 0.25], ["1/2", 0.5], ["1", 1], ["2", 2], ["4", 4]]);
    speed.value = "1";
    const play = element("button", { type: "button", textContent: "Play", className: "press" });
    const back = element("button", { type: "button", textContent: "Step back", className: "press" });
    const on = element("button", { type: "button", textContent: "Step on", className: "press" });
    const slider = element("input", { type: "range", min: "0", max: String(data.t.length - 1), step: "1", value: "0" });
    const canvas = element("canvas", {});
    canvas.setAttribute("role", "img");
    const now = element("p", { className: "now" });
    const scale = element("p", { className: "quiet" });
    const layers = layersOf(data);
    const shown = { data: data, truth: layers[0], scene: sceneOf(data, layers[0].states), frame: 0, factor: 0 };
    let timer = null;

    const chosen = function () { return layers.filter(function (layer) { return layer.isOn; }); };

    function redraw() {
      if (canvas.clientWidth === 0) return;
      const visible = chosen();
      const touching = draw(canvas, shown, visible);
      const time = "t = " + said(data.t[shown.frame]) + " s";
      const words = Array.from(touching, function ([contact, names]) {
        const of = names.size < visible.length ? " (" + Array.from(names).join(", ") + ")" : "";
        return " " + contact[0].toUpperCase() + contact.slice(1) + of + ".";
      });
      now.textContent = time + ", frame " + (shown.frame + 1) + " of " + data.t.length + "." + words.join("");
      slider.value = String(shown.frame);
      slider.setAttribute("aria-valuetext", time);
      const distances = [];
      for (const layer of layers.slice(1)) {
        const told = toldOf(layer, shown.frame);
        layer.cells.forEach(function (cell, k) { cell.textContent = told[k]; });
        if (layer.isOn) distances.push(layer.name + " in lines, " + told[0] + " from truth. ");
      }
      canvas.setAttribute("aria-label", (shown.truth.isOn ? "Truth filled. " : "") + distances.join("") + now.textContent);
    }

    function stop() {
      clearTimeout(timer);
      timer = null;
      play.textContent = "Play";
    }

    function go(frame) {
      shown.frame = Math.max(0, Math.min(data.t.length - 1, frame));
      redraw();
    }

    function tick() {
      go(shown.frame + 1);
      if (shown.frame === data.t.length - 1) stop();
      else timer = setTimeout(tick, 1000 / ((calm.matches ? CALM_PACE : PACE) * Number(speed.value)));
    }

    // The largest error of a point that is marked, over all frames of a layer.
    function largestError(layer) {
      const lengths = layer.states.flatMap(function (row) {
        return row.flatMap(function (state, number) { return errors(data.bodies[number], state).map(function (one) { return length(one.error); }); });
      });
      return Math.max(...lengths);
    }

    function choose() {
      const visible = chosen();
      for (const layer of visible) {
        if (!layer.states) layer.states = motion(data, layer.track);
        if (layer.largest === undefined) layer.largest = largestError(layer);
      }
      const largest = Math.max(0, ...visible.map(function (layer) { return layer.largest; }));
      shown.factor = largest > 0 ? roundFactor(ARROW * shown.scene.widest / largest) : 0;
      scale.textContent = "Truth is filled. A method is drawn in lines of its engine's colour, wider where others lie on it, and a contact as a ring. " +
        (shown.factor > 0 ? "Lines that end in a symbol are errors, enlarged by a factor of " + said(shown.factor) + " so that the largest can be seen." : "There is no error to draw.") +
        (calm.matches ? " Your system asks for less motion: Play shows a frame a second." : "");
      redraw();
    }

    play.addEventListener("click", function () {
      if (timer !== null) { stop(); return; }
      if (shown.frame === data.t.length - 1) go(0);
      play.textContent = "Pause";
      timer = setTimeout(tick, 0);
    });
    back.addEventListener("click", function () { stop(); go(shown.frame - 1); });
    on.addEventListener("click", function () { stop(); go(shown.frame + 1); });
    slider.addEventListener("input", function () { stop(); go(Number(slider.value)); });
    dark.addEventListener("change", redraw);
    place.addEventListener("toggle", function () { if (!place.open) stop(); });
    new ResizeObserver(redraw).observe(canvas);
    const [wide, high] = shown.scene.size;
    canvas.style.aspectRatio = String(Math.max(1.2, Math.min(4, (wide || high / 4) / (high || wide / 4 || 1))));
    const controls = element("div", { className: "controls" }, play, back, on, element("label", { className: "time" }, "Time ", slider), speedLabel);
    place.querySelector(".waiting").replaceWith(controls, canvas, now, legendOf(layers, choose), scale, element("p", { className: "quiet", textContent: explained(data) }));
    choose();
    place.dataset.loaded = "yes";
  }

  window.refdemReplay = function (name, data) {
    const place = document.querySelector('details[data-replay="' + CSS.escape(name) + '"]');
    try {
      player(place, data);
    } catch (error) {
      place.append(element("p", { textContent: "This replay cannot be drawn: " + error.message }));
      console.error(error);
    }
  };
})();
