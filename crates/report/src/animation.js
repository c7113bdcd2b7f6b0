// Plays recorded flights: between contacts, position = recorded position + velocity × time, exactly.
// With a drag γ, the time is replaced by (1 − exp(−γ time)) / γ. With gravity, paths are parabolas.
(() => {
  "use strict";
  const DIGITS = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  const LEVELS = 262142;
  // Duration of the animation at speed 1 (seconds).
  const LENGTH = 12;
  // Width of the close view, in units of the size of the molecule that it follows.
  const CLOSE = 7;
  // Of a body that is large in its box, at least.
  const LEAST_CLOSE = 2;
  // More tags have no legend.
  const MOST_TAGS = 12;
  // An impulse is shown for this share of the animation.
  const SHOWN = 0.02;

  const figure = document.currentScript.previousElementSibling;
  const animation = JSON.parse(figure.querySelector("script").textContent);
  const duration = animation.until - animation.from;
  const flights = unpack();

  // The flights of each body in order of time: t, x, y, vx, vy, angle, spin.
  function unpack() {
    const value = new Map([...DIGITS].map((digit, index) => [digit, index]));
    const lists = animation.bodies.map(() => []);
    let at = 0;
    const number = () => {
      const text = animation.flights;
      const sum = 4096 * value.get(text[at]) + 64 * value.get(text[at + 1]) + value.get(text[at + 2]);
      at += 3;
      return sum;
    };
    const positive = (largest) => (number() / LEVELS) * largest;
    const signed = (largest) => ((2 * number()) / LEVELS - 1) * largest;
    while (at < animation.flights.length) {
      const body = number();
      const shape = animation.shapes[animation.bodies[body]];
      const flight = [positive(duration), positive(animation.sides[0]), positive(animation.sides[1])];
      flight.push(signed(animation.fastest), signed(animation.fastest));
      const turns = shape.atoms.length > 1 && !shape.fixed;
      flight.push(turns ? positive(2 * Math.PI) : 0, turns ? signed(animation.fastest_spin) : 0);
      lists[body].push(flight);
    }
    return lists;
  }

  // Index of the flight of a body at a time.
  function flightAt(list, time) {
    let [low, high] = [0, list.length];
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (list[middle][0] <= time) low = middle;
      else high = middle;
    }
    return low;
  }

  const wrap = (x, side) => x - Math.floor(x / side) * side;

  // Shift along x of the next box above at a time, under shear.
  const tiltAt = (time) => {
    const [tilt, speed] = animation.shear || [0, 0];
    return tilt + speed * (time - animation.from);
  };

  // Position in the box, and angle, of a body at a time.
  function stateAt(body, time) {
    const list = flights[body];
    const [t, x, y, vx, vy, angle, spin] = list[flightAt(list, time)];
    const passed = animation.drag ? -Math.expm1(animation.drag * (t - time)) / animation.drag : time - t;
    const [gx, gy] = animation.shapes[animation.bodies[body]].fixed ? [0, 0] : animation.gravity || [0, 0];
    const up = y + vy * passed + 0.5 * gy * passed * passed;
    const rows = Math.floor(up / animation.sides[1]);
    return [
      wrap(x + vx * passed + 0.5 * gx * passed * passed - rows * tiltAt(time), animation.sides[0]),
      wrap(up, animation.sides[1]),
      angle + spin * passed,
    ];
  }

  const reach = animation.shapes.map((shape) => Math.max(...shape.atoms.map(([x, y, r]) => Math.hypot(x, y) + r)));
  // Drawing order: fixed bodies, then the most frequent shapes, then the rare ones.
  const count = animation.shapes.map((_, shape) => animation.bodies.filter((other) => other === shape).length);
  const order = animation.shapes.map((_, shape) => shape);
  order.sort((a, b) => animation.shapes[b].fixed - animation.shapes[a].fixed || count[b] - count[a]);

  function view(label, ratio, windowAt) {
    const block = document.createElement("div");
    const canvas = document.createElement("canvas");
    canvas.setAttribute("role", "img");
    canvas.setAttribute("aria-label", label);
    canvas.style.aspectRatio = ratio;
    const caption = document.createElement("p");
    caption.textContent = label;
    block.append(canvas, caption);
    figure.querySelector(".views").append(block);
    return { canvas, windowAt };
  }

  const [width, height] = animation.sides;
  const part = animation.window || [0, 0, width, height];
  const label = animation.window ? `a part of the box, ${part[2].toPrecision(3)} wide` : "the whole box";
  const views = [view(label, part[2] / part[3], () => part)];
  // Outside a shown part of the box nothing is recorded.
  if (animation.watched !== null && !animation.window) {
    const name = animation.shapes[animation.bodies[animation.watched]].name || "the molecule";
    // A large body is shown with less around it, so that the picture differs from the whole box.
    const across = 2 * reach[animation.bodies[animation.watched]];
    const least = Math.max(LEAST_CLOSE * across, 0.5 * Math.min(width, height));
    const side = Math.min(CLOSE * across, least, width, height);
    views.push(
      view(`${name} in close-up, with each impulse on it as an arrow`, 1, (time) => {
        const [x, y] = stateAt(animation.watched, time);
        return [x - side / 2, y - side / 2, side, side];
      }),
    );
  }

  // Calls f for each shift by whole boxes that moves the interval [low, high] into [from, to].
  function images(low, high, from, to, side, f) {
    for (let k = Math.ceil((from - high) / side); k <= Math.floor((to - low) / side); k++) f(k * side);
  }

  // Adds the closed lines of a body with straight edges to the path. A piece of a line is the first
  // point of a straight part, or an arc: its centre, its radius and the angles of its ends.
  function outline(context, lines, [x, y], angle) {
    const [cos, sin] = [Math.cos(angle), Math.sin(angle)];
    const place = ([px, py]) => [x + cos * px - sin * py, y + sin * px + cos * py];
    for (const line of lines) {
      line.forEach((piece, index) => {
        const [px, py] = place(piece);
        const [, , r, start, end] = piece;
        if (piece.length === 2) context[index ? "lineTo" : "moveTo"](px, py);
        else {
          if (!index) context.moveTo(px + r * Math.cos(start + angle), py + r * Math.sin(start + angle));
          context.arc(px, py, r, start + angle, end + angle);
        }
      });
      context.closePath();
    }
  }

  function draw({ canvas, windowAt }, time, states) {
    const pixels = Math.max(1, Math.round(canvas.clientWidth * (window.devicePixelRatio || 1)));
    const [left, bottom, wide, high] = windowAt(time);
    const scale = pixels / wide;
    const rows = Math.max(1, Math.round(high * scale));
    if (canvas.width !== pixels || canvas.height !== rows) {
      canvas.width = pixels;
      canvas.height = rows;
    }
    const context = canvas.getContext("2d");
    const style = getComputedStyle(figure);
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.fillStyle = style.backgroundColor;
    context.fillRect(0, 0, canvas.width, canvas.height);
    // y points upwards; units of length.
    context.setTransform(scale, 0, 0, -scale, -left * scale, canvas.height + bottom * scale);
    const around = (x, y, r, f) =>
      images(y - r, y + r, bottom, bottom + high, height, (dy) => {
        const aside = (dy / height) * tiltAt(time);
        images(x + aside - r, x + aside + r, left, left + wide, width, (dx) => f(aside + dx, dy));
      });
    for (const shape of order) {
      const { atoms, lines, colour } = animation.shapes[shape];
      context.beginPath();
      animation.bodies.forEach((own, body) => {
        if (own !== shape) return;
        const [x, y, angle] = states[body];
        const [cos, sin] = [Math.cos(angle), Math.sin(angle)];
        around(x, y, reach[shape], (dx, dy) => {
          if (lines) return outline(context, lines, [x + dx, y + dy], angle);
          for (const [ax, ay, r] of atoms) {
            const [cx, cy] = [x + dx + cos * ax - sin * ay, y + dy + sin * ax + cos * ay];
            context.moveTo(cx + r, cy);
            context.arc(cx, cy, r, 0, 2 * Math.PI);
          }
        });
      });
      context.strokeStyle = style.color;
      context.lineWidth = Math.min(1.8 / scale, 0.12 * reach[shape]);
      context.stroke();
      context.fillStyle = colour;
      context.fill();
    }
    context.lineCap = "round";
    for (const [[a, b], [ax, ay, bx, by]] of animation.bonds || []) {
      const end = ([x, y, angle], px, py) => {
        const [cos, sin] = [Math.cos(angle), Math.sin(angle)];
        return [x + cos * px - sin * py, y + sin * px + cos * py];
      };
      const [x1, y1] = end(states[a], ax, ay);
      const [x2, y2] = end(states[b], bx, by);
      const [across, up] = [x2 - x1, y2 - y1];
      const [dx, dy] = [across - width * Math.round(across / width), up - height * Math.round(up / height)];
      context.strokeStyle = style.color;
      context.lineWidth = 1.8 / scale;
      around(x1 + dx / 2, y1 + dy / 2, Math.hypot(dx, dy) / 2, (aside, above) => {
        context.beginPath();
        context.moveTo(x1 + aside, y1 + above);
        context.lineTo(x1 + dx + aside, y1 + dy + above);
        context.stroke();
      });
    }
    for (const [index, wall] of animation.walls.entries()) {
      const path = (animation.wall_paths || []).find((one) => one.wall === index);
      const [x1, y1, x2, y2, r] = path ? [...endsAt(path.ends, time), wall[4]] : wallAt(wall, time);
      const [x, y] = [(x1 + x2) / 2, (y1 + y2) / 2];
      context.strokeStyle = style.color;
      context.lineWidth = Math.max(2 * r, 2.5 / scale);
      around(x, y, Math.hypot(x2 - x1, y2 - y1) / 2 + r, (dx, dy) => {
        context.beginPath();
        context.moveTo(x1 + dx, y1 + dy);
        context.lineTo(x2 + dx, y2 + dy);
        context.stroke();
      });
    }
    if (animation.watched !== null && wide < width) arrows(context, scale, time, states);
  }

  // The ends of a wall after a time, between the places at equidistant times.
  function endsAt(ends, after) {
    const place = Math.min(Math.max(after / duration, 0), 1) * (ends.length - 1);
    const before = Math.min(Math.floor(place), ends.length - 2);
    return ends[before].map((from, index) => from + (place - before) * (ends[before + 1][index] - from));
  }

  // The ends of a wall after a time, at rest or by amplitude, angular frequency and phase.
  function wallAt([x1, y1, x2, y2, r, ax, ay, frequency, phase], after) {
    if (ax === undefined) return [x1, y1, x2, y2, r];
    const moved = Math.sin(frequency * after + phase) - Math.sin(phase);
    return [x1 + ax * moved, y1 + ay * moved, x2 + ax * moved, y2 + ay * moved, r];
  }

  // Latest impulses on the observed body, drawn from its centre; the length is the change of velocity.
  function arrows(context, scale, time, states) {
    const [x, y] = states[animation.watched];
    const list = flights[animation.watched];
    for (let index = flightAt(list, time); index > 0; index--) {
      const age = (time - list[index][0]) / (SHOWN * duration);
      if (age > 1) break;
      const [dx, dy] = [3, 4].map((axis) => list[index][axis] - list[index - 1][axis]);
      const change = Math.hypot(dx, dy);
      if (change === 0) continue;
      const own = reach[animation.bodies[animation.watched]];
      const long = own * (1 + (4 * change) / animation.fastest);
      const [ux, uy] = [dx / change, dy / change];
      const tip = [x + ux * long, y + uy * long];
      const barb = 0.35 * own;
      context.globalAlpha = 1 - age;
      context.strokeStyle = getComputedStyle(figure).color;
      context.lineWidth = 3 / scale;
      context.beginPath();
      context.moveTo(x, y);
      context.lineTo(...tip);
      for (const turn of [1, -1]) {
        context.moveTo(...tip);
        context.lineTo(tip[0] - barb * (ux + turn * 0.6 * uy), tip[1] - barb * (uy - turn * 0.6 * ux));
      }
      context.stroke();
    }
    context.globalAlpha = 1;
  }

  const make = (tag, properties) => Object.assign(document.createElement(tag), properties);
  const button = make("button", { type: "button", textContent: "Play" });
  const slider = make("input", { type: "range", min: 0, max: 10000, value: 0 });
  slider.setAttribute("aria-label", "time");
  const speed = make("select", {});
  speed.setAttribute("aria-label", "speed");
  for (const factor of [0.1, 0.25, 0.5, 1, 2]) {
    speed.append(make("option", { value: factor, textContent: `${factor} ×`, selected: factor === 1 }));
  }
  const clock = make("output", {});
  figure.querySelector(".controls").append(button, slider, speed, clock);

  // The colour of each tag; many sizes of one tag have one.
  const tags = new Map(animation.shapes.filter(({ name }) => name).map(({ name, colour }) => [name, colour]));
  if (tags.size > 0 && tags.size <= MOST_TAGS) {
    const legend = make("p", { className: "legend" });
    for (const [name, colour] of tags) {
      const mark = make("span", { textContent: "●" });
      mark.style.color = colour;
      legend.append(mark, ` ${name}\u2003`);
    }
    figure.append(legend);
  }

  let time = 0;
  let playing = false;
  let last = null;
  const digits = Math.max(0, Math.min(12, 3 - Math.floor(Math.log10(duration))));

  function show() {
    const states = animation.bodies.map((_, body) => stateAt(body, time));
    for (const each of views) draw(each, time, states);
    slider.value = (10000 * time) / duration;
    clock.textContent = `t = ${(animation.from + time).toFixed(digits)}`;
  }

  function frame(now) {
    if (!playing) return;
    if (last !== null) time += (duration * Number(speed.value) * (now - last)) / (1000 * LENGTH);
    last = now;
    // After the end, playing restarts from the beginning.
    if (time > duration) time = 0;
    show();
    requestAnimationFrame(frame);
  }

  button.addEventListener("click", () => {
    playing = !playing;
    button.textContent = playing ? "Pause" : "Play";
    last = null;
    if (playing) requestAnimationFrame(frame);
  });
  slider.addEventListener("input", () => {
    time = (duration * Number(slider.value)) / 10000;
    show();
  });
  // The page has its final width only after all of it is loaded.
  new ResizeObserver(show).observe(figure);
  window.addEventListener("themechange", show);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", show);
  show();
})();
