// The card over the map: the chosen finding or primitive in full, and what of it is highlighted.

/** Value and unit as people write them. */
const UNITS = { m: ' m', m2: ' m²', deg: '°', '%': ' %', 1: '' };
const amount = (value, unit) => `${Number(value.toPrecision(4))}${UNITS[unit] ?? ` ${unit}`}`;

let chosenHighlights = [];
/** What is highlighted: [{ kind, number, colour, label, main }]. */
const highlights = () => chosenHighlights;

function startCard() {
  on('choice', drawCard);
  on('theme', drawCard);
}

function drawCard() {
  const card = byId('card');
  chosenHighlights = [];
  const content = state.finding ? findingCard(state.finding) : state.primitive ? primitiveCard(state.primitive) : null;
  // Where another part of the page shows it in full, the map stays clear.
  card.hidden = !content || asked('shown elsewhere', state.finding).length > 0;
  card.replaceChildren(...(card.hidden ? [] : [closer(), ...content]));
  card.scrollTop = 0;
  byId('map').dataset.highlighted = chosenHighlights.map(({ kind, number }) => `${kind}-${state.map[kind].id[number]}`).join(' ');
  ask();
}

const closer = () => make('button', {
  type: 'button', class: 'close', 'aria-label': 'Close', title: 'Close (Esc)', onclick: () => chooseFinding(null, { stay: true }),
}, '×');

/* Findings */

function findingCard(finding) {
  const colours = palette();
  const parts = [...new Set(finding.related.map(([, part]) => part))];
  const colourOf = new Map(parts.map((part, at) => [part, colours.parts[at % colours.parts.length]]));
  chosenHighlights = finding.related
    .map(([subject, part]) => ({ ...named(subject), colour: colourOf.get(part), label: part }))
    .concat(finding.subject ? [{ ...named(finding.subject), colour: colours[finding.severity], main: true }] : [])
    .filter((one) => one.kind)
    .flatMap((one) => (one.kind === 'rule' ? membersOf(state.map, one.number).map((m) => ({ ...m, colour: one.colour, label: m.role })) : [one]))
    .filter((one) => one.kind);
  const rule = ruleOf(finding);
  const documented = byId(`rule-${rule}`);
  const code = documented
    ? make('button', { type: 'button', class: 'link code', title: 'What the rule requires (r)', onclick: () => showRule(rule) }, finding.code)
    : make('span', { class: 'code' }, finding.code);
  const related = make('ul', { class: 'related' });
  for (const [subject, part] of finding.related) {
    related.append(make('li', {}, swatch(colourOf.get(part)), make('span', { class: 'part' }, part), reference(subject)));
  }
  return [
    make('p', { class: 'kind' }, make('span', { class: `dot ${finding.severity}` }), make('b', {}, finding.severity), ' ', code,
      finding.status ? make('span', { class: `status ${finding.status}` }, finding.status) : null),
    make('h2', {}, finding.message),
    finding.measure && make('p', { class: 'measure' }, make('b', {}, amount(finding.measure[0], finding.measure[2])),
      ` measured, limit ${amount(finding.measure[1], finding.measure[2])}`),
    finding.help && make('p', { class: 'advice' }, finding.help),
    finding.fix && make('p', { class: 'advice fix' }, make('b', {}, 'Fix: '), finding.fix),
    finding.subject && make('ul', { class: 'related' }, make('li', {}, swatch(colours[finding.severity]), make('span', { class: 'part' }, 'subject'), reference(finding.subject))),
    related.childElementCount ? related : null,
    ...asked('card', { finding }),
    placeLine(finding.latlon ?? (spot(finding) && latLon(...spot(finding))), finding.source),
    actions(finding.latlon ?? (spot(finding) && latLon(...spot(finding))), finding.subject, [
      make('button', { type: 'button', onclick: () => copy(addressOf(`finding=${encodeLink(finding.key)}`)), title: 'Copy a link to this finding (l)' }, 'Copy link'),
    ]),
  ].filter(Boolean);
}

const named = ([kind, id]) => findPrimitive(id, kind) ?? {};
const addressOf = (hash) => `${location.href.split('#')[0]}#${hash}`;

function swatch(colour) {
  const element = make('span', { class: 'swatch' });
  element.style.background = colour;
  return element;
}

/** A primitive's kind and id, to go there and to copy. */
function reference([kind, id]) {
  const found = findPrimitive(id, kind);
  const text = `${found ? wordOf(found) : KIND_WORDS[kind] ?? kind} ${id}`;
  return make('span', { class: 'reference' },
    found ? make('button', { type: 'button', class: 'link', title: 'Show it', onclick: () => choosePrimitive(found) }, text) : text,
    make('button', { type: 'button', class: 'copy', title: `Copy ${id}`, 'aria-label': `Copy ${id}`, onclick: () => copy(id) }));
}

