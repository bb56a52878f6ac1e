// The map on its canvas: camera, tiles painted ahead, hands on it. Panning moves tiles that are painted already.

const TILE = 512;
/** Milliseconds of painting per frame, so that hands stay in front. */
const BUDGET = 9;
/** After this many milliseconds without zooming, tiles are painted for the new scale. */
const SETTLE = 130;
const MOST_TILES = 110;
const SCALES = [1e-4, 60];
const FLIGHT = 420;

const view = {
  canvas: null, context: null, x: 0, y: 0, scale: 1, width: 0, height: 0, ratio: 1,
  level: null, old: null, base: null, lastScale: 0, zoomed: 0, flight: null, asked: false, classes: null,
};
const calm = matchMedia('(prefers-reduced-motion: reduce)');

const toScreen = (x, y) => [(x - view.x) * view.scale + view.width / 2, (view.y - y) * view.scale + view.height / 2];
const toWorld = (x, y) => [view.x + (x - view.width / 2) / view.scale, view.y - (y - view.height / 2) / view.scale];

/** Starts the map on its canvas. */
function startView() {
  view.canvas = byId('map');
  view.context = drawingContext();
  view.classes = classify(state.map);
  on('data', followData);
  new ResizeObserver(resize).observe(byId('stage'));
  resize();
  showBox(usualBox(state.index), { jump: true });
  view.base = newLevel();
  view.level = view.base;
  hands();
  on('choice', ({ stay }) => { if (!stay) flyToChoice(); ask(); });
  on('shown', ask);
  on('theme', repaint);
}

/**
 * What the map is drawn with: the graphics card where it draws what it is told, else the processor; null, and a word of it, where the
 * browser draws nothing at all.
 */
function drawingContext() {
  const tile = document.createElement('canvas').getContext('2d');
  const drawsRight = (context) => {
    if (!context || !tile) return false;
    tile.fillStyle = '#fff';
    tile.fillRect(0, 0, 2, 2);
    context.drawImage(tile.canvas, 0, 0);
    return context.getImageData(0, 0, 1, 1).data[0] === 255;
  };
  const context = view.canvas.getContext('2d', { alpha: false });
  if (drawsRight(context)) return context;
  // A canvas keeps the context that it gave first.
  const other = view.canvas.cloneNode();
  view.canvas.replaceWith(other);
  view.canvas = other;
  const slow = other.getContext('2d', { alpha: false, willReadFrequently: true });
  if (drawsRight(slow)) {
    toast('The graphics card does not draw the map; the processor does, which is slower');
    return slow;
  }
  byId('stage').append(make('p', { class: 'no-map', role: 'alert' },
    'This browser cannot draw the map. The list beside it is complete; `lanewright draw MAP -o map.svg` draws the map as a picture.'));
  return null;
}

/** Another map: what is painted is old, and what was in the middle stays there. */
function followData(before) {
  const [from, to] = [before.frame.origin, state.report.frame.origin];
  view.x += from[0] - to[0];
  view.y += from[1] - to[1];
  view.classes = classify(state.map);
  const old = from[0] === to[0] && from[1] === to[1] ? view.level : null;
  repaint();
  // Until the new tiles are painted, the old ones are better than none.
  view.old = old;
}

/** Paints all anew. */
function repaint() {
  view.old = view.flight = null;
  view.base = view.level = newLevel();
  ask();
}

function resize() {
  const { clientWidth, clientHeight } = byId('stage');
  view.ratio = Math.min(window.devicePixelRatio || 1, 3);
  Object.assign(view, { width: clientWidth, height: clientHeight });
  view.canvas.width = Math.max(Math.round(clientWidth * view.ratio), 1);
  view.canvas.height = Math.max(Math.round(clientHeight * view.ratio), 1);
  // A canvas of another size is black until it is drawn on, which happens a frame later.
  if (view.context) {
    view.context.fillStyle = palette().ground;
    view.context.fillRect(0, 0, view.canvas.width, view.canvas.height);
  }
  ask();
}

/** Asks for a frame, once. */
function ask() {
  if (view.asked) return;
  view.asked = true;
  requestAnimationFrame(frame);
}

/* Camera */

function zoomAt(factor, sx = view.width / 2, sy = view.height / 2) {
  const [x, y] = toWorld(sx, sy);
  view.scale = Math.min(Math.max(view.scale * factor, SCALES[0]), SCALES[1]);
  view.x = x - (sx - view.width / 2) / view.scale;
  view.y = y + (sy - view.height / 2) / view.scale;
  moved();
}

