// Starts the page: reads the data, joins the parts, follows links, keys, theme and printing.

/** More findings than this are not printed. */
const MOST_PRINTED = 500;

function startTheme() {
  const dark = matchMedia('(prefers-color-scheme: dark)');
  const stored = () => { try { return localStorage.getItem('lanewright-theme'); } catch { return null; } };
  const apply = (theme) => { document.documentElement.dataset.theme = theme; if (state.map) tell('theme'); };
  apply(stored() ?? (dark.matches ? 'dark' : 'light'));
  dark.addEventListener('change', () => { if (!stored()) apply(dark.matches ? 'dark' : 'light'); });
  const turn = () => {
    const theme = document.documentElement.dataset.theme === 'dark' ? 'light' : 'dark';
    try { localStorage.setItem('lanewright-theme', theme); } catch { /* A page from a file may have no storage. */ }
    apply(theme);
  };
  byId('theme').addEventListener('click', turn);
}

/** Follows `#finding=…`, `#id=…` and `#rule=…`. */
function followLink() {
  if (location.hash === ownHash) return;
  const [, what, value] = location.hash.match(/^#(finding|id|rule)=(.*)$/) ?? [];
  let text = '';
  try { text = decodeURIComponent(value ?? ''); } catch { return; }
  if (what === 'finding') {
    const finding = state.report.findings.find((one) => one.key === text);
    if (finding) chooseFinding(finding); else toast('This report has no such finding');
  } else if (what === 'id') {
    const primitive = findPrimitive(text);
    if (primitive) choosePrimitive(primitive); else toast(`This map has nothing with the id ${text}`);
  } else if (what === 'rule') showRule(text);
}

/** What each key does: [keys, words, action, when it does]. */
const KEYS = [
  [['j', 'n'], 'Next finding', () => stepFinding(1)],
  [['k', 'p'], 'Previous finding', () => stepFinding(-1)],
  [['Enter'], 'Go to what is chosen', () => flyToChoice()],
  [['/'], 'Filter by text', () => { showTab('findings'); byId('search').focus(); byId('search').select(); }],
  [['Escape'], 'Deselect; then leave the drawn area', letGo],
  [['+', '='], 'Zoom in', () => zoomAt(1.5)],
  [['-'], 'Zoom out', () => zoomAt(1 / 1.5)],
  [['f'], 'Whole map', () => showBox(usualBox(state.index))],
  [['a'], 'Draw an area whose findings are shown (or drag with Shift)', () => armArea()],
  [['v'], 'Only findings in view', () => { state.filter.inView = !state.filter.inView; filter(); }],
  [['s'], 'Next tab: findings, requirements', () => showTab(TABS[(TABS.findIndex((name) => !byId(`pane-${name}`).hidden) + 1) % TABS.length])],
  [['r'], 'Page of the rule', () => { if (state.finding) showRule(ruleOf(state.finding)); }],
  [['c'], 'Copy the id', () => { const id = state.finding?.subject?.[1] ?? (state.primitive && String(state.map[state.primitive.kind].id[state.primitive.number])); if (id) copy(id); }],
  [['l'], 'Copy a link', () => copy(location.href)],
  [['t'], 'Light or dark', () => byId('theme').click()],
  [['?'], 'Keys', () => byId('keys').showModal()],
];

function startKeys() {
  byId('key-list').append(...KEYS.flatMap(([keys, words]) => [
    make('dt', {}, ...keys.map((key) => make('kbd', {}, { Escape: 'Esc' }[key] ?? key))), make('dd', {}, words),
  ]), make('dt', {}, make('kbd', {}, '← ↑ → ↓')), make('dd', {}, 'Move the map, or go through the list'));
  byId('keys').addEventListener('click', () => byId('keys').close());
  byId('help').addEventListener('click', () => byId('keys').showModal());
  document.addEventListener('keydown', (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || document.querySelector('dialog[open]')) return;
    const typing = event.target.matches?.('input, select, textarea');
    if (typing && event.key === 'Escape') { event.target.blur(); return; }
    // Enter and space press the button that has the focus.
    if (typing || (event.key === 'Enter' && event.target.matches?.('button, a'))) return;
    const entry = KEYS.find(([keys, , , when]) => keys.includes(event.key) && (when?.() ?? true));
    if (!entry) return;
    event.preventDefault();
    entry[2]();
  });
}

/** What paper shows: verdict, the map as it stands, every requirement, every finding. */
function preparePrint() {
  const { report } = state;
  const image = make('img', { alt: 'Map', src: byId('map').toDataURL('image/png') });
  const requirements = report.requirements.map((one) => make('tr', {}, make('td', {}, OUTCOMES[one.outcome].toReversed().join(' ')), make('td', {}, one.id), make('td', {}, one.title)));
  const findings = state.shown.slice(0, MOST_PRINTED).map((one) => make('tr', {}, make('td', {}, one.severity), make('td', {}, one.code),
    make('td', {}, one.subject ? one.subject.join(' ') : ''), make('td', {}, one.message)));
  const left = state.shown.length - findings.length;
  byId('print').replaceChildren(
    image,
    make('h2', {}, 'Requirements'), make('table', {}, make('tbody', {}, ...requirements)),
    make('h2', {}, 'Findings'), make('table', {}, make('tbody', {}, ...findings)),
    left > 0 ? make('p', {}, `${left} more are in the report itself.`) : '',
  );
}

/** Escape lets go of one thing at a time. */
function letGo() {
  if (state.finding || state.primitive) chooseFinding(null, { stay: true });
  else chooseArea(null);
}

/** Takes a report and a map as those that are shown. */
function take({ report, map }) {
  report.findings.forEach((finding, number) => { finding.number = number; });
  report.groups.forEach(({ members }, group) => { for (const number of members) report.findings[number].group = group; });
  Object.assign(state, { report, map, index: buildIndex(map) });
}

/** Shows another report and map; what was chosen stays chosen where it is still there. */
function follow(both) {
  const { report: before, finding, primitive, map } = state;
  take(both);
  tell('data', before);
  // A part of the page may have chosen something else meanwhile.
  if (state.finding !== finding || state.primitive !== primitive) return;
  if (finding) chooseFinding(state.report.findings.find((one) => one.key === finding.key) ?? null, { stay: true });
  else if (primitive) choosePrimitive(findPrimitive(map[primitive.kind].id[primitive.number], primitive.kind), { stay: true });
}

async function start() {
  startTheme();
  take(byId('map-data') ? await readBoth(bytesOf('report-data'), bytesOf('map-data')) : await fetchBoth());
  state.filter.severity = new Set(SEVERITIES.slice(0, SEVERITIES.indexOf(state.report.show) + 1));
  startSummary();
  startList();
  startCard();
  startView();
  startArea();
  startFilters();
  tell('start');
  startKeys();
  for (const name of ['findings', 'requirements']) byId(`tab-${name}`).addEventListener('click', () => showTab(name));
  filter();
  window.addEventListener('hashchange', followLink);
  window.addEventListener('beforeprint', preparePrint);
  followLink();
  document.documentElement.dataset.ready = String(Math.round(performance.now()));
}

start().catch((error) => {
  byId('verdict').textContent = `The report could not be opened: ${error.message}`;
  throw error;
});
