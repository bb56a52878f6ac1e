// The list of findings: the worst first, what is alike under one row with its first places, the rest counted. Only rows in
// sight exist, so a hundred thousand findings scroll like ten.

/** Heights of rows: a finding or a group of two lines of text and of one, a heading, a line. */
const ROW = 66;
const SHORT_ROW = 49;
const HEAD = 36;
const LINE = 28;
/** Findings of a closed group that have a line. */
const PLACES = 3;

const list = { element: null, inner: null, rows: [], top: [], drawn: new Map(), open: new Set() };

function startList() {
  list.element = byId('list');
  list.inner = make('div', { class: 'rows', role: 'presentation' });
  list.element.append(list.inner);
  list.element.addEventListener('scroll', drawRows, { passive: true });
  new ResizeObserver(() => { if (list.width === textWidth()) drawRows(); else layRows(); }).observe(list.element);
  list.element.addEventListener('keydown', (event) => {
    const step = { ArrowDown: 1, ArrowUp: -1, PageDown: 8, PageUp: -8, Home: -Infinity, End: Infinity }[event.key];
    if (step === undefined) return;
    event.preventDefault();
    stepFinding(step);
  });
  on('shown', layRows);
  on('choice', () => { markRow(); scrollToChoice(); });
}

/** Chooses the finding that many rows farther down. */
function stepFinding(step) {
  const { shown, finding } = state;
  if (!shown.length) return;
  const at = shown.indexOf(finding);
  const next = at < 0 ? (step > 0 ? 0 : shown.length - 1) : Math.min(Math.max(at + step, 0), shown.length - 1);
  if (shown[next] !== finding) chooseFinding(shown[next]);
}

/** Runs of findings that say the same of each. */
function runs(findings, same) {
  const all = [];
  for (const finding of findings) {
    if (all.length && same(all.at(-1)[0], finding)) all.at(-1).push(finding);
    else all.push([finding]);
  }
  return all;
}

/** What a group is called from one version of the map to the next. */
const groupName = ({ severity, code, group }) => `${severity} ${code} ${state.report.groups[group].sentence}`;

/** How broad the text of a row may be: the list but for its padding and the dots. */
const textWidth = () => list.element.clientWidth - 60;

/** The height of a row: as much as its text takes; two lines in a browser that measures no text because it cannot draw. */
function heightOf(text) {
  // Hardly any letter is broader than this or narrower than that, in pixels.
  if (text.length * 4.5 > list.width) return ROW;
  if (text.length * 10 <= list.width) return SHORT_ROW;
  return !list.pen || list.pen.measureText(text).width > list.width ? ROW : SHORT_ROW;
}

/** Headings, groups, findings and counts with where each starts. */
function layRows() {
  list.width = textWidth();
  list.pen ??= document.createElement('canvas').getContext('2d');
  if (list.pen) list.pen.font = `13.5px ${getComputedStyle(list.element).fontFamily}`;
  list.rows = [];
  list.top = [];
  let y = 0;
  const add = (row, height) => { list.rows.push({ ...row, height }); list.top.push(y); y += height; };
  for (const ofRule of runs(state.shown, (a, b) => a.severity === b.severity && ruleOf(a) === ruleOf(b))) {
    add({ draw: () => headRow(ofRule) }, HEAD);
    for (const group of runs(ofRule, (a, b) => a.group === b.group)) layGroup(group, add);
  }
  for (const ofCode of runs(state.counted, (a, b) => a.severity === b.severity && a.code === b.code)) {
    add({ draw: () => countedRow(ofCode) }, LINE);
  }
  list.inner.style.height = `${y}px`;
  list.element.dataset.count = String(state.shown.length);
  list.drawn.clear();
  list.inner.replaceChildren();
  list.element.classList.toggle('empty', !list.rows.length);
  list.element.dataset.empty = state.report.findings.length ? 'No finding passes the filters.' : 'No findings. Nothing to mend.';
  drawRows();
}

function layGroup(group, add) {
  if (group.length === 1) { add({ finding: group[0], draw: () => findingRow(group[0]) }, heightOf(group[0].message)); return; }
  const open = list.open.has(groupName(group[0]));
  add({ draw: () => groupRow(group) }, heightOf(`${group.length} × ${state.report.groups[group[0].group].sentence}`));
  // A line that says there is one more takes as much room as that one.
  const few = group.length <= PLACES + 1;
  for (const finding of open || few ? group : group.slice(0, PLACES)) add({ finding, draw: () => memberRow(finding) }, LINE);
  if (!few) add({ draw: () => moreRow(group, open) }, LINE);
}

function drawRows() {
  const { scrollTop, clientHeight } = list.element;
  let from = firstAfter(scrollTop - 200), to = firstAfter(scrollTop + clientHeight + 200);
  from = Math.max(from - 1, 0);
  for (const [at, element] of list.drawn) if (at < from || at >= to) { element.remove(); list.drawn.delete(at); }
  for (let at = from; at < to; at++) {
    if (list.drawn.has(at)) continue;
    const row = list.rows[at];
    const element = row.draw();
    element.style.height = `${row.height}px`;
    element.style.transform = `translateY(${list.top[at]}px)`;
    list.drawn.set(at, element);
    list.inner.append(element);
  }
}

