// The map onto a canvas, a piece at a time: a generator that can be put off and taken up again.

/** Pixels per metre from which on things are drawn. Below COARSE a lane is thinner than a pixel. */
const COARSE = 0.4;
const MIDDLE = 1.6;
const FINE = 3.2;
/** A zebra's stripe in metres. */
const STRIPE = 0.5;
/** Primitives drawn between two looks at the clock. */
const BATCH = 400;

/** How many things lie below: what is higher is drawn later, and chosen first. */
const levelOf = (map, kind, number) => map[kind].level?.[number] ?? 0;

/** Paints what is in `items` to `context`; `frame` has scale (device pixels per metre) and the world's x, y at pixel 0, 0. */
function* paint(context, frame, items, map, classes, colours) {
  const pen = new Pen(context, frame, map);
  const byKind = { lanelet: [], line: [], polygon: [] };
  for (const item of items) {
    const [kind, number] = state.index.itemOf(item);
    byKind[kind].push(number);
  }
  // Order in the file, so that neighbouring tiles overlap things alike.
  for (const numbers of Object.values(byKind)) numbers.sort((a, b) => a - b);
  const lanelets = byKind.lanelet.map((number) => ({ number, ...classes.lanelet[map.lanelet.tags[number]] }));
  if (frame.css < COARSE) {
    yield* coarse(pen, lanelets, colours);
    return;
  }
  const polygons = byKind.polygon.map((number) => ({ number, colour: classes.polygon[map.polygon.tags[number]] }));
  // A tunnel, with all that lies in it, before the street above it.
  const levels = new Set(Object.entries(byKind).flatMap(([kind, numbers]) => numbers.map((number) => levelOf(map, kind, number))));
  for (const level of [...levels].sort((a, b) => a - b)) {
    const here = (kind) => ({ number }) => levelOf(map, kind, number) === level;
    const lines = byKind.line.filter((number) => levelOf(map, 'line', number) === level);
    yield* paintLevel(pen, lanelets.filter(here('lanelet')), polygons.filter(here('polygon')), lines, classes, colours);
  }
}

/** All that lies on one level. */
function* paintLevel(pen, lanelets, polygons, lines, classes, colours) {
  const { context, frame } = pen;
  for (const p of polygons) if (p.colour !== 'box') pen.fillPolygon(p.number, colours[p.colour]);
  for (const surface of ['unknown', 'walk', 'shoulder', 'bicycle', 'road']) {
    yield* surfaces(pen, lanelets.filter((l) => l.surface === surface), colours[surface], frame.css >= MIDDLE && colours.seam);
  }
  const intersections = polygons.filter((p) => p.colour === 'box');
  for (const p of intersections) pen.fillPolygon(p.number, colours.box, colours.boxEdge);
  if (intersections.length) islands(pen, lines, intersections.map((p) => boxOf(pen.map, 'polygon', p.number)), classes, colours);
  yield;
  const turns = lanelets.filter((l) => l.turn);
  context.globalAlpha = 0.28;
  for (let i = 0; i < turns.length; i++) {
    pen.begin();
    pen.outline(turns[i].number);
    pen.fill(colours[turns[i].turn]);
    if (i % BATCH === BATCH - 1) { context.globalAlpha = 1; yield; context.globalAlpha = 0.28; }
  }
  context.globalAlpha = 1;
  const crossings = lanelets.filter((l) => l.surface === 'crossing');
  yield* surfaces(pen, crossings, colours.crossing, null);
  if (frame.css >= MIDDLE) for (const l of crossings) zebra(pen, l.number, colours.zebra);
  yield;
  yield* markings(pen, lines, classes, colours);
  if (frame.css >= FINE) {
    yield* arrows(pen, lanelets, colours);
    signals(pen, lines, classes, colours);
  }
}

