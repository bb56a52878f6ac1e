// The stages of the builder, one over another: chosen in a list or by keys, drawn over the map that comes of them.

/** How marks look: fill and stroke, width in pixels, dash; by class, the last that fits. */
const MARK_LOOKS = {
  carriage: { fill: 'rgba(120,128,139,.55)' }, outline: { fill: 'rgba(154,161,171,.75)', stroke: '#c79a1b', width: 1.6 },
  merged: { fill: 'rgba(176,152,226,.75)' }, fallback: { fill: 'rgba(217,138,134,.8)' },
  strip: { stroke: 'rgba(255,255,255,.6)', width: 0.8 }, 'strip-drive': { fill: '#737b86' }, 'strip-bus': { fill: '#8a6a3a' },
  'strip-bicycle': { fill: '#9a736e' }, 'strip-parking': { fill: '#7f8f9f' }, 'strip-shoulder': { fill: '#8b9099' },
  'strip-pedestrian': { fill: '#a8a493' },
  'strip-sidewalk': { fill: '#d9d2c0' }, 'strip-buffer': { fill: '#b9c4a8' },
  edge: { stroke: '#3d7fd6', width: 1.3 }, centre: { stroke: 'ink', width: 1, dash: [5, 4] }, kerb: { stroke: 'kerb', width: 1.8 },
  foot: { stroke: 'rgba(224,30,55,.5)', width: 1 }, least: { stroke: '#f27d0c', width: 2.2 }, wanted: { stroke: '#2f9e62', width: 2.2 },
  cut: { stroke: 'ink', width: 2.4 }, in: { stroke: '#8c5bd6', width: 3 }, out: { stroke: '#2f9e62', width: 3 },
  node: { fill: 'ink' }, hit: { fill: '#7aa7e0' }, decides: { fill: '#e01e37' },
};
/** How much of the ground's colour lies over the map while a stage is shown. */
const VEIL = 0.84;
/** Pixels per metre from which on words are written. */
const WORDS_FROM = 2.5;

const stages = { at: 0 };

/** All stages, the last of which is the map itself. */
const allStages = () => state.report.workshop.stages;

function startStages() {
  stages.at = allStages().length - 1;
  allStages().forEach((_, at) => KEYS.push([[String(at + 1)], `Stage: ${allStages()[at].name}`, () => showStage(at)]));
  KEYS.push([['['], 'Stage before', () => showStage(stages.at - 1)], [[']'], 'Next stage', () => showStage(stages.at + 1)]);
  on('underlay', drawStage);
  on('overlay', drawStageWords);
}

function showStage(at) {
  stages.at = Math.min(Math.max(at, 0), allStages().length - 1);
  tell('stage');
  ask();
}

function drawStage({ pen, colours }) {
  const stage = allStages()[stages.at];
  view.canvas.dataset.stage = stage.name;
  if (!stage.layers.length) return;
  const { context } = pen;
  context.globalAlpha = VEIL;
  context.fillStyle = colours.ground;
  context.fillRect(0, 0, view.canvas.width, view.canvas.height);
  context.globalAlpha = 1;
  const [minX, maxY] = toWorld(-40, -40), [maxX, minY] = toWorld(view.width + 40, view.height + 40);
  let drawn = 0;
  for (const { marks } of stage.layers) {
    for (const mark of marks) {
      const box = mark.box ??= boxOfFlat(mark[3]);
      if (box[0] > maxX || box[1] > maxY || box[2] < minX || box[3] < minY) continue;
      drawMark(pen, mark, colours);
      drawn++;
    }
  }
  view.canvas.dataset.marks = String(drawn);
}

function boxOfFlat(flat) {
  const box = emptyBox();
  for (let i = 0; i + 1 < flat.length; i += 2) grow(box, flat[i], flat[i + 1]);
  return box;
}

const lookOf = (names) => Object.assign({}, ...names.split(' ').map((name) => MARK_LOOKS[name]));

function drawMark(pen, [kind, names, title, flat], colours) {
  const { ratio } = pen.frame;
  const look = lookOf(names);
  const colour = (name) => colours[name] ?? name;
  if (kind === 'words') return;
  if (kind === 'spot') { pen.dot(flat[0], flat[1], 3.2 * ratio, colour(look.fill ?? 'ink')); return; }
  const world = [];
  for (let i = 0; i + 1 < flat.length; i += 2) world.push([flat[i], flat[i + 1]]);
  pen.begin();
  if (kind === 'area') pen.ring(world); else pen.path(world);
  if (look.fill) pen.fill(colour(look.fill));
  if (look.stroke) pen.stroke(colour(look.stroke), look.width * ratio, look.dash && look.dash.map((v) => v * ratio));
}

/** Words lie over everything else. */
function drawStageWords({ pen, colours }) {
  if (pen.frame.css < WORDS_FROM) return;
  for (const { marks } of allStages()[stages.at].layers) {
    for (const [kind, , words, [x, y]] of marks) if (kind === 'words') drawWords(pen, x, y, words, colours.ink, colours, -12);
  }
}

/** What lies under a place of the map, in the words of the stage: its titles, the topmost first. */
function marksAt(x, y) {
  const reach = 6 / view.scale;
  const found = [];
  for (const { marks } of allStages()[stages.at].layers) {
    for (const mark of marks) {
      const [kind, , title, flat] = mark;
      const box = mark.box ??= boxOfFlat(flat);
      if (!title || kind === 'words' || x < box[0] - reach || y < box[1] - reach || x > box[2] + reach || y > box[3] + reach) continue;
      const near = kind === 'area' ? insideFlat(flat, x, y) : distanceToFlat(flat, x, y) <= reach;
      if (near && found[0] !== title) found.unshift(title);
    }
  }
  return found;
}

function distanceToFlat(flat, x, y) {
  let best = Math.hypot(x - flat[0], y - flat[1]);
  for (let i = 2; i + 1 < flat.length; i += 2) {
    const [ax, ay, dx, dy] = [flat[i - 2], flat[i - 1], flat[i] - flat[i - 2], flat[i + 1] - flat[i - 1]];
    const t = Math.min(Math.max(((x - ax) * dx + (y - ay) * dy) / (dx * dx + dy * dy || 1), 0), 1);
    best = Math.min(best, Math.hypot(x - ax - t * dx, y - ay - t * dy));
  }
  return best;
}

function insideFlat(ring, x, y) {
  let odd = false;
  for (let i = 0, j = ring.length - 2; i + 1 < ring.length; j = i, i += 2) {
    if ((ring[i + 1] > y) !== (ring[j + 1] > y) && x < ((ring[j] - ring[i]) * (y - ring[i + 1])) / (ring[j + 1] - ring[i + 1]) + ring[i]) odd = !odd;
  }
  return odd;
}