/** The first row that starts below a height. */
function firstAfter(y) {
  let low = 0, high = list.top.length;
  while (low < high) { const middle = (low + high) >> 1; if (list.top[middle] <= y) low = middle + 1; else high = middle; }
  return low;
}

function headRow(ofRule) {
  const [{ severity }, rule, count] = [ofRule[0], ruleOf(ofRule[0]), ofRule.length];
  const requirement = state.report.requirements.find((one) => one.id === rule);
  const title = make('span', { class: 'head-title' }, requirement?.title ?? '');
  const name = requirement?.documented
    ? make('button', { type: 'button', class: 'link', title: 'What the rule requires', onclick: () => showRule(rule) }, rule) : rule;
  return make('div', { class: 'row head', role: 'presentation' }, make('span', { class: 'head-id' }, name), title, make('span', { class: 'count' }, `${count.toLocaleString('en')} ${severity}${count === 1 ? '' : 's'}`));
}

const slugOf = (finding) => finding.code.slice(ruleOf(finding).length + 1);

/** What all findings of a group say, and how many they are. */
function groupRow(group) {
  const { severity, group: at } = group[0];
  const { sentence } = state.report.groups[at];
  return make('div', { class: 'row group', role: 'presentation', title: sentence, onclick: () => chooseFinding(group[0]) },
    make('span', { class: `dot ${severity}`, title: severity }),
    make('p', { class: 'message' }, make('b', {}, `${group.length.toLocaleString('en')} × `), sentence),
    make('p', { class: 'small' }, make('span', { class: 'slug' }, slugOf(group[0]))));
}

/** The attributes of a row that chooses a finding. */
const choosing = (finding, kind) => ({
  class: `row finding ${kind} ${finding.status ?? ''}`, role: 'option', id: `row-${finding.number}`, title: finding.message,
  'aria-selected': String(finding === state.finding), onclick: () => { chooseFinding(finding); list.element.focus({ preventScroll: true }); },
});
const subjectOf = ({ subject }) => (subject ? `${KIND_WORDS[subject[0]]} ${subject[1]}` : 'the map');
const statusOf = ({ status }) => (status && status !== 'same' ? make('span', { class: `status ${status}` }, status) : null);

function findingRow(finding) {
  return make('div', choosing(finding, 'whole'),
    make('span', { class: `dot ${finding.severity}`, title: finding.severity }),
    make('p', { class: 'message' }, finding.message),
    make('p', { class: 'small' }, make('span', { class: 'slug' }, slugOf(finding)), ` · ${subjectOf(finding)}`, statusOf(finding)));
}

/** A finding under the row of its group: what is its own. */
function memberRow(finding) {
  const { measure } = finding;
  return make('div', choosing(finding, 'member'), make('p', { class: 'small' }, subjectOf(finding), statusOf(finding)),
    measure && make('span', { class: 'small' }, amount(measure[0], measure[2])));
}

function moreRow(group, open) {
  const name = groupName(group[0]);
  const turn = () => { if (!list.open.delete(name)) list.open.add(name); layRows(); };
  return make('div', { class: 'row more', role: 'presentation' },
    make('button', { type: 'button', class: 'link', onclick: turn }, open ? 'Show fewer' : `Show ${(group.length - PLACES).toLocaleString('en')} more`));
}

/** How many there are of a code that is not shown. */
function countedRow(ofCode) {
  const { severity, code, group } = ofCode[0];
  const show = () => { state.filter.severity.add(severity); filter(); };
  const { sentence } = state.report.groups[group];
  return make('div', { class: 'row counted', role: 'presentation', title: `${code}: ${sentence}` },
    make('span', { class: `dot ${severity}`, title: severity }),
    make('button', { type: 'button', class: 'link', title: `Show the ${severity}s`, onclick: show }, ofCode.length.toLocaleString('en')),
    make('span', { class: 'slug' }, code), make('span', { class: 'said' }, sentence));
}

function markRow() {
  for (const [at, element] of list.drawn) {
    const { finding } = list.rows[at];
    if (finding) element.setAttribute('aria-selected', String(finding === state.finding));
  }
  if (state.finding) list.element.setAttribute('aria-activedescendant', `row-${state.finding.number}`);
  else list.element.removeAttribute('aria-activedescendant');
}

/** Scrolls no farther than needed to show the chosen row; opens its group. */
function scrollToChoice() {
  const { finding } = state;
  if (!finding || !state.shown.includes(finding)) return;
  const find = () => list.rows.findIndex((row) => row.finding === finding);
  if (find() < 0) { list.open.add(groupName(finding)); layRows(); }
  const at = find();
  const { scrollTop, clientHeight } = list.element;
  const top = list.top[at];
  if (top - HEAD < scrollTop) list.element.scrollTop = top - HEAD;
  else if (top + ROW > scrollTop + clientHeight) list.element.scrollTop = top + ROW - clientHeight + 8;
  drawRows();
  markRow();
}