/** Ground within a closed kerb in an intersection; `boxes` are those around the intersections. */
function islands(pen, lines, boxes, classes, colours) {
  const { line, x, y } = pen.map;
  for (const number of lines) {
    const points = line.points.subarray(line.start[number], line.start[number + 1]);
    if (points.length < 4 || points[0] !== points[points.length - 1] || classes.line[line.tags[number]].name !== 'kerb') continue;
    const [px, py] = [x[points[0]], y[points[0]]];
    if (!boxes.some((box) => box && px >= box[0] && py >= box[1] && px <= box[2] && py <= box[3])) continue;
    pen.begin();
    pen.trace(points);
    pen.fill(colours.ground);
  }
}

/** From far away: one stroke along each lane. */
function* coarse(pen, lanelets, colours) {
  const width = Math.max(3 * pen.frame.scale, 0.9);
  for (const surface of ['walk', 'shoulder', 'bicycle', 'unknown', 'crossing', 'road']) {
    const some = lanelets.filter((l) => l.surface === surface);
    for (let i = 0; i < some.length; i += BATCH) {
      pen.begin();
      for (const l of some.slice(i, i + BATCH)) pen.middle(l.number);
      pen.stroke(colours[surface], surface === 'road' ? width : width * 0.6);
      yield;
    }
  }
}

function* surfaces(pen, lanelets, fill, seam) {
  for (let i = 0; i < lanelets.length; i += BATCH) {
    pen.begin();
    for (const l of lanelets.slice(i, i + BATCH)) pen.outline(l.number);
    pen.fill(fill);
    if (seam) pen.stroke(seam, 1);
    yield;
  }
}

/** Lines by class, stop lines last. */
function* markings(pen, lines, classes, colours) {
  const { map, frame } = pen;
  const groups = new Map();
  for (const number of lines) {
    const look = classes.line[map.line.tags[number]];
    if (look.signal || (look.fine && frame.css < FINE) || (!look.coarse && frame.css < MIDDLE * 0.6)) continue;
    if (!groups.has(look.name)) groups.set(look.name, { look, numbers: [] });
    groups.get(look.name).numbers.push(number);
  }
  const ordered = [...groups.values()].sort((a, b) => Boolean(a.look.over) - Boolean(b.look.over) || (a.look.name < b.look.name ? -1 : 1));
  for (const { look, numbers } of ordered) {
    const width = Math.max(look.width * frame.scale, look.least * frame.ratio);
    const sides = look.double ? [PAINT.apart, -PAINT.apart] : [0];
    for (let i = 0; i < numbers.length; i += BATCH) {
      sides.forEach((side, at) => {
        const dash = look.double ? look.double[at] : look.dash;
        const offset = side ? Math.sign(side) * Math.max(PAINT.apart * frame.scale, 0.9 * frame.ratio) : 0;
        pen.begin();
        for (const number of numbers.slice(i, i + BATCH)) pen.line(number, offset);
        pen.stroke(colours[look.colour], width, dash && dash.map((m) => Math.max(m * frame.scale, 2 * frame.ratio)));
      });
      yield;
    }
  }
}

/** Stripes from bound to bound. */
function zebra(pen, lanelet, colour) {
  const left = pen.resample(boundPoints(pen.map, lanelet, 'left'), STRIPE);
  if (left.length < 2) return;
  const right = pen.resample(boundPoints(pen.map, lanelet, 'right'), STRIPE, left.length - 1);
  pen.begin();
  for (let i = 0; i + 1 < left.length && i + 1 < right.length; i += 2) pen.ring([left[i], left[i + 1], right[i + 1], right[i]]);
  pen.fill(colour);
}

/** Where traffic goes: the path of a turn, small tips on a plain lane. */
function* arrows(pen, lanelets, colours) {
  const { scale, ratio } = pen.frame;
  const size = Math.min(Math.max(scale * 0.5, 2.5 * ratio), 11 * ratio);
  let drawn = 0;
  for (const { number, surface, turn } of lanelets) {
    if (surface !== 'road' && surface !== 'bicycle') continue;
    const centre = pen.centre(number);
    if (centre.length < 2) continue;
    const colour = turn ? colours[turn] : colours.arrow;
    if (turn) {
      pen.begin();
      pen.path(centre);
      pen.stroke(colour, Math.max(0.12 * scale, ratio));
    }
    const length = lengthOf(centre);
    // Off the middle, where all paths of an intersection cross.
    const count = Math.min(Math.max(Math.round(length / 25), 1), 400);
    const stations = turn ? [length * 0.8] : Array.from({ length: count }, (_, i) => (length * (i + 0.5)) / count);
    for (const station of stations) pen.tip(centre, station, size, colour);
    if (++drawn % BATCH === 0) yield;
  }
}

