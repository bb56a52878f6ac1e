// Hands on the map: drag, pinch, wheel, click, arrow keys.

/** Farther than this, in pixels, a press is a drag and no click. */
const CLICK = 5;

/**
 * What a press may take hold of instead of the map, asked in this order: from the event to null, or to
 * { move(x, y), drop(x, y, travelled), cancel() } with places in CSS pixels of the canvas.
 */
const grips = [];
/** What a click may mean before it means a primitive: from a place to whether it did. */
const pickers = [];

function hands() {
  const { canvas } = view;
  const fingers = new Map();
  let travelled = 0, held = null;
  canvas.addEventListener('pointerdown', (event) => {
    canvas.setPointerCapture(event.pointerId);
    fingers.set(event.pointerId, [event.offsetX, event.offsetY]);
    if (fingers.size === 1) travelled = 0;
    held?.cancel();
    held = null;
    if (fingers.size === 1 && event.button === 0) for (const grip of grips) if ((held ??= grip(event))) break;
    canvas.classList.add('held');
  });
  canvas.addEventListener('pointermove', (event) => {
    showWhere(event);
    const last = fingers.get(event.pointerId);
    if (!last) { canvas.classList.toggle('over', Boolean(pinAt(event.offsetX, event.offsetY, toScreen, view.scale))); return; }
    const [dx, dy] = [event.offsetX - last[0], event.offsetY - last[1]];
    travelled += Math.hypot(dx, dy);
    if (held) held.move(event.offsetX, event.offsetY);
    else if (fingers.size === 1) { if (travelled > CLICK) panBy(dx, dy); } else if (fingers.size === 2) pinch(fingers, event);
    fingers.set(event.pointerId, [event.offsetX, event.offsetY]);
  });
  const lift = (event) => {
    const single = fingers.size === 1;
    fingers.delete(event.pointerId);
    if (!fingers.size) canvas.classList.remove('held');
    const grip = held;
    held = null;
    if (grip && event.type === 'pointerup') grip.drop(event.offsetX, event.offsetY, travelled);
    else if (grip) grip.cancel();
    else if (event.type === 'pointerup' && single && travelled <= CLICK) pick(event.offsetX, event.offsetY);
    if (!single) travelled = Infinity;
  };
  canvas.addEventListener('pointerup', lift);
  canvas.addEventListener('pointercancel', lift);
  canvas.addEventListener('wheel', (event) => {
    event.preventDefault();
    const lines = event.deltaMode === 1 ? 16 : 1;
    zoomAt(2 ** (-(event.deltaY * lines) / (event.ctrlKey ? 60 : 260)), event.offsetX, event.offsetY);
  }, { passive: false });
  canvas.addEventListener('dblclick', (event) => zoomAt(2, event.offsetX, event.offsetY));
  canvas.addEventListener('pointerleave', () => { byId('where').textContent = ''; });
  canvas.addEventListener('keydown', (event) => {
    const step = { ArrowLeft: [80, 0], ArrowRight: [-80, 0], ArrowUp: [0, 80], ArrowDown: [0, -80] }[event.key];
    if (!step || event.altKey || event.ctrlKey || event.metaKey) return;
    event.preventDefault();
    event.stopPropagation();
    panBy(...step);
  });
  byId('zoom-in').addEventListener('click', () => zoomAt(1.6));
  byId('zoom-out').addEventListener('click', () => zoomAt(1 / 1.6));
  byId('zoom-fit').addEventListener('click', () => showBox(usualBox(state.index)));
}

/** Two fingers: what was under them stays under them. */
function pinch(fingers, event) {
  const other = [...fingers].find(([id]) => id !== event.pointerId)[1];
  const [before, after] = [fingers.get(event.pointerId), [event.offsetX, event.offsetY]];
  const spread = (a) => Math.max(Math.hypot(a[0] - other[0], a[1] - other[1]), 10);
  panBy((after[0] - before[0]) / 2, (after[1] - before[1]) / 2);
  zoomAt(spread(after) / spread(before), (after[0] + other[0]) / 2, (after[1] + other[1]) / 2);
}