function placeLine(at, source) {
  if (!at && !source) return null;
  const text = at?.map((v) => v.toFixed(7)).join(', ');
  return make('p', { class: 'place' }, at && make('button', { type: 'button', class: 'link plain', title: 'Copy latitude and longitude', onclick: () => copy(text) }, text),
    source && make('span', {}, source));
}

/** Half the side of the box that JOSM is asked to show, degrees: some 40 m. */
const JOSM_REACH = 0.0004;

function actions(at, subject, more) {
  const row = make('div', { class: 'actions' }, ...more);
  if (at) {
    const [lat, lon] = at;
    const box = { left: lon - JOSM_REACH, right: lon + JOSM_REACH, bottom: lat - JOSM_REACH, top: lat + JOSM_REACH };
    const query = new URLSearchParams(Object.entries(box).map(([key, value]) => [key, value.toFixed(7)]));
    if (subject && OSM_KINDS[subject[0]]) query.set('select', `${OSM_KINDS[subject[0]]}${subject[1]}`);
    row.append(josm(`zoom?${query}`, 'Show in JOSM', 'Zoom JOSM, in which this map is open, to this place'));
  }
  if (state.report.path) row.append(josm(`open_file?${new URLSearchParams({ filename: state.report.path })}`, 'Open map in JOSM', state.report.path));
  return row;
}

/** A command for JOSM's remote control; an ordinary link, too, to copy or open elsewhere. */
function josm(command, label, title) {
  const href = `http://127.0.0.1:8111/${command}`;
  return make('a', {
    class: 'button', href, title, rel: 'noreferrer', target: '_blank',
    onclick: async (event) => {
      if (event.ctrlKey || event.metaKey || event.shiftKey) return;
      event.preventDefault();
      try { await fetch(href, { mode: 'no-cors' }); toast('Told JOSM'); } catch { toast('JOSM does not answer. Is it open, with remote control switched on?'); }
    },
  }, label);
}

/* Primitives */

/** Tags whose value is the id of another primitive. */
const ID_TAGS = { intersection_area: 'polygon', traffic_light_id: 'line' };

/** Whether it is an area: the page has them behind the polygons. */
const isArea = ({ kind, number }) => kind === 'polygon' && tagOf(kind, number, 'type') === 'multipolygon';
/** What people call it. */
const wordOf = (primitive) => (isArea(primitive) ? 'area' : KIND_WORDS[primitive.kind]);

function primitiveCard({ kind, number }) {
  const { map } = state;
  const colours = palette();
  const id = String(map[kind].id[number]);
  const sections = [];
  if (kind === 'rule') {
    const members = membersOf(map, number);
    const roles = [...new Set(members.map((m) => m.role))];
    const colourOf = (role) => colours.parts[roles.indexOf(role) % colours.parts.length];
    chosenHighlights = members.map((m) => ({ ...m, colour: colourOf(m.role), label: m.role }));
    sections.push(section('Members', members.map((m) => [swatch(colourOf(m.role)), part(m.role), reference([m.kind, String(map[m.kind].id[m.number])])])));
    sections.push(section('Referred to by', referrers(number).map((lanelet) => [reference(['lanelet', String(map.lanelet.id[lanelet])])])));
  } else chosenHighlights = [{ kind, number, colour: colours.choice, main: true }];
  if (kind === 'lanelet') {
    const rules = Array.from(map.lanelet.rules.subarray(map.lanelet.start[number], map.lanelet.start[number + 1]));
    sections.push(section('Regulatory elements', rules.map((rule) => [part(tagOf('rule', rule, 'subtype') ?? ''), reference(['rule', String(map.rule.id[rule])])])));
    const bounds = ['left', 'right'].filter((side) => map.lanelet[side][number]).map((side) => [side, (map.lanelet[side][number] >> 1) - 1]);
    sections.push(section('Bounds', bounds.map(([side, line]) => [part(side), reference(['line', String(map.line.id[line])])])));
    sections.push(section('Beside, behind, ahead', lanesAround(map, number).map(([where, lanelet]) => [part(where), reference(['lanelet', String(map.lanelet.id[lanelet])])])));
  }
  if (kind === 'line') {
    const users = [];
    map.lanelet.left.forEach((code, lanelet) => {
      if (code && (code >> 1) - 1 === number) users.push([part('left of'), reference(['lanelet', String(map.lanelet.id[lanelet])])]);
      const right = map.lanelet.right[lanelet];
      if (right && (right >> 1) - 1 === number) users.push([part('right of'), reference(['lanelet', String(map.lanelet.id[lanelet])])]);
    });
    sections.push(section('Bound of', users));
  }
  if (kind !== 'rule') {
    const rules = rulesNaming(map, kind, number);
    sections.push(section('Named by', rules.map(([role, rule]) => [part(role), reference(['rule', String(map.rule.id[rule])])])));
  }
  const about = state.report.findings.filter((finding) => [finding.subject, ...finding.related.map(([subject]) => subject)]
    .some((subject) => subject && subject[1] === id && findPrimitive(id, subject[0])?.kind === kind));
  sections.push(section('Findings', about.slice(0, 30).map((finding) => [make('span', { class: `dot ${finding.severity}` }),
    make('button', { type: 'button', class: 'link text', onclick: () => chooseFinding(finding) }, finding.message)])));
  const box = boxOf(map, kind, number);
  const at = box && latLon((box[0] + box[2]) / 2, (box[1] + box[3]) / 2);
  return [
    make('p', { class: 'kind' }, make('b', {}, wordOf({ kind, number }))),
    make('h2', { class: 'id' }, id, make('button', { type: 'button', class: 'copy', title: 'Copy the id (c)', 'aria-label': 'Copy the id', onclick: () => copy(id) })),
    tagTable(map.pairs(map[kind].tags[number])),
    ...asked('edit card', { kind, number }),
    ...sections.filter(Boolean),
    ...asked('card', { primitive: { kind, number } }),
    placeLine(at, null),
    actions(at, [isArea({ kind, number }) ? 'relation' : kind, id], [make('button', { type: 'button', onclick: () => copy(addressOf(`id=${id}`)), title: 'Copy a link to it (l)' }, 'Copy link')]),
  ].filter(Boolean);
}