/** Lights with their bulbs, and signs. */
function signals(pen, lines, classes, colours) {
  const { map, frame } = pen;
  const wide = Math.max(0.35 * frame.scale, 2.4 * frame.ratio);
  for (const kind of ['light', 'sign', 'bulbs']) {
    for (const number of lines) {
      if (classes.line[map.line.tags[number]].signal !== kind) continue;
      if (kind !== 'bulbs') {
        pen.begin();
        pen.line(number, 0);
        pen.stroke(kind === 'light' ? colours.lamp : colours.sign, kind === 'light' ? wide * 1.25 : wide, null, 'round');
        continue;
      }
      for (let i = map.line.start[number]; i < map.line.start[number + 1]; i++) {
        const point = map.line.points[i];
        const colour = new Map(map.pairs(map.point.tags[point])).get('color');
        pen.dot(map.x[point], map.y[point], wide * 0.42, { red: '#ff5148', yellow: '#ffc933', green: '#35d07f' }[colour] ?? '#ffffff');
      }
    }
  }
}

const lengthOf = (points) => points.reduce((sum, p, i) => (i ? sum + Math.hypot(p[0] - points[i - 1][0], p[1] - points[i - 1][1]) : 0), 0);

/** Draws primitives of the map in the pixels of a frame. */
class Pen {
  constructor(context, frame, map) { Object.assign(this, { context, frame, map }); }

  px(x) { return (x - this.frame.x) * this.frame.scale; }
  py(y) { return (this.frame.y - y) * this.frame.scale; }
  begin() { this.context.beginPath(); }

  fill(colour) { this.context.fillStyle = colour; this.context.fill(); }

  stroke(colour, width, dash = null, cap = 'butt') {
    Object.assign(this.context, { strokeStyle: colour, lineWidth: width, lineCap: cap, lineJoin: 'round' });
    this.context.setLineDash(dash ?? []);
    this.context.stroke();
  }

  /** Adds points to the path, leaving out those that would fall on the pixel before. */
  trace(points, move = true) {
    const { map, context } = this;
    let lastX = 0, lastY = 0;
    for (let i = 0; i < points.length; i++) {
      const x = this.px(map.x[points[i]]), y = this.py(map.y[points[i]]);
      if (i === 0 && move) context.moveTo(x, y);
      else if (i > 0 && i < points.length - 1 && Math.abs(x - lastX) + Math.abs(y - lastY) < 0.8) continue;
      else context.lineTo(x, y);
      lastX = x; lastY = y;
    }
  }

  outline(lanelet) {
    const left = boundPoints(this.map, lanelet, 'left');
    const right = boundPoints(this.map, lanelet, 'right');
    if (!left.length || !right.length) return;
    this.trace(left);
    this.trace(right.slice().reverse(), false);
    this.context.closePath();
  }

  fillPolygon(polygon, colour, edge = null) {
    const { start, points } = this.map.polygon;
    this.begin();
    this.trace(points.subarray(start[polygon], start[polygon + 1]));
    this.context.closePath();
    this.fill(colour);
    if (edge) this.stroke(edge, Math.max(0.12 * this.frame.scale, this.frame.ratio), [0.9, 0.45].map((m) => Math.max(m * this.frame.scale, 3)));
  }

  /** A line of the map, moved sideways to its left by `offset` pixels. */
  line(number, offset) {
    const { start, points } = this.map.line;
    const own = points.subarray(start[number], start[number + 1]);
    if (!offset) { this.trace(own); return; }
    const shape = Array.from(own, (p) => [this.px(this.map.x[p]), this.py(this.map.y[p])]);
    shape.forEach(([x, y], i) => {
      const [ax, ay] = shape[Math.max(i - 1, 0)], [bx, by] = shape[Math.min(i + 1, shape.length - 1)];
      const length = Math.hypot(bx - ax, by - ay) || 1;
      const [u, v] = [x + ((by - ay) / length) * offset, y - ((bx - ax) / length) * offset];
      if (i) this.context.lineTo(u, v); else this.context.moveTo(u, v);
    });
  }

