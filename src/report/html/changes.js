// What changed between two versions of a map: a list of elements, and each one before and after side by side.

const changes = {
  /** The old map with its tree of places. */
  old: null,
  /** The chosen change, or null. */
  chosen: null,
  shown: new Set(['added', 'removed', 'changed']), text: '', listed: [],
};
const CHANGE_SIGNS = { added: '+', removed: '−', changed: '~' };
/** More rows of a group than this are counted. */
const MOST_ROWS = 400;
/** Half the width of the pictures before and after at least, and at most, metres. */
const LOOK = [15, 120];

on('start', () => {
  state.report.diff.changes.forEach((change, number) => { change.number = number; });
  startChangesPane();
  on('overlay', drawChanges);
  on('choice', () => { if (state.primitive) changes.chosen = null; drawChangeCard(); });
  pickers.unshift(pickChange);
  KEYS.unshift([['j', 'n'], 'Next change', () => stepChange(1)], [['k', 'p'], 'Previous change', () => stepChange(-1)]);
  readMap(bytesOf('old-map-data')).then((map) => {
    changes.old = { map, index: buildIndex(map), classes: classify(map) };
    drawChangeCard();
    document.documentElement.dataset.old = 'read';
  });
});

const wordsOfChange = (change) => `${KIND_WORDS[change.subject[0]]} ${change.subject[1]}`;
const colourOfChange = (change, colours) => ({ added: colours.preview, removed: colours.error, changed: colours.warning })[change.change];

function boxOfChange(change) {
  return (change.box ??= change.shape.reduce((box, [, points]) => { for (const [x, y] of points) grow(box, x, y); return box; }, emptyBox()));
}

/* The list */

function startChangesPane() {
  const tab = make('button', { type: 'button', role: 'tab', id: 'tab-changes', 'aria-controls': 'pane-changes', 'aria-selected': 'false' }, 'Changes');
  byId('tab-findings').before(tab);
  for (const name of ['findings', 'requirements']) byId(`tab-${name}`).hidden = true;
  byId('side').append(make('div', { class: 'pane changes', id: 'pane-changes', role: 'tabpanel', 'aria-labelledby': 'tab-changes', hidden: true }));
  TABS.length = 0;
  TABS.push('findings', 'requirements', 'changes');
  showTab('changes');
  TABS.length = 0;
  TABS.push('changes');
  drawChangesPane();
  const count = (kind) => state.report.diff.changes.filter((change) => change.change === kind).length;
  byId('verdict').replaceChildren(...Object.entries(CHANGE_SIGNS).map(([kind, sign]) => make('span', { class: kind }, `${sign} ${count(kind).toLocaleString('en')} ${kind}`)));
}

function drawChangesPane() {
  const { diff } = state.report;
  const words = changes.text.toLowerCase().split(/\s+/).filter(Boolean);
  const found = (change) => words.every((word) => `${change.subject.join(' ')} ${change.facts.join(' ')}`.toLowerCase().includes(word));
  const order = Object.keys(CHANGE_SIGNS);
  changes.listed = diff.changes.filter((change) => changes.shown.has(change.change) && found(change))
    .sort((a, b) => a.group - b.group || order.indexOf(a.change) - order.indexOf(b.change) || a.number - b.number);
  const search = byId('search-changes') ?? make('input', { type: 'search', id: 'search-changes', placeholder: 'Filter by text or id', 'aria-label': 'Filter by text or id', autocomplete: 'off', oninput: (event) => { changes.text = event.target.value; drawChangesPane(); } });
  const count = (kind) => diff.changes.filter((change) => change.change === kind).length;
  const turn = (kind) => { if (!changes.shown.delete(kind)) changes.shown.add(kind); drawChangesPane(); };
  const chips = order.map((kind) => chip(`${CHANGE_SIGNS[kind]} ${count(kind).toLocaleString('en')} ${kind}`, changes.shown.has(kind), () => turn(kind)));
  const groups = diff.groups.map((name, group) => {
    const rows = changes.listed.filter((change) => change.group === group);
    if (!rows.length) return null;
    const more = rows.length - MOST_ROWS;
    return make('section', {}, make('h3', {}, name, make('span', { class: 'count' }, ` ${rows.length.toLocaleString('en')}`)),
      make('ul', {}, ...rows.slice(0, MOST_ROWS).map(changeRow), more > 0 ? make('li', { class: 'small' }, `${more.toLocaleString('en')} more: filter by text or id`) : null));
  });
  const empty = diff.changes.length ? 'No change passes the filters.' : 'The maps do not differ.';
  const pane = byId('pane-changes');
  const typing = document.activeElement === search;
  pane.replaceChildren(make('div', { class: 'filters' }, search, make('div', { class: 'chips' }, ...chips)),
    make('div', { class: 'change-list' }, ...(changes.listed.length ? groups.filter(Boolean) : [make('p', { class: 'small' }, empty)])));
  if (typing) search.focus();
  pane.dataset.count = String(changes.listed.length);
  ask();
}

