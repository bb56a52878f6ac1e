// The list of findings. Only rows in sight exist, so a hundred thousand findings scroll like ten.

const ROW = 66;
const HEAD = 36;

const list = { element: null, inner: null, rows: [], top: [], drawn: new Map() };

function startList() {
  list.element = byId('list');
  list.inner = make('div', { class: 'rows', role: 'presentation' });
  list.element.append(list.inner);
  list.element.addEventListener('scroll', drawRows, { passive: true });
  new ResizeObserver(drawRows).observe(list.element);
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

/** Headings and findings with where each starts. */
function layRows() {
  list.rows = [];
  list.top = [];
  let y = 0, rule = null;
  const add = (row, height) => { list.rows.push(row); list.top.push(y); y += height; };
  const counts = new Map();
  for (const finding of state.shown) counts.set(ruleOf(finding), (counts.get(ruleOf(finding)) ?? 0) + 1);
  for (const finding of state.shown) {
    if (ruleOf(finding) !== rule) { rule = ruleOf(finding); add({ rule, count: counts.get(rule) }, HEAD); }
    add({ finding }, ROW);
  }
  list.inner.style.height = `${y}px`;
  list.element.dataset.count = String(state.shown.length);
  list.drawn.clear();
  list.inner.replaceChildren();
  list.element.classList.toggle('empty', !state.shown.length);
  list.element.dataset.empty = state.report.findings.length ? 'No finding passes the filters.' : 'No findings. Nothing to mend.';
  drawRows();
}

function drawRows() {
  const { scrollTop, clientHeight } = list.element;
  let from = firstAfter(scrollTop - 200), to = firstAfter(scrollTop + clientHeight + 200);
  from = Math.max(from - 1, 0);
  for (const [at, element] of list.drawn) if (at < from || at >= to) { element.remove(); list.drawn.delete(at); }
  for (let at = from; at < to; at++) {
    if (list.drawn.has(at)) continue;
    const row = list.rows[at];
    const element = row.finding ? findingRow(row.finding) : headRow(row);
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

function headRow({ rule, count }) {
  const requirement = state.report.requirements.find((one) => one.id === rule);
  const title = make('span', { class: 'head-title' }, requirement?.title ?? '');
  const name = requirement?.documented
    ? make('button', { type: 'button', class: 'link', title: 'What the rule requires', onclick: () => showRule(rule) }, rule) : rule;
  return make('div', { class: 'row head', role: 'presentation' }, make('span', { class: 'head-id' }, name), title, make('span', { class: 'count' }, String(count)));
}

function findingRow(finding) {
  const subject = finding.subject ? `${KIND_WORDS[finding.subject[0]]} ${finding.subject[1]}` : 'the map';
  const slug = finding.code.slice(ruleOf(finding).length + 1);
  return make('div', {
    class: `row finding ${finding.status ?? ''}`, role: 'option', id: `row-${finding.number}`, title: finding.message,
    'aria-selected': String(finding === state.finding), onclick: () => { chooseFinding(finding); list.element.focus({ preventScroll: true }); },
  },
  make('span', { class: `dot ${finding.severity}`, title: finding.severity }),
  make('p', { class: 'message' }, finding.message),
  make('p', { class: 'small' }, make('span', { class: 'slug' }, slug), ` · ${subject}`,
    finding.status && finding.status !== 'same' ? make('span', { class: `status ${finding.status}` }, finding.status) : null));
}

function markRow() {
  for (const [at, element] of list.drawn) {
    const { finding } = list.rows[at];
    if (finding) element.setAttribute('aria-selected', String(finding === state.finding));
  }
  if (state.finding) list.element.setAttribute('aria-activedescendant', `row-${state.finding.number}`);
  else list.element.removeAttribute('aria-activedescendant');
}

/** Scrolls no farther than needed to show the chosen row. */
function scrollToChoice() {
  const at = state.finding ? list.rows.findIndex((row) => row.finding === state.finding) : -1;
  if (at < 0) return;
  const { scrollTop, clientHeight } = list.element;
  const top = list.top[at];
  if (top - HEAD < scrollTop) list.element.scrollTop = top - HEAD;
  else if (top + ROW > scrollTop + clientHeight) list.element.scrollTop = top + ROW - clientHeight + 8;
  drawRows();
  markRow();
}