function showWhere(event) {
  const at = latLon(...toWorld(event.offsetX, event.offsetY));
  byId('where').textContent = at ? at.map((v) => v.toFixed(6)).join(', ') : '';
}

/** A click: a pin, or else what lies there; another click at the same place takes what lies below. */
let lastPick = { x: -99, y: -99, turn: 0 };
function pick(sx, sy) {
  const pin = pinAt(sx, sy, toScreen, view.scale);
  if (pin) { pickPin(pin); return; }
  if (pickers.some((picker) => picker(sx, sy))) return;
  const found = primitivesAt(sx, sy);
  const again = Math.hypot(sx - lastPick.x, sy - lastPick.y) < CLICK;
  lastPick = { x: sx, y: sy, turn: again ? lastPick.turn + 1 : 0 };
  choosePrimitive(found.length ? found[lastPick.turn % found.length] : null, { stay: true });
}

function pickPin({ findings, box }) {
  const wide = Math.max(box[2] - box[0], box[3] - box[1]);
  if (findings.length > 1 && wide > 2 && view.scale < 12) { showBox(box, { most: 12, pad: 0.4 }); return; }
  const next = findings[(findings.indexOf(state.finding) + 1) % findings.length];
  chooseFinding(next, { stay: true });
}

/** Primitives under a place on the screen: signals and stop lines, lanelets from the smallest up, areas, other lines; of each those above first. */
function primitivesAt(sx, sy) {
  const { map, index } = state;
  const [x, y] = toWorld(sx, sy);
  const reach = 7 / view.scale;
  const ranked = [];
  for (const item of search(index, [x - reach, y - reach, x + reach, y + reach])) {
    const [kind, number] = index.itemOf(item);
    if (kind === 'line') {
      const { start, points } = map.line;
      if (distanceTo(map, points.subarray(start[number], start[number + 1]), x, y) > reach) continue;
      const look = view.classes.line[map.line.tags[number]];
      ranked.push({ kind, number, rank: look.signal || look.over ? 0 : 3, size: 0 });
    } else {
      const ring = kind === 'lanelet'
        ? [...boundPoints(map, number, 'left'), ...[...boundPoints(map, number, 'right')].reverse()]
        : map.polygon.points.subarray(map.polygon.start[number], map.polygon.start[number + 1]);
      if (!inside(map, ring, x, y)) continue;
      const box = boxOf(map, kind, number);
      ranked.push({ kind, number, rank: kind === 'lanelet' ? 1 : 2, size: (box[2] - box[0]) * (box[3] - box[1]) });
    }
  }
  const level = ({ kind, number }) => levelOf(map, kind, number);
  return ranked.sort((a, b) => a.rank - b.rank || level(b) - level(a) || a.size - b.size || a.number - b.number).map(({ kind, number }) => ({ kind, number }));
}

function distanceTo(map, points, x, y) {
  let best = Infinity;
  for (let i = 1; i < points.length; i++) {
    const [ax, ay, bx, by] = [map.x[points[i - 1]], map.y[points[i - 1]], map.x[points[i]], map.y[points[i]]];
    const [dx, dy] = [bx - ax, by - ay];
    const t = Math.min(Math.max(((x - ax) * dx + (y - ay) * dy) / (dx * dx + dy * dy || 1), 0), 1);
    best = Math.min(best, Math.hypot(x - ax - t * dx, y - ay - t * dy));
  }
  return best;
}

function inside(map, ring, x, y) {
  let odd = false;
  for (let i = 0, j = ring.length - 1; i < ring.length; j = i++) {
    const [ax, ay, bx, by] = [map.x[ring[i]], map.y[ring[i]], map.x[ring[j]], map.y[ring[j]]];
    if ((ay > y) !== (by > y) && x < ((bx - ax) * (y - ay)) / (by - ay) + ax) odd = !odd;
  }
  return odd;
}