  /** A lane as start, middle and end of its centre. */
  middle(lanelet) {
    const { map, context } = this;
    const left = boundPoints(map, lanelet, 'left'), right = boundPoints(map, lanelet, 'right');
    if (!left.length || !right.length) return;
    const steps = Math.max(left.length, right.length) > 2 ? [0, 0.5, 1] : [0, 1];
    steps.forEach((t, i) => {
      const l = left[Math.round(t * (left.length - 1))], r = right[Math.round(t * (right.length - 1))];
      const x = this.px((map.x[l] + map.x[r]) / 2), y = this.py((map.y[l] + map.y[r]) / 2);
      if (i) context.lineTo(x, y); else context.moveTo(x, y);
    });
  }

  /** World points evenly along a line of points: `pieces` of them, or as many as `step` metres give. */
  resample(points, step, pieces = 0) {
    const { map } = this;
    const world = Array.from(points, (p) => [map.x[p], map.y[p]]);
    if (world.length < 2) return [];
    const length = lengthOf(world);
    const count = pieces || Math.min(Math.max(Math.floor(length / step), 1), 2000);
    const out = [world[0]];
    let at = 1, walked = 0;
    for (let i = 1; i < count; i++) {
      const station = (length * i) / count;
      for (;;) {
        const [a, b] = [world[at - 1], world[at]];
        const d = Math.hypot(b[0] - a[0], b[1] - a[1]);
        if (walked + d >= station || at === world.length - 1) {
          const t = d ? Math.min((station - walked) / d, 1) : 0;
          out.push([a[0] + (b[0] - a[0]) * t, a[1] + (b[1] - a[1]) * t]);
          break;
        }
        walked += d;
        at++;
      }
    }
    out.push(world[world.length - 1]);
    return out;
  }

  /** The centre line of a lanelet, world points. */
  centre(lanelet) {
    const left = this.resample(boundPoints(this.map, lanelet, 'left'), 1.5);
    if (left.length < 2) return [];
    const right = this.resample(boundPoints(this.map, lanelet, 'right'), 1.5, left.length - 1);
    return left.map((l, i) => { const r = right[i] ?? l; return [(l[0] + r[0]) / 2, (l[1] + r[1]) / 2]; });
  }

  path(world) { world.forEach(([x, y], i) => (i ? this.context.lineTo(this.px(x), this.py(y)) : this.context.moveTo(this.px(x), this.py(y)))); }

  ring(world) { this.path(world); this.context.closePath(); }

  dot(x, y, radius, colour) {
    this.begin();
    this.context.arc(this.px(x), this.py(y), radius, 0, 2 * Math.PI);
    this.fill(colour);
  }

  /** An arrow's tip at a station along world points. */
  tip(world, station, size, colour) {
    let walked = 0;
    for (let i = 1; i < world.length; i++) {
      const [a, b] = [world[i - 1], world[i]];
      const d = Math.hypot(b[0] - a[0], b[1] - a[1]);
      if (walked + d < station && i < world.length - 1) { walked += d; continue; }
      const t = d ? (station - walked) / d : 0;
      const angle = Math.atan2(-(b[1] - a[1]), b[0] - a[0]);
      const { context } = this;
      context.save();
      context.translate(this.px(a[0] + (b[0] - a[0]) * t), this.py(a[1] + (b[1] - a[1]) * t));
      context.rotate(angle);
      context.beginPath();
      context.moveTo(1.3 * size, 0);
      context.lineTo(-0.9 * size, -0.8 * size);
      context.lineTo(-0.45 * size, 0);
      context.lineTo(-0.9 * size, 0.8 * size);
      context.fillStyle = colour;
      context.fill();
      context.restore();
      return;
    }
  }
}
