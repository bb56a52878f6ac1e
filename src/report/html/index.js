// Where things are: boxes of lanelets, lines and polygons in a packed tree, and primitives by id.

const NODE_SIZE = 16;

/** Visits the points of a line or polygon: `visit(x, y)`. */
function eachPoint(map, kind, number, visit) {
  const { start, points } = map[kind];
  for (let i = start[number]; i < start[number + 1]; i++) visit(map.x[points[i]], map.y[points[i]]);
}

/** The numbers of a bound's points in driving direction; `side` is left or right. */
function boundPoints(map, lanelet, side) {
  const code = map.lanelet[side][lanelet];
  if (code === 0) return [];
  const line = (code >> 1) - 1;
  const points = map.line.points.subarray(map.line.start[line], map.line.start[line + 1]);
  return code & 1 ? points.slice().reverse() : points;
}

/** Grows a box [minX, minY, maxX, maxY] by a point. */
function grow(box, x, y) {
  if (x < box[0]) box[0] = x;
  if (y < box[1]) box[1] = y;
  if (x > box[2]) box[2] = x;
  if (y > box[3]) box[3] = y;
}
const emptyBox = () => [Infinity, Infinity, -Infinity, -Infinity];

/** The box around a primitive, or null. */
function boxOf(map, kind, number, depth = 0) {
  const box = emptyBox();
  const add = (x, y) => grow(box, x, y);
  if (kind === 'point') add(map.x[number], map.y[number]);
  else if (kind === 'line' || kind === 'polygon') eachPoint(map, kind, number, add);
  else if (kind === 'lanelet') {
    for (const side of ['left', 'right']) {
      const code = map.lanelet[side][number];
      if (code) eachPoint(map, 'line', (code >> 1) - 1, add);
    }
  } else if (depth === 0) {
    for (const member of membersOf(map, number)) {
      const inner = boxOf(map, member.kind, member.number, 1);
      if (inner) { add(inner[0], inner[1]); add(inner[2], inner[3]); }
    }
  }
  return box[0] <= box[2] ? box : null;
}

/** The members of a regulatory element. */
function membersOf(map, rule) {
  const members = [];
  for (let i = map.rule.start[rule]; i < map.rule.start[rule + 1]; i++) {
    members.push({ role: map.string(map.rule.role[i]), kind: KINDS[map.rule.kind[i]], number: map.rule.member[i] });
  }
  return members;
}

/** Interleaves 16 bits of each coordinate, so that near places have near codes. */
function spread(v) {
  v = (v | (v << 8)) & 0x00ff00ff;
  v = (v | (v << 4)) & 0x0f0f0f0f;
  v = (v | (v << 2)) & 0x33333333;
  return (v | (v << 1)) & 0x55555555;
}

/** Builds the tree. Items are numbered lanelets first, then lines, then polygons. */
function buildIndex(map) {
  const counts = [map.lanelet.id.length, map.line.id.length, map.polygon.id.length];
  const kinds = ['lanelet', 'line', 'polygon'];
  const total = counts[0] + counts[1] + counts[2];
  const own = new Float64Array(total * 4);
  const whole = emptyBox();
  for (let item = 0; item < total; item++) {
    const [kind, number] = itemOf(item);
    const box = boxOf(map, kind, number) ?? [NaN, NaN, NaN, NaN];
    own.set(box, item * 4);
    if (box[0] <= box[2]) { grow(whole, box[0], box[1]); grow(whole, box[2], box[3]); }
  }
  function itemOf(item) {
    if (item < counts[0]) return [kinds[0], item];
    if (item < counts[0] + counts[1]) return [kinds[1], item - counts[0]];
    return [kinds[2], item - counts[0] - counts[1]];
  }
  const side = Math.max(whole[2] - whole[0], whole[3] - whole[1], 1e-9);
  const codes = new Float64Array(total);
  for (let i = 0; i < total; i++) {
    const x = ((own[i * 4] + own[i * 4 + 2]) / 2 - whole[0]) / side;
    const y = ((own[i * 4 + 1] + own[i * 4 + 3]) / 2 - whole[1]) / side;
    codes[i] = Number.isNaN(x + y) ? -1 : (spread(x * 65535) >>> 0) + (spread(y * 65535) >>> 0) * 2;
  }
  const items = Uint32Array.from(codes.keys()).filter((i) => codes[i] >= 0).sort((a, b) => codes[a] - codes[b]);
  // Levels from the leaves up; each box covers NODE_SIZE boxes of the level below.
  let boxes = new Float64Array(items.length * 4);
  items.forEach((item, i) => boxes.set(own.subarray(item * 4, item * 4 + 4), i * 4));
  const levels = [boxes];
  while (boxes.length > 4) {
    const count = boxes.length / 4;
    const above = new Float64Array(Math.ceil(count / NODE_SIZE) * 4);
    for (let i = 0; i < above.length / 4; i++) {
      const box = emptyBox();
      for (let j = i * NODE_SIZE; j < Math.min(count, (i + 1) * NODE_SIZE); j++) {
        grow(box, boxes[j * 4], boxes[j * 4 + 1]);
        grow(box, boxes[j * 4 + 2], boxes[j * 4 + 3]);
      }
      above.set(box, i * 4);
    }
    boxes = above;
    levels.push(boxes);
  }
  return { levels, items, itemOf, whole: whole[0] <= whole[2] ? whole : [-50, -50, 50, 50], byId: {} };
}

