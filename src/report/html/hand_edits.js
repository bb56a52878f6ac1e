// Edits of a person in a review: tags, turns, yields on the card of an element; nodes and vertices by hand on the map.

/** A vertex is taken hold of from this far, pixels, and let fall onto another node from this far. */
const HOLD = 9;
const ONTO = 12;

const hand = {
  /** What the next lanelet that is clicked is for, or null. */
  choosing: null,
  /** A node in the hand: { number, x, y, onto }. */
  held: null,
};

on('start', () => {
  on('edit card', (primitive) => (isArea(primitive) ? [] : [editSection(primitive)]));
  on('overlay', drawHandles);
  grips.push(handleGrip);
  pickers.unshift(chooseLanelet);
});

const edit = (what) => act({ do: 'edit', edit: what });
const idOf = (kind, number) => String(state.map[kind].id[number]);

/* On the card */

function editSection({ kind, number }) {
  const id = idOf(kind, number);
  const parts = [kind === 'lanelet' ? turnField(id, number) : null, kind === 'lanelet' ? yieldRows(id, number) : null, tagFields(kind, id, number)];
  const hint = { polygon: 'Drag a vertex of the area to move it, or onto another node to run over that.', line: 'Drag an end onto another node to make them one.', lanelet: 'Drag an end of a bound onto another node to make them one.' }[kind];
  return make('section', { class: 'hand', id: 'hand' }, make('h3', {}, 'Edit'), ...parts.filter(Boolean), hint ? make('p', { class: 'small' }, hint) : null);
}

function turnField(id, number) {
  const now = tagOf('lanelet', number, 'turn_direction') ?? '';
  const choices = ['', 'left', 'straight', 'right'].map((value) => make('option', { value, selected: value === now }, value || 'none'));
  return make('label', {}, make('span', {}, 'turn'), make('select', { id: 'edit-turn', onchange: (event) => edit({ edit: 'turn', lanelet: id, turn: event.target.value || null }) }, ...choices));
}

/** The lanelets that give way to one, as its elements name them. */
function yieldsTo(number) {
  const { map } = state;
  const rules = Array.from(map.lanelet.rules.subarray(map.lanelet.start[number], map.lanelet.start[number + 1]));
  const members = rules.map((rule) => membersOf(map, rule))
    .filter((all) => all.some((one) => one.role === 'right_of_way' && one.kind === 'lanelet' && one.number === number));
  return [...new Set(members.flat().filter((one) => one.role === 'yield' && one.kind === 'lanelet').map((one) => one.number))];
}

function yieldRows(id, number) {
  const rows = yieldsTo(number).map((other) => make('li', {}, reference(['lanelet', idOf('lanelet', other)]),
    make('button', { type: 'button', class: 'chip take-yield', title: 'It does not give way', onclick: () => edit({ edit: 'remove-yield', first: id, waits: idOf('lanelet', other) }) }, 'Take')));
  const add = (waits) => edit({ edit: 'add-yield', first: id, waits });
  const typed = make('input', { id: 'edit-yield', type: 'text', inputmode: 'numeric', placeholder: 'lanelet', autocomplete: 'off' });
  return make('div', {}, make('p', { class: 'small' }, 'These give way to it:'), make('ul', { class: 'related yields' }, ...rows),
    make('form', { class: 'row-form', onsubmit: (event) => { event.preventDefault(); if (typed.value.trim()) add(typed.value.trim()); } }, typed,
      make('button', { type: 'submit', class: 'chip', id: 'add-yield' }, 'Add'),
      make('button', { type: 'button', class: 'chip', onclick: () => { hand.choosing = { of: id, then: add }; toast('Click the lanelet that gives way'); } }, 'On the map')));
}

function tagFields(kind, id, number) {
  const set = (key, value) => edit({ edit: 'tag', kind, id, key, value: value || null });
  const rows = state.map.pairs(state.map[kind].tags[number]).map(([key, value]) => make('label', {}, make('span', {}, key), make('input', {
    type: 'text', value, autocomplete: 'off', spellcheck: 'false', 'data-key': key, onchange: (event) => set(key, event.target.value.trim()),
  })));
  const [key, value] = ['key', 'value'].map((word) => make('input', { type: 'text', placeholder: word, autocomplete: 'off', spellcheck: 'false', id: `new-${word}` }));
  return make('details', {}, make('summary', {}, 'Tags'), make('div', { class: 'fields' }, ...rows),
    make('form', { class: 'row-form', onsubmit: (event) => { event.preventDefault(); if (key.value.trim()) set(key.value.trim(), value.value.trim()); } }, key, value, make('button', { type: 'submit', class: 'chip' }, 'Add')));
}

