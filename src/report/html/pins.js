// Findings as pins; where they stand close together, one disc with their number.

/** Pins closer than this, in pixels, become one. */
const CLUSTER = 38;
const WORSE = { info: 0, warning: 1, error: 2 };

/** Where a finding's pin stands, or null for the map as a whole. */
function spot(finding) {
  if (finding.at) return finding.at;
  if (!finding.subject) return null;
  const primitive = findPrimitive(finding.subject[1], finding.subject[0]);
  const box = primitive && boxOf(state.map, primitive.kind, primitive.number);
  // Kept, so that the map is not asked again.
  return box ? (finding.at = [(box[0] + box[2]) / 2, (box[1] + box[3]) / 2]) : null;
}

const pins = { level: null, clusters: [], placed: [], shown: true };

on('shown', () => {
  pins.level = null;
  pins.placed = state.shown.filter((finding) => spot(finding));
  byId('map').dataset.pins = pins.placed.length;
});

/** The clusters at a scale in pixels per metre; made anew only when the scale has doubled or halved. */
function clusters(scale) {
  const level = Math.round(Math.log2(scale) * 2);
  if (pins.level === level) return pins.clusters;
  pins.level = level;
  const cell = CLUSTER / 2 ** (level / 2);
  const cells = new Map();
  for (const finding of pins.placed) {
    const [x, y] = finding.at;
    const key = `${Math.floor(x / cell)} ${Math.floor(y / cell)}`;
    const one = cells.get(key);
    if (!one) cells.set(key, { x, y, findings: [finding], worst: finding.severity, box: [x, y, x, y] });
    else {
      one.findings.push(finding);
      if (WORSE[finding.severity] > WORSE[one.worst]) one.worst = finding.severity;
      grow(one.box, x, y);
      one.x += (x - one.x) / one.findings.length;
      one.y += (y - one.y) / one.findings.length;
    }
  }
  pins.clusters = joined([...cells.values()], cell).sort((a, b) => WORSE[a.worst] - WORSE[b.worst] || b.y - a.y);
  return pins.clusters;
}

/** Joins each cluster with a larger one beside it, so that discs do not lie on each other. */
function joined(found, cell) {
  const kept = [];
  const at = new Map();
  const place = (x, y) => [Math.floor(x / cell), Math.floor(y / cell)];
  for (const one of found.sort((a, b) => b.findings.length - a.findings.length)) {
    const [i, j] = place(one.x, one.y);
    const beside = [-1, 0, 1].flatMap((di) => [-1, 0, 1].flatMap((dj) => at.get(`${i + di} ${j + dj}`) ?? []));
    const other = beside.find((o) => Math.hypot(o.x - one.x, o.y - one.y) < cell * 0.7);
    if (!other) {
      kept.push(one);
      at.set(`${i} ${j}`, [...(at.get(`${i} ${j}`) ?? []), one]);
      continue;
    }
    other.findings.push(...one.findings);
    if (WORSE[one.worst] > WORSE[other.worst]) other.worst = one.worst;
    grow(other.box, one.box[0], one.box[1]);
    grow(other.box, one.box[2], one.box[3]);
  }
  return kept;
}

/** Draws all pins in sight; the chosen one last and larger. */
function drawPins(pen, width, height, colours) {
  if (!pins.shown && !state.finding) return;
  const { ratio } = pen.frame;
  // What is chosen stands out from the rest.
  pen.context.globalAlpha = state.finding || state.primitive ? 0.3 : 1;
  const strength = pen.context.globalAlpha;
  for (const one of clusters(pen.frame.css)) {
    const [x, y] = [pen.px(one.x), pen.py(one.y)];
    if (x < -40 || y < -40 || x > width + 40 || y > height + 60) continue;
    if (one.findings.length === 1) {
      if (one.findings[0] !== state.finding) drawPin(pen.context, x, y, ratio, one.findings[0], colours);
    } else drawDisc(pen.context, x, y, ratio, one, colours, strength);
  }
  pen.context.globalAlpha = 1;
  const chosen = state.finding && spot(state.finding);
  if (chosen) drawPin(pen.context, pen.px(chosen[0]), pen.py(chosen[1]), ratio * 1.35, state.finding, colours);
}

/** A drop whose tip touches the place; hollow where the finding is gone. */
function drawPin(context, x, y, size, finding, colours) {
  context.save();
  context.translate(x, y);
  context.scale(size, size);
  context.setLineDash([]);
  context.beginPath();
  context.moveTo(0, 0);
  context.bezierCurveTo(-2, -5, -8, -9, -8, -15);
  context.arc(0, -15, 8, Math.PI, 0);
  context.bezierCurveTo(8, -9, 2, -5, 0, 0);
  const gone = finding.status === 'gone';
  context.fillStyle = gone ? colours.halo : colours[finding.severity];
  context.strokeStyle = gone ? colours[finding.severity] : colours.halo;
  context.lineWidth = 1.6;
  context.shadowColor = 'rgba(0,0,0,.28)';
  context.shadowBlur = 3 * size;
  context.shadowOffsetY = 1 * size;
  context.fill();
  context.shadowColor = 'transparent';
  context.stroke();
  context.beginPath();
  context.fillStyle = gone ? colours[finding.severity] : '#fff';
  // The shape, too, tells the severity.
  if (finding.severity === 'error') context.arc(0, -15, 3, 0, 2 * Math.PI);
  else if (finding.severity === 'warning') { context.moveTo(0, -18.6); context.lineTo(3.4, -12.8); context.lineTo(-3.4, -12.8); }
  else context.rect(-1.1, -18.5, 2.2, 7);
  context.fill();
  context.restore();
}

function drawDisc(context, x, y, ratio, one, colours, strength) {
  const count = one.findings.length;
  const radius = (count < 10 ? 11 : count < 100 ? 13 : count < 1000 ? 16 : 19) * ratio;
  context.beginPath();
  context.arc(x, y, radius + 3 * ratio, 0, 2 * Math.PI);
  context.globalAlpha = 0.25 * strength;
  context.fillStyle = colours[one.worst];
  context.fill();
  context.globalAlpha = strength;
  context.beginPath();
  context.arc(x, y, radius, 0, 2 * Math.PI);
  context.fillStyle = colours[one.worst];
  context.fill();
  context.setLineDash([]);
  context.lineWidth = 1.6 * ratio;
  context.strokeStyle = colours.halo;
  context.stroke();
  context.fillStyle = colours.halo;
  context.font = `600 ${11.5 * ratio}px system-ui, sans-serif`;
  context.textAlign = 'center';
  context.textBaseline = 'middle';
  context.fillText(count < 10000 ? String(count) : `${Math.round(count / 1000)}k`, x, y + 0.5 * ratio);
}

/** The cluster under a place on the screen, in CSS pixels. */
function pinAt(x, y, toScreen, scale) {
  let best = null;
  if (!pins.shown && !state.finding) return best;
  for (const one of clusters(scale)) {
    const [px, py] = toScreen(one.x, one.y);
    const dy = one.findings.length === 1 ? y - (py - 14) : y - py;
    if (Math.hypot(x - px, dy) < (one.findings.length === 1 ? 13 : 17)) best = one;
  }
  return best;
}
