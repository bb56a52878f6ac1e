// The input under the hands: nodes that can be dragged, edits with undo and redo, and the map built anew after each.

/** A handle is taken hold of from this far, pixels; nodes are shown from this many pixels per metre. */
const GRASP = 9;
const HANDLES_FROM = 0.7;
/** A click this close to a road's line, pixels, means the road. */
const NEAR_ROAD = 8;

const editor = {
  /** All edits, of which the first `at` are made. */
  edits: [], at: 0,
  /** A node in the hand: { id, x, y }, and the edit that it would be. */
  dragged: null, provisional: null,
  /** Id of the chosen way. */
  way: null,
  work: null, again: false, trouble: null, took: null, byId: new Map(), byNode: new Map(),
};

on('start', () => {
  const { title } = state.report;
  byId('title').textContent = title;
  startStages();
  indexInput();
  on('data', indexInput);
  grips.push(nodeGrip);
  pickers.push(pickRoad);
  on('underlay', drawInput);
  on('tab', (name) => { pins.shown = name !== 'stages'; ask(); });
  startPanel();
  changed = rebuild;
  watchChanges();
  on('moved', followPart);
  view.canvas.addEventListener('pointermove', ({ buttons, offsetX, offsetY }) => {
    // What a stage says of what lies under the pointer.
    view.canvas.title = buttons ? '' : marksAt(...toWorld(offsetX, offsetY))[0] ?? '';
  });
  KEYS.push([['u'], 'Undo an edit (Ctrl+Z)', undo], [['y'], 'Redo it (Ctrl+Y)', redo]);
  document.addEventListener('keydown', (event) => {
    if (!(event.ctrlKey || event.metaKey) || event.altKey || event.target.matches?.('input, select, textarea')) return;
    const key = event.key.toLowerCase();
    const action = key === 'y' || (key === 'z' && event.shiftKey) ? redo : key === 'z' ? undo : null;
    if (!action) return;
    event.preventDefault();
    action();
  });
});

const workshop = () => state.report.workshop;

/** Ways by id, and their boxes. */
function indexInput() {
  editor.byId = new Map(workshop().ways.map((way) => [way.id, way]));
  editor.byNode = new Map(workshop().nodes.map(([id], number) => [id, number]));
  for (const way of workshop().ways) {
    way.box = emptyBox();
    for (const at of way.nodes) grow(way.box, workshop().nodes[at][1], workshop().nodes[at][2]);
  }
  if (!editor.byId.has(editor.way)) editor.way = null;
}

/* Edits */

const madeEdits = () => editor.edits.slice(0, editor.at);
/** A map that is built this quickly, milliseconds, is built while a node is being dragged. */
const QUICK = 250;

function commit(edit) {
  editor.edits.length = editor.at;
  editor.edits.push(edit);
  editor.at++;
  return rebuild();
}

function undo() { if (editor.at > 0) { editor.at--; rebuild(); } }
function redo() { if (editor.at < editor.edits.length) { editor.at++; rebuild(); } }

/** Where the middle of the page lies, for a server that builds only what is around. */
function around() { return latLon(view.x, view.y); }

function question(quick = false) {
  return { method: 'POST', headers: { 'Content-Type': 'application/json' }, body: JSON.stringify({ edits: [...madeEdits(), ...(editor.provisional ? [editor.provisional] : [])], around: workshop().part ? around() : null, quick }) };
}

/** Has everything built with the edits as they are. One question at a time: what changed meanwhile is asked next. */
function rebuild() {
  editor.again = true;
  view.canvas.dataset.building = 'yes';
  return (editor.work ??= buildAll().finally(() => { editor.work = null; view.canvas.dataset.building = ''; }));
}

async function buildAll() {
  while (editor.again) {
    editor.again = false;
    try {
      // The stages first; what the rules find, when nobody waits for stages.
      await buildOnce(true);
      if (!editor.again && !editor.provisional && !editor.trouble) await buildOnce(false);
    } catch (error) {
      editor.trouble = `lanewright does not answer: ${error.message}`;
    }
    view.canvas.dataset.builds = String(Number(view.canvas.dataset.builds ?? 0) + 1);
    tell('built');
  }
}

async function buildOnce(quick) {
  const start = performance.now();
  const response = await fetch('build', question(quick));
  live.version = Number(response.headers.get('Lanewright-Version'));
  editor.trouble = response.headers.get('Content-Type').startsWith('text/plain') ? await response.text() : null;
  if (editor.trouble) return;
  const both = await readParcel(await response.arrayBuffer());
  if (quick) Object.assign(both.report, { findings: state.report.findings, groups: state.report.groups, requirements: state.report.requirements });
  follow(both);
  if (quick) editor.took = { build: workshop().took, all: Math.round(performance.now() - start) };
}