/** A click that chooses a lanelet for an edit. */
function chooseLanelet(sx, sy) {
  if (!hand.choosing) return false;
  const found = primitivesAt(sx, sy).find((one) => one.kind === 'lanelet' && idOf('lanelet', one.number) !== hand.choosing.of);
  const { then } = hand.choosing;
  hand.choosing = null;
  if (found) then(idOf('lanelet', found.number)); else toast('No other lanelet lies there');
  return true;
}

/* On the map */

/** The nodes of what is chosen that can be taken hold of: [number of the point, area or null]. */
function handles() {
  const { map, primitive } = state;
  if (!primitive || isArea(primitive)) return [];
  const { kind, number } = primitive;
  const of = (one) => Array.from(map[one.kind].points.subarray(map[one.kind].start[one.number], map[one.kind].start[one.number + 1]));
  const ends = (points) => (points.length ? [points[0], points.at(-1)] : []);
  if (kind === 'polygon') return of(primitive).map((point) => [point, number]);
  if (kind === 'line') return ends(of(primitive)).map((point) => [point, null]);
  if (kind !== 'lanelet') return [];
  return [...new Set(['left', 'right'].flatMap((side) => ends(Array.from(boundPoints(map, number, side)))))].map((point) => [point, null]);
}

/** The nearest node to a place on the screen, but for one. */
function nodeNear(sx, sy, but) {
  const { map, index } = state;
  const [x, y] = toWorld(sx, sy);
  const reach = ONTO / view.scale;
  let best = null, least = reach;
  for (const item of search(index, [x - reach, y - reach, x + reach, y + reach])) {
    const [kind, number] = index.itemOf(item);
    if (kind === 'lanelet') continue;
    const { start, points } = map[kind];
    for (let i = start[number]; i < start[number + 1]; i++) {
      const far = Math.hypot(map.x[points[i]] - x, map.y[points[i]] - y);
      if (points[i] !== but && far < least) { least = far; best = points[i]; }
    }
  }
  return best;
}

function handleGrip(event) {
  const { map } = state;
  const near = ([point]) => { const [u, v] = toScreen(map.x[point], map.y[point]); return Math.hypot(u - event.offsetX, v - event.offsetY); };
  const taken = handles().filter((one) => near(one) < HOLD).sort((a, b) => near(a) - near(b))[0];
  if (!taken) return null;
  const [point, area] = taken;
  const release = () => { hand.held = null; ask(); };
  return {
    move(u, v) {
      const [x, y] = toWorld(u, v);
      hand.held = { point, x, y, onto: nodeNear(u, v, point) };
      ask();
    },
    drop(u, v, travelled) {
      const onto = nodeNear(u, v, point);
      release();
      if (travelled <= CLICK) { choosePrimitive({ kind: 'point', number: point }, { stay: true }); return; }
      const node = idOf('point', point);
      const [x, y] = toWorld(u, v);
      const { origin } = state.report.frame;
      if (area === null && onto === null) toast('Let it fall onto another node: an end that is moved away would part the lanes');
      else if (area === null) edit({ edit: 'join', from: node, to: idOf('point', onto) });
      else if (onto === null) edit({ edit: 'move-vertex', area: idOf('polygon', area), node, to: [x + origin[0], y + origin[1]] });
      else edit({ edit: 'replace-vertex', area: idOf('polygon', area), node, by: idOf('point', onto) });
    },
    cancel: release,
  };
}

function drawHandles({ pen, colours }) {
  const { map } = state;
  const { ratio } = pen.frame;
  const shown = handles();
  view.canvas.dataset.handles = shown.map(([point]) => [idOf('point', point), ...toScreen(map.x[point], map.y[point])].join(' ')).join(', ');
  for (const [point] of shown) {
    const size = 4.5 * ratio;
    const [x, y] = hand.held?.point === point ? [hand.held.x, hand.held.y] : [map.x[point], map.y[point]];
    pen.begin();
    pen.context.rect(pen.px(x) - size, pen.py(y) - size, 2 * size, 2 * size);
    pen.fill(colours.halo);
    pen.stroke(colours.choice, 1.6 * ratio);
  }
  if (hand.held && hand.held.onto !== null) pen.dot(map.x[hand.held.onto], map.y[hand.held.onto], 7 * ratio, colours.choice);
}