function panBy(dx, dy) {
  view.x -= dx / view.scale;
  view.y += dy / view.scale;
  moved();
}

let movedTimer = 0;
function moved() {
  view.flight = null;
  ask();
  clearTimeout(movedTimer);
  movedTimer = setTimeout(settled, 160);
}

/** Says, also in the page, where the map stands: the middle of what the card leaves clear, in metres from the origin. */
function settled() {
  const [left, top, right, bottom] = clearArea();
  view.canvas.dataset.centre = toWorld((left + right) / 2, (top + bottom) / 2).map((v) => v.toFixed(2)).join(' ');
  view.canvas.dataset.scale = String(view.scale);
  tell('moved');
}

/** The part of the stage that the card leaves clear: left, top, right, bottom in CSS pixels. */
function clearArea() {
  const card = byId('card');
  const clear = [0, 0, view.width, view.height];
  if (card.hidden) return clear;
  const [stage, box] = [byId('stage').getBoundingClientRect(), card.getBoundingClientRect()];
  // Beside the map's middle: leave its column free. On a phone it lies elsewhere or below.
  if (box.width < stage.width * 0.6) clear[2] = Math.max(box.left - stage.left - 8, stage.width * 0.3);
  else if (box.top < stage.bottom) clear[3] = Math.max(box.top - stage.top, stage.height * 0.3);
  return clear;
}

/** Moves so that a box fills the clear part of the stage, no closer than `most` pixels per metre. */
function showBox([minX, minY, maxX, maxY], { jump = false, most = SCALES[1], pad = 0.12 } = {}) {
  const [left, top, right, bottom] = clearArea();
  const [width, height] = [Math.max(right - left, 50), Math.max(bottom - top, 50)];
  const fit = Math.min(width / Math.max(maxX - minX, 1e-6), height / Math.max(maxY - minY, 1e-6)) / (1 + 2 * pad);
  const scale = Math.min(Math.max(Math.min(fit, most), SCALES[0]), SCALES[1]);
  const x = (minX + maxX) / 2 + (view.width / 2 - (left + right) / 2) / scale;
  const y = (minY + maxY) / 2 - (view.height / 2 - (top + bottom) / 2) / scale;
  if (jump || calm.matches || document.hidden) { Object.assign(view, { x, y, scale }); moved(); return; }
  view.flight = { from: { x: view.x, y: view.y, scale: view.scale }, to: { x, y, scale }, start: performance.now() };
  ask();
}

function fly(now) {
  const { from, to, start } = view.flight;
  const t = Math.min((now - start) / FLIGHT, 1);
  const ease = t < 0.5 ? 4 * t ** 3 : 1 - (-2 * t + 2) ** 3 / 2;
  view.scale = from.scale * (to.scale / from.scale) ** ease;
  // Places move as the scale does, so that the flight is straight on the screen.
  const share = Math.abs(to.scale - from.scale) < 1e-9 * to.scale ? ease : (1 / from.scale - 1 / view.scale) / (1 / from.scale - 1 / to.scale);
  view.x = from.x + (to.x - from.x) * share;
  view.y = from.y + (to.y - from.y) * share;
  if (t === 1) { Object.assign(view, to); moved(); }
}

/** The least that is shown around a choice, metres. */
const SURROUNDINGS = 18;

function flyToChoice() {
  const box = choiceBox();
  if (!box) return;
  const grown = [box[0] - SURROUNDINGS, box[1] - SURROUNDINGS, box[2] + SURROUNDINGS, box[3] + SURROUNDINGS];
  showBox(grown, { most: 12, pad: 0.08 });
}

/** What is chosen, as a box: a finding's place (or pin) before its subject's whole extent. */
function choiceBox() {
  const { finding, primitive, map } = state;
  if (primitive) return boxOf(map, primitive.kind, primitive.number);
  if (!finding) return null;
  const box = emptyBox();
  const place = finding.place?.[1] ?? [];
  for (let i = 0; i + 1 < place.length; i += 2) grow(box, place[i], place[i + 1]);
  const at = spot(finding);
  if (box[0] > box[2] && finding.subject) {
    const subject = findPrimitive(finding.subject[1], finding.subject[0]);
    const own = subject && boxOf(map, subject.kind, subject.number);
    // A long lanelet is not shown whole: the pin would be a dot on it.
    if (own && own[2] - own[0] < 150 && own[3] - own[1] < 150) return own;
  }
  if (at) grow(box, at[0], at[1]);
  return box[0] <= box[2] ? box : null;
}

/* Frames */