/** Items whose boxes meet the given one, in no order that means anything. */
function search(index, [minX, minY, maxX, maxY]) {
  const found = [];
  const meets = (b, i) => b[i] <= maxX && b[i + 1] <= maxY && b[i + 2] >= minX && b[i + 3] >= minY;
  const visit = (level, from, to) => {
    const boxes = index.levels[level];
    for (let i = from; i < Math.min(to, boxes.length / 4); i++) {
      if (!meets(boxes, i * 4)) continue;
      if (level === 0) found.push(index.items[i]);
      else visit(level - 1, i * NODE_SIZE, (i + 1) * NODE_SIZE);
    }
  };
  if (index.items.length) visit(index.levels.length - 1, 0, Infinity);
  return found;
}

/** The primitive of this kind (or any, relations and ways first) and id. */
function findPrimitive(id, kind = null) {
  const { map, index } = state;
  const numbers = (k) => index.byId[k] ??= new Map(Array.from(map[k].id, (one, number) => [String(one), number]));
  const order = { node: ['point'], way: ['line', 'polygon'], relation: ['lanelet', 'rule', 'polygon'] }[kind]
    ?? (kind ? [kind] : ['lanelet', 'rule', 'polygon', 'line', 'point']);
  for (const k of order) {
    const number = numbers(k).get(String(id));
    if (number !== undefined) return { kind: k, number };
  }
  return null;
}

/** A box that holds nearly everything: a stray point at 0, 0 does not shrink the map to a dot. */
function usualBox(index) {
  const boxes = index.levels[0];
  const count = boxes.length / 4;
  if (count < 40) return index.whole;
  const range = (low, high) => {
    const lows = Float64Array.from({ length: count }, (_, i) => boxes[i * 4 + low]).sort();
    const highs = Float64Array.from({ length: count }, (_, i) => boxes[i * 4 + high]).sort();
    return [lows[Math.floor(count * 0.02)], highs[Math.ceil(count * 0.98) - 1]];
  };
  const [[minX, maxX], [minY, maxY]] = [range(0, 2), range(1, 3)];
  const margin = Math.max(maxX - minX, maxY - minY) * 0.25 + 10;
  const clip = (v, low, high) => Math.min(Math.max(v, low), high);
  const w = index.whole;
  return [clip(minX - margin, w[0], minX), clip(minY - margin, w[1], minY), clip(maxX + margin, maxX, w[2]), clip(maxY + margin, maxY, w[3])];
}

/** Latitude and longitude of a place, or null where the map's do not fit a plane. */
function latLon(x, y) {
  const fit = state.report.frame.lonlat;
  if (!fit) return null;
  const [u, v] = [x / 1000, y / 1000];
  return fit.map(([a, b, c, d, e, f]) => a + b * u + c * v + d * u * u + e * u * v + f * v * v);
}