const part = (text) => make('span', { class: 'part' }, text);
const tagOf = (kind, number, key) => new Map(state.map.pairs(state.map[kind].tags[number])).get(key);

function section(title, rows) {
  if (!rows.length) return null;
  return make('section', {}, make('h3', {}, title), make('ul', { class: 'related' }, ...rows.map((row) => make('li', {}, ...row))));
}

function tagTable(pairs) {
  if (!pairs.length) return null;
  const rows = pairs.map(([key, value]) => make('tr', {}, make('th', { scope: 'row' }, key),
    make('td', {}, ID_TAGS[key] && findPrimitive(value, ID_TAGS[key]) ? reference([ID_TAGS[key], value]) : value)));
  return make('table', { class: 'tags' }, make('tbody', {}, ...rows));
}

/** The lanelets that follow a lanelet or lead to it, over the same two nodes, and those that share a bound: [where, lanelet]. */
function lanesAround(map, lanelet) {
  const ends = (one) => {
    const bounds = ['left', 'right'].map((side) => boundPoints(map, one, side));
    return bounds.some((points) => !points.length) ? null : [bounds.map((points) => points[0]), bounds.map((points) => points[points.length - 1])];
  };
  const same = (a, b) => a[0] === b[0] && a[1] === b[1];
  const own = ends(lanelet);
  const bound = (one, side) => map.lanelet[side][one] >> 1;
  const found = [];
  for (let other = 0; other < map.lanelet.id.length; other++) {
    if (other === lanelet) continue;
    for (const [where, mine, theirs] of [['left', 'left', 'right'], ['right', 'right', 'left'], ['left', 'left', 'left'], ['right', 'right', 'right']]) {
      if (bound(lanelet, mine) && bound(lanelet, mine) === bound(other, theirs)) found.push([where, other]);
    }
    const around = own && ends(other);
    if (around && same(around[1], own[0])) found.push(['behind', other]);
    if (around && same(around[0], own[1])) found.push(['ahead', other]);
  }
  return found;
}

/** The regulatory elements that name a primitive: [role, element]. */
function rulesNaming(map, kind, number) {
  const found = [];
  for (let rule = 0; rule < map.rule.id.length; rule++) {
    for (const member of membersOf(map, rule)) if (member.kind === kind && member.number === number) found.push([member.role, rule]);
  }
  return found;
}

/** Lanelets that refer to a regulatory element. */
function referrers(rule) {
  const { start, rules, id } = state.map.lanelet;
  const found = [];
  for (let lanelet = 0; lanelet < id.length; lanelet++) {
    for (let i = start[lanelet]; i < start[lanelet + 1]; i++) if (rules[i] === rule) found.push(lanelet);
  }
  return found;
}