const newLevel = () => ({ scale: view.scale * view.ratio, css: view.scale, tiles: new Map() });

function frame(now) {
  view.asked = false;
  if (!view.context) return;
  if (view.flight) fly(now);
  const scale = view.scale * view.ratio;
  if (scale !== view.level.scale) {
    if (view.lastScale !== scale) Object.assign(view, { lastScale: scale, zoomed: now });
    if (!view.flight && now - view.zoomed >= SETTLE) {
      if (view.level !== view.base) view.old = view.level;
      view.level = newLevel();
    } else ask();
  }
  const { context, canvas } = view;
  const colours = palette();
  context.setTransform(1, 0, 0, 1, 0, 0);
  context.globalAlpha = 1;
  context.fillStyle = colours.ground;
  context.fillRect(0, 0, canvas.width, canvas.height);
  const ready = view.level.scale === scale && visible(view.level).every(({ key }) => view.level.tiles.get(key)?.done);
  if (!ready) for (const level of [view.base, view.old]) if (level && level !== view.level) drawLevel(level);
  drawLevel(view.level);
  drawOverlay(colours);
  work(colours, now);
  drawScale();
  if (view.flight) ask();
}

/** The tiles of a level that the canvas shows, nearest to the middle first; `margin` tiles more on each side. */
function visible(level, margin = 0) {
  const [w, h] = [view.canvas.width, view.canvas.height];
  const zoom = level.scale / (view.scale * view.ratio);
  const cx = view.x * level.scale, cy = -view.y * level.scale;
  const [left, top] = [Math.floor((cx - (w / 2) * zoom) / TILE) - margin, Math.floor((cy - (h / 2) * zoom) / TILE) - margin];
  const [right, bottom] = [Math.floor((cx + (w / 2) * zoom) / TILE) + margin, Math.floor((cy + (h / 2) * zoom) / TILE) + margin];
  const tiles = [];
  if ((right - left) * (bottom - top) > 4000) return tiles;
  for (let j = top; j <= bottom; j++) for (let i = left; i <= right; i++) tiles.push({ i, j, key: `${i} ${j}` });
  const far = ({ i, j }) => Math.hypot((i + 0.5) * TILE - cx, (j + 0.5) * TILE - cy);
  return tiles.sort((a, b) => far(a) - far(b));
}

function drawLevel(level) {
  const { context, canvas } = view;
  const zoom = (view.scale * view.ratio) / level.scale;
  const size = TILE * zoom;
  // Whole pixels: tiles meet without a seam.
  const left = canvas.width / 2 - view.x * level.scale * zoom;
  const top = canvas.height / 2 + view.y * level.scale * zoom;
  const snap = zoom === 1 ? [Math.round(left), Math.round(top)] : [left, top];
  for (const { i, j, key } of visible(level)) {
    const tile = level.tiles.get(key);
    if (!tile?.done) continue;
    if (zoom === 1) context.drawImage(tile.canvas, snap[0] + i * TILE, snap[1] + j * TILE);
    else {
      const [x0, y0] = [Math.floor(snap[0] + i * size), Math.floor(snap[1] + j * size)];
      context.drawImage(tile.canvas, x0, y0, Math.ceil(snap[0] + (i + 1) * size) - x0, Math.ceil(snap[1] + (j + 1) * size) - y0);
    }
  }
}

/** Paints missing tiles until the budget of this frame is used up; a ring around the screen when nothing else is left. */
function work(colours, now) {
  const { level } = view;
  if (level.scale !== view.scale * view.ratio) return;
  const until = performance.now() + BUDGET;
  const wanted = [...visible(level), ...visible(level, 1)];
  for (const { i, j, key } of wanted) {
    let tile = level.tiles.get(key);
    if (tile?.done) continue;
    if (!tile) level.tiles.set(key, tile = newTile(level, i, j, colours));
    while (!tile.done && performance.now() < until) tile.done = tile.job.next().done;
    if (!tile.done || performance.now() >= until) { ask(); return; }
    ask();
  }
  if (level.tiles.size > MOST_TILES) {
    const keep = new Set(wanted.map((tile) => tile.key));
    for (const key of level.tiles.keys()) if (!keep.has(key)) level.tiles.delete(key);
  }
  view.canvas.dataset.painted = String(Math.round(now));
}

