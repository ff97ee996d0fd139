// Replays a motion beside truth, frame by frame; nothing moves before a reader presses Play, and nothing between frames is made up.
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
  let players = 0;

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

  // Truth and one track at every frame: place and attitude of truth, error of place and turn of the track.
  function motion(data, track) {
    const frames = data.t.length;
    const place = grid(data.place, frames);
    const turn = grid(data.turn, frames);
    const away = grid(track.place, frames);
    const twist = grid(track.turn, frames);
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

  // Where a body point is, in truth and in the track.
  const ofTruth = function (state, point) { return plus(state.place, turned(state.attitude, point)); };
  const ofTrack = function (state, point) { return plus(plus(state.place, state.away), turnedBy(state.twist, turned(state.attitude, point))); };

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

  // The ends of the picture in the plane of the view, around everything that truth reaches.
  function frameOf(data, states) {
    const low = [Infinity, Infinity];
    const high = [-Infinity, -Infinity];
    const reach = function (point, radius) {
      for (const k of [0, 1]) {
        const at = dot(data.view[k], point);
        low[k] = Math.min(low[k], at - radius);
        high[k] = Math.max(high[k], at + radius);
      }
    };
    for (const row of states) {
      row.forEach(function (state, number) {
        reach(state.place, data.bodies[number].radius);
        for (const vertex of data.bodies[number].vertices) reach(ofTruth(state, vertex), 0);
      });
    }
    for (const link of data.links) {
      if (link.a < 0) reach(link.anchor_a, 0);
      if (link.b < 0) reach(link.anchor_b, 0);
    }
    const widest = Math.max(high[0] - low[0], high[1] - low[1]) || 1;
    return { middle: [(low[0] + high[0]) / 2, (low[1] + high[1]) / 2], size: [high[0] - low[0], high[1] - low[1]], widest: widest };
  }

  // Where bodies of the track touch at a frame: points and words.
  function contacts(data, track, row, frame, near) {
    const found = [];
    const place = function (number) { return plus(row[number].place, row[number].away); };
    const told = function (list) {
      for (const [at, number] of list) {
        if (at === frame && row[number]) found.push({ at: place(number), words: "body " + (number + 1) + " has just met something" });
      }
    };
    told(track.contacts);
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
        const low = body.is_inertia ? [] : body.vertices.map(function (v) { return ofTrack(row[one], v); }).filter(function (point) { return height(point) <= near; });
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

  // What a picture is drawn with: from points in space to the canvas.
  function pen(canvas, data, extent) {
    const context = canvas.getContext("2d");
    const ratio = window.devicePixelRatio || 1;
    const width = canvas.clientWidth;
    const height = canvas.clientHeight;
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    const inner = 1 - 2 * ROOM;
    const scale = Math.min(width * inner / (extent.size[0] || extent.widest / 10), height * inner / (extent.size[1] || extent.widest / 10));
    const at = function (point) {
      return [width / 2 + scale * (dot(data.view[0], point) - extent.middle[0]), height / 2 - scale * (dot(data.view[1], point) - extent.middle[1])];
    };
    const path = function (points, closed) {
      context.beginPath();
      for (const point of points) context.lineTo(...at(point));
      if (closed) context.closePath();
    };
    return { context, scale, at, path, width, height };
  }

  function drawBody(tool, body, where, isTruth) {
    const context = tool.context;
    if (body.vertices.length) {
      for (const face of body.faces) {
        const corners = face.map(function (number) { return where(body.vertices[number]); });
        // A face that looks towards the reader turns counter-clockwise, which is clockwise where y points down.
        const flat = corners.map(tool.at);
        const area = flat.reduce(function (sum, point, k) { const next = flat[(k + 1) % flat.length]; return sum + point[0] * next[1] - point[1] * next[0]; }, 0);
        if (area >= 0) continue;
        tool.path(corners, true);
        if (isTruth) context.stroke(); else context.fill();
      }
    } else {
      context.beginPath();
      context.arc(...tool.at(where([0, 0, 0])), body.radius > 0 ? Math.max(2, body.radius * tool.scale) : POINT, 0, 2 * Math.PI);
      if (isTruth) context.stroke(); else context.fill();
    }
  }

  // Spokes to the marks; those behind the body are thin.
  function drawMarks(tool, data, body, where) {
    const centre = where([0, 0, 0]);
    for (const mark of marks(body)) {
      const tip = where(mark);
      tool.context.lineWidth = dot(data.view[2], plus(tip, centre, -1)) < -1e-9 ? 0.6 : 1.8;
      tool.path([centre, tip], false);
      tool.context.stroke();
    }
  }

  function drawArrow(tool, from, vector) {
    const [x, y] = tool.at(from);
    const [u, v] = tool.at(plus(from, vector));
    const size = Math.hypot(u - x, v - y);
    if (size < 1) return;
    const head = Math.min(8, size / 2);
    const angle = Math.atan2(v - y, u - x);
    tool.context.beginPath();
    tool.context.moveTo(x, y);
    tool.context.lineTo(u, v);
    for (const side of [-0.45, 0.45]) {
      tool.context.moveTo(u, v);
      tool.context.lineTo(u - head * Math.cos(angle + side), v - head * Math.sin(angle + side));
    }
    tool.context.stroke();
  }

  function drawScenery(tool, data, extent, ink) {
    const context = tool.context;
    context.strokeStyle = ink.quiet;
    context.lineWidth = 1;
    for (const plane of data.planes) {
      const normal = times(plane.normal, 1 / (length(plane.normal) || 1));
      const least = [0, 1, 2].sort(function (i, j) { return Math.abs(normal[i]) - Math.abs(normal[j]); })[0];
      const across = cross(normal, [0, 1, 2].map(function (k) { return k === least ? 1 : 0; }));
      const one = times(across, extent.widest / length(across));
      const other = cross(normal, one);
      tool.path([[1, 1], [1, -1], [-1, -1], [-1, 1]].map(function ([i, j]) { return plus(plus(plane.point, one, i), other, j); }), true);
      context.stroke();
    }
  }

  function drawLinks(tool, data, row, where) {
    for (const link of data.links) {
      const end = function (number, anchor) { return row[number] ? where(row[number], anchor) : anchor; };
      tool.context.setLineDash(link.kind === "rod" || link.kind === "ball_joint" ? [] : [5, 4]);
      tool.path([end(link.a, link.anchor_a), end(link.b, link.anchor_b)], false);
      tool.context.stroke();
    }
    tool.context.setLineDash([]);
  }

  function draw(canvas, shown) {
    const { data, track, states, extent, frame, factor } = shown;
    const style = getComputedStyle(canvas);
    const ink = {};
    for (const name of ["ink", "quiet", "line", "fail", "lost"]) ink[name] = style.getPropertyValue("--" + name).trim();
    const tool = pen(canvas, data, extent);
    const context = tool.context;
    const row = states[frame];
    drawScenery(tool, data, extent, ink);
    // The paths of truth.
    context.strokeStyle = ink.line;
    context.lineWidth = 1;
    data.bodies.forEach(function (_, number) {
      tool.path(states.map(function (all) { return all[number].place; }), false);
      context.stroke();
    });
    context.strokeStyle = track.colour;
    context.lineWidth = 2;
    drawLinks(tool, data, row, ofTrack);
    // What is farther away comes first.
    const order = row.map(function (_, number) { return number; });
    order.sort(function (one, other) { return dot(data.view[2], row[one].place) - dot(data.view[2], row[other].place); });
    for (const number of order) {
      const body = data.bodies[number];
      const inTrack = function (point) { return ofTrack(row[number], point); };
      const inTruth = function (point) { return ofTruth(row[number], point); };
      context.globalAlpha = 0.55;
      context.fillStyle = track.colour;
      drawBody(tool, body, inTrack, false);
      context.globalAlpha = 1;
      context.strokeStyle = track.colour;
      drawMarks(tool, data, body, inTrack);
      context.strokeStyle = ink.ink;
      context.lineWidth = 1.4;
      drawBody(tool, body, inTruth, true);
      drawMarks(tool, data, body, inTruth);
    }
    context.strokeStyle = ink.ink;
    context.lineWidth = 1;
    drawLinks(tool, data, row, ofTruth);
    context.strokeStyle = ink.fail;
    context.lineWidth = 2;
    row.forEach(function (state, number) {
      for (const one of errors(data.bodies[number], state)) drawArrow(tool, one.from, times(one.error, factor));
    });
    const touching = contacts(data, track, row, frame, 1e-6 * extent.widest);
    context.strokeStyle = ink.lost;
    for (const contact of touching) {
      context.beginPath();
      context.arc(...tool.at(contact.at), 9, 0, 2 * Math.PI);
      context.stroke();
    }
    return Array.from(new Set(touching.map(function (contact) { return contact.words; })));
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

  function player(place, data) {
    players += 1;
    const [methodLabel, method] = choice("Method", data.tracks.map(function (track, number) { return [track.engine + " " + track.method, number]; }));
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
    const shown = { data: data, frame: 0, factor: 0 };
    let timer = null;

    function redraw() {
      if (canvas.clientWidth === 0) return;
      const touching = draw(canvas, shown);
      const row = shown.states[shown.frame];
      const away = Math.max(...row.map(function (state) { return length(state.away); }));
      const twist = Math.max(...row.map(function (state) { return length(state.twist); }));
      const turning = shown.track.largest_turn > 0 ? ", " + said(twist) + " rad (largest " + said(shown.track.largest_turn) + " rad)" : "";
      const time = "t = " + said(data.t[shown.frame]) + " s";
      now.textContent = time + ", frame " + (shown.frame + 1) + " of " + data.t.length + ". Distance from truth " + said(away) + " m (largest " + said(shown.track.largest) + " m)" + turning + "." +
        touching.map(function (words) { return " " + words[0].toUpperCase() + words.slice(1) + "."; }).join("");
      slider.value = String(shown.frame);
      slider.setAttribute("aria-valuetext", time);
      canvas.setAttribute("aria-label", "Truth as outlines and " + shown.track.engine + " " + shown.track.method + " filled. " + now.textContent);
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

    function choose() {
      shown.track = data.tracks[Number(method.value)];
      shown.states = motion(data, shown.track);
      shown.extent = frameOf(data, shown.states);
      const largest = Math.max(...shown.states.flatMap(function (row) {
        return row.flatMap(function (state, number) { return errors(data.bodies[number], state).map(function (one) { return length(one.error); }); });
      }));
      shown.factor = largest > 0 ? roundFactor(ARROW * shown.extent.widest / largest) : 0;
      const control = { step: "Largest step that ran: " + said(shown.track.level) + " s. ", tolerance: "Largest tolerance that ran: " + said(shown.track.level) + ". " }[shown.track.control] || "An exact method. ";
      scale.textContent = control + "Outline: truth. Filled: the engine. Ring: a contact. " +
        (shown.factor > 0 ? "Red arrows: errors, enlarged by a factor of " + said(shown.factor) + "." : shown.track.is_anchor ? "Truth is drawn from this very run, so that no error is seen." : "There is no error to draw.") +
        (calm.matches ? " Your system asks for less motion: Play shows a frame a second." : "");
      const [wide, high] = shown.extent.size;
      canvas.style.aspectRatio = String(Math.max(1.2, Math.min(4, (wide || high / 4) / (high || wide / 4 || 1))));
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
    method.addEventListener("change", choose);
    dark.addEventListener("change", redraw);
    place.addEventListener("toggle", function () { if (!place.open) stop(); });
    new ResizeObserver(redraw).observe(canvas);
    const controls = element("div", { className: "controls" }, methodLabel, play, back, on, element("label", { className: "time" }, "Time ", slider), speedLabel);
    place.querySelector(".waiting").replaceWith(controls, canvas, now, scale, element("p", { className: "quiet", textContent: explained(data) }));
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