/** Where only a part is built: builds another when the middle of the page has left it. */
function followPart() {
  const { part } = workshop();
  if (!part) return;
  const [minX, minY, maxX, maxY] = part.box;
  if (view.x < minX || view.x > maxX || view.y < minY || view.y > maxY) rebuild();
}

/* Hands */

/** The node under a place on the screen; the ends of roads before other nodes. */
function nodeAt(sx, sy) {
  if (view.scale < HANDLES_FROM) return null;
  let best = null, least = GRASP;
  workshop().nodes.forEach(([, x, y], number) => {
    const [u, v] = toScreen(x, y);
    const far = Math.hypot(u - sx, v - sy);
    if (far < least) { least = far; best = number; }
  });
  return best;
}

function nodeGrip(event) {
  const number = nodeAt(event.offsetX, event.offsetY);
  if (number === null) return null;
  const [id, x, y] = workshop().nodes[number];
  const [sx, sy] = toScreen(x, y);
  const off = [event.offsetX - sx, event.offsetY - sy];
  const place = (u, v) => toWorld(u - off[0], v - off[1]);
  const moved = (u, v) => { const at = latLon(...place(u, v)); return at && { edit: 'move', node: id, lat: at[0], lon: at[1] }; };
  const release = () => { editor.dragged = editor.provisional = null; ask(); };
  return {
    move(u, v) {
      const [wx, wy] = place(u, v);
      editor.dragged = { id, x: wx, y: wy };
      if (Math.hypot(wx - x, wy - y) * view.scale > CLICK && editor.took?.all < QUICK) { editor.provisional = moved(u, v); rebuild(); }
      ask();
    },
    drop(u, v, travelled) {
      const built = editor.provisional;
      release();
      const edit = travelled > CLICK && moved(u, v);
      if (edit) commit(edit);
      else if (built) rebuild();
      else chooseWay(workshop().ways.find((way) => way.nodes.includes(editor.byNode.get(id)))?.id ?? null);
    },
    cancel() { const built = editor.provisional; release(); if (built) rebuild(); },
  };
}

function pickRoad(sx, sy) {
  const [x, y] = toWorld(sx, sy);
  const reach = NEAR_ROAD / view.scale;
  let best = null, least = reach;
  for (const way of workshop().ways) {
    if (x < way.box[0] - reach || y < way.box[1] - reach || x > way.box[2] + reach || y > way.box[3] + reach) continue;
    const far = distanceToFlat(way.nodes.flatMap((at) => workshop().nodes[at].slice(1)), x, y);
    if (far < least) { least = far; best = way; }
  }
  if (!best) return false;
  chooseWay(best.id);
  return true;
}

function chooseWay(id) {
  editor.way = id;
  chooseFinding(null, { stay: true });
  if (id) showTab('stages');
  tell('way');
  ask();
}

/* What the input looks like */

function drawInput({ pen, colours }) {
  const { ratio, css } = pen.frame;
  const [minX, maxY] = toWorld(-20, -20), [maxX, minY] = toWorld(view.width + 20, view.height + 20);
  const { nodes, ways, part } = workshop();
  const place = (at) => (editor.dragged?.id === nodes[at][0] ? [editor.dragged.x, editor.dragged.y] : [nodes[at][1], nodes[at][2]]);
  const seen = ways.filter(({ box }) => box[0] <= maxX && box[1] <= maxY && box[2] >= minX && box[3] >= minY);
  for (const way of seen) {
    const chosen = way.id === editor.way;
    if (!chosen && css < HANDLES_FROM && !editor.dragged) continue;
    pen.begin();
    pen.path(way.nodes.map(place));
    if (chosen) pen.stroke(colours.halo, 6 * ratio, null, 'round');
    pen.stroke(colours.choice, (chosen ? 3.2 : 1) * ratio, null, 'round');
  }
  if (css >= HANDLES_FROM) {
    const own = new Set(editor.byId.get(editor.way)?.nodes ?? []);
    for (const at of new Set(seen.flatMap((way) => way.nodes))) {
      const size = (own.has(at) ? 4.4 : 3) * ratio;
      const [x, y] = place(at);
      pen.begin();
      pen.context.rect(pen.px(x) - size, pen.py(y) - size, 2 * size, 2 * size);
      pen.fill(own.has(at) ? colours.choice : colours.halo);
      pen.stroke(own.has(at) ? colours.halo : colours.choice, 1.4 * ratio);
    }
  }
  if (!part) return;
  const [ax, ay, bx, by] = part.box;
  pen.begin();
  pen.ring([[ax, ay], [bx, ay], [bx, by], [ax, by]]);
  pen.stroke(colours.warning, 1.6 * ratio, [10 * ratio, 6 * ratio]);
}