function newTile(level, i, j, colours) {
  const canvas = document.createElement('canvas');
  canvas.width = canvas.height = TILE;
  const context = canvas.getContext('2d');
  const metres = TILE / level.scale;
  const box = [i * metres, -(j + 1) * metres, (i + 1) * metres, -j * metres];
  const edge = 2 + 3 / level.scale;
  const items = search(state.index, [box[0] - edge, box[1] - edge, box[2] + edge, box[3] + edge]);
  const tileFrame = { x: box[0], y: box[3], scale: level.scale, css: level.css, ratio: view.ratio };
  return { canvas, done: false, job: paint(context, tileFrame, items, state.map, view.classes, colours) };
}

/* What is chosen, over the tiles */

function drawOverlay(colours) {
  const { canvas, context, ratio } = view;
  const [x, y] = toWorld(0, 0);
  const pen = new Pen(context, { x, y, scale: view.scale * ratio, css: view.scale, ratio }, state.map);
  tell('underlay', { pen, colours });
  for (const one of highlights()) drawHighlight(pen, one, colours);
  drawPlace(pen, colours);
  tell('overlay', { pen, colours });
  drawPins(pen, canvas.width, canvas.height, colours);
}

function drawHighlight(pen, { kind, number, colour, label, main }, colours) {
  const { ratio } = pen.frame;
  const width = (main ? 3 : 2.4) * ratio;
  const outline = (halo) => pen.stroke(halo ? colours.halo : colour, halo ? width + 2.4 * ratio : width, null, 'round');
  pen.begin();
  if (kind === 'point') pen.context.arc(pen.px(state.map.x[number]), pen.py(state.map.y[number]), 7 * ratio, 0, 2 * Math.PI);
  else if (kind === 'line') pen.line(number, 0);
  else if (kind === 'polygon') { pen.trace(state.map.polygon.points.subarray(state.map.polygon.start[number], state.map.polygon.start[number + 1])); pen.context.closePath(); }
  else if (kind === 'lanelet') pen.outline(number);
  if (kind === 'lanelet' || kind === 'polygon') {
    pen.context.globalAlpha = main ? 0.32 : 0.24;
    pen.fill(colour);
    pen.context.globalAlpha = 1;
  }
  outline(true);
  outline(false);
  if (label && pen.frame.css > 1.2) drawLabel(pen, kind, number, label, colour, colours);
}

function drawLabel(pen, kind, number, label, colour, colours) {
  const box = boxOf(state.map, kind, number);
  if (!box) return;
  drawWords(pen, (box[0] + box[2]) / 2, (box[1] + box[3]) / 2, label, colour, colours, kind === 'line' ? -10 : 0);
}

/** Words with a halo, their middle at a place of the map. */
function drawWords(pen, worldX, worldY, words, colour, colours, lift = 0) {
  const { context, frame: { ratio } } = pen;
  context.font = `600 ${11.5 * ratio}px system-ui, sans-serif`;
  context.textAlign = 'center';
  context.textBaseline = 'middle';
  context.setLineDash([]);
  context.lineWidth = 3.4 * ratio;
  context.strokeStyle = colours.halo;
  context.fillStyle = colour;
  const [x, y] = [pen.px(worldX), pen.py(worldY) + lift * ratio];
  context.strokeText(words, x, y);
  context.fillText(words, x, y);
}

/** The finding's own place: a spot, a line, or an area with a dashed edge. */
function drawPlace(pen, colours) {
  const [kind, points] = state.finding?.place ?? [];
  if (!kind || kind === 'point') return;
  const world = [];
  for (let i = 0; i + 1 < points.length; i += 2) world.push([points[i], points[i + 1]]);
  const colour = colours[state.finding.severity];
  const { ratio } = pen.frame;
  pen.begin();
  if (kind === 'polygon') {
    pen.ring(world);
    pen.context.globalAlpha = 0.45;
    pen.fill(colour);
    pen.context.globalAlpha = 1;
  } else pen.path(world);
  pen.stroke(colours.halo, (kind === 'line' ? 7 : 4) * ratio, null, 'round');
  pen.stroke(colour, (kind === 'line' ? 4 : 2) * ratio, kind === 'line' ? null : [5 * ratio, 3 * ratio], 'butt');
}

/** A bar of a round length. */
function drawScale() {
  const most = 110 / view.scale;
  const power = 10 ** Math.floor(Math.log10(most));
  const length = [5, 2, 1].map((f) => f * power).find((l) => l <= most) ?? power;
  const text = length >= 1000 ? `${length / 1000} km` : length >= 1 ? `${length} m` : `${Math.round(length * 100)} cm`;
  const bar = byId('scale').firstElementChild;
  bar.style.width = `${(length * view.scale).toFixed(1)}px`;
  if (bar.textContent !== text) bar.textContent = text;
}