function changeRow(change) {
  return make('li', {}, make('button', {
    type: 'button', class: `change-row ${change.change}`, 'aria-pressed': String(change === changes.chosen), 'data-number': String(change.number), onclick: () => chooseChange(change),
  }, make('b', { class: 'sign-of' }, CHANGE_SIGNS[change.change]), make('span', {}, wordsOfChange(change)), make('span', { class: 'small' }, change.facts.join('; '))));
}

function chooseChange(change, { stay = false } = {}) {
  changes.chosen = change;
  choosePrimitive(null, { stay: true });
  for (const row of document.querySelectorAll('.change-row')) row.setAttribute('aria-pressed', String(row.dataset.number === String(change.number)));
  document.querySelector(`.change-row[data-number="${change.number}"]`)?.scrollIntoView({ block: 'nearest' });
  const box = boxOfChange(change);
  if (!stay && box[0] <= box[2]) showBox([box[0] - 15, box[1] - 15, box[2] + 15, box[3] + 15], { most: 12 });
}

function stepChange(step) {
  const at = changes.listed.indexOf(changes.chosen);
  const next = changes.listed[at < 0 ? (step > 0 ? 0 : changes.listed.length - 1) : at + step];
  if (next) chooseChange(next);
}

/* The map */

function drawChanges({ pen, colours }) {
  const { ratio } = pen.frame;
  const [minX, maxY] = toWorld(0, 0), [maxX, minY] = toWorld(view.width, view.height);
  let drawn = 0;
  for (const change of changes.listed) {
    const box = boxOfChange(change);
    if (box[0] > maxX || box[1] > maxY || box[2] < minX || box[3] < minY) continue;
    outlineChange(pen, change, colours, (change === changes.chosen ? 3.6 : 1.8) * ratio);
    drawn++;
  }
  view.canvas.dataset.changes = String(drawn);
}

function outlineChange(pen, change, colours, width) {
  for (const [closed, points] of change.shape) {
    pen.begin();
    if (closed) pen.ring(points); else pen.path(points);
    pen.stroke(colours.halo, width * 2, null, 'round');
    pen.stroke(colourOfChange(change, colours), width, null, 'round');
  }
}

/** A click on what changed chooses that; the smallest first. */
function pickChange(sx, sy) {
  const [x, y] = toWorld(sx, sy);
  const reach = 7 / view.scale;
  const size = (change) => { const box = boxOfChange(change); return (box[2] - box[0]) * (box[3] - box[1]); };
  const hit = changes.listed.filter((change) => change.shape.some(([closed, points]) => distanceToFlat((closed ? [...points, points[0]] : points).flat(), x, y) < reach))
    .sort((a, b) => size(a) - size(b));
  if (!hit.length) return false;
  chooseChange(hit[(hit.indexOf(changes.chosen) + 1) % hit.length], { stay: true });
  return true;
}

/* Before and after */

function drawChangeCard() {
  const { chosen } = changes;
  if (!chosen) return;
  const card = byId('card');
  const [before, after] = state.report.diff.names;
  card.hidden = false;
  card.classList.add('wide');
  card.replaceChildren(
    make('button', { type: 'button', class: 'close', 'aria-label': 'Close', onclick: () => { changes.chosen = null; card.hidden = true; ask(); } }, '×'),
    make('p', { class: 'kind' }, make('b', {}, chosen.change)), make('h2', {}, wordsOfChange(chosen)),
    make('ul', { class: 'plain' }, ...chosen.facts.map((fact) => make('li', {}, fact))),
    make('div', { class: 'pair' }, placeIn(chosen, changes.old, before), placeIn(chosen, { map: state.map, index: state.index, classes: view.classes }, after)));
  ask();
}

/** The place of a change in one of the maps. */
function placeIn(change, drawn, name) {
  const canvas = make('canvas', { class: 'place-in', width: '480', height: '360' });
  const box = boxOfChange(change);
  if (drawn && box[0] <= box[2]) paintPlace(canvas, change, drawn, [(box[0] + box[2]) / 2, (box[1] + box[3]) / 2], Math.min(Math.max(box[2] - box[0], box[3] - box[1]) / 2 + 8, LOOK[1]));
  return make('figure', {}, canvas, make('figcaption', {}, name));
}

function paintPlace(canvas, change, { map, index, classes }, [x, y], radius) {
  const half = Math.max(radius, LOOK[0]);
  const colours = palette();
  const context = canvas.getContext('2d');
  const scale = canvas.width / (2 * half);
  const tall = (canvas.height / canvas.width) * half;
  const area = [x - half, y - tall, x + half, y + tall];
  context.fillStyle = colours.ground;
  context.fillRect(0, 0, canvas.width, canvas.height);
  const place = { x: area[0], y: area[3], scale, css: scale / 2, ratio: 2 };
  const job = paint(context, place, search(index, area), map, classes, colours);
  while (!job.next().done);
  outlineChange(new Pen(context, place, map), change, colours, 3);
}
