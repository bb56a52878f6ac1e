// How each requirement came out, in the standard's order, and the rule pages.

const OUTCOMES = {
  failed: ['failed', '✕'], warned: ['with warnings', '!'], passed: ['passed', '✓'], eyes: ['needs eyes', '◉'], skipped: ['skipped', '–'],
};

function startSummary() {
  drawSummary();
  on('data', drawSummary);
  for (const button of byId('rule-dialog').querySelectorAll('.close')) button.addEventListener('click', () => byId('rule-dialog').close());
  byId('rule-dialog').addEventListener('click', (event) => { if (event.target === event.currentTarget) event.currentTarget.close(); });
}

function drawSummary() {
  const { requirements, findings } = state.report;
  const pane = byId('pane-requirements');
  const count = (outcome) => requirements.filter((one) => one.standard && one.outcome === outcome).length;
  const tally = make('ul', { class: 'tally' }, ...Object.entries(OUTCOMES).map(([outcome, [word]]) => make('li', { class: outcome },
    make('b', {}, String(count(outcome))), word)));
  const counts = new Map();
  for (const finding of findings) {
    if (finding.status === 'gone') continue;
    const one = counts.get(ruleOf(finding)) ?? { error: 0, warning: 0, info: 0 };
    one[finding.severity]++;
    counts.set(ruleOf(finding), one);
  }
  const rows = [];
  let category = null;
  for (const requirement of requirements) {
    if (requirement.category !== category) rows.push(make('h3', {}, category = requirement.category));
    rows.push(requirementRow(requirement, counts.get(requirement.id)));
  }
  pane.replaceChildren(tally, ...rows);
  const standard = requirements.filter((one) => one.standard);
  drawVerdict(standard.filter((one) => one.outcome === 'failed').length, standard.length);
}

function requirementRow({ id, title, subtitle, outcome, partial, documented }, counts) {
  const [word, sign] = OUTCOMES[outcome];
  const numbers = Object.entries(counts ?? {}).filter(([, count]) => count)
    .map(([severity, count]) => make('span', { class: `number ${severity}`, title: plural(count, severity) }, String(count)));
  const filterTo = () => {
    for (const severity of SEVERITIES) if (counts[severity]) state.filter.severity.add(severity);
    showTab('findings');
    onlyRule(id);
  };
  return make('div', { class: `requirement ${outcome}`, 'data-rule': id },
    make('span', { class: 'sign', title: word, 'aria-label': word, role: 'img' }, sign),
    make('div', {},
      make('p', { class: 'requirement-title' }, documented
        ? make('button', { type: 'button', class: 'link plain', title: 'What it requires, why, how to mend', onclick: () => showRule(id) }, title) : title),
      subtitle ? make('p', { class: 'subtitle' }, subtitle) : null,
      make('p', { class: 'small' }, id, partial ? ' · judged in part' : '', outcome === 'eyes' ? ' · needs eyes' : outcome === 'skipped' ? ' · skipped' : '')),
    numbers.length ? make('button', { type: 'button', class: 'numbers', title: `Show the findings of ${id}`, onclick: filterTo }, ...numbers) : null);
}

function drawVerdict(failed, total) {
  const alive = state.report.findings.filter((finding) => finding.status !== 'gone');
  const words = SEVERITIES.map((word) => [word, alive.filter((finding) => finding.severity === word).length]).filter(([, count]) => count);
  const verdict = byId('verdict');
  verdict.replaceChildren(...(words.length
    ? words.map(([word, count]) => make('span', {}, make('span', { class: `dot ${word}` }), plural(count, word)))
    : [make('span', {}, make('span', { class: 'dot good' }), 'no findings')]));
  // An error may be of what no requirement speaks of: a map that does not load, a conflict of a merge.
  const others = !failed && alive.some((finding) => finding.severity === 'error');
  if (!others) verdict.append(make('span', { class: 'of' }, failed ? `${failed} of ${plural(total, 'requirement')} failed` : 'no requirement failed'));
}

/** Opens a rule's page. */
function showRule(id) {
  const page = byId(`rule-${id}`);
  if (!page) return;
  const dialog = byId('rule-dialog');
  for (const other of dialog.querySelectorAll('article')) other.hidden = other !== page;
  if (!dialog.open) dialog.showModal();
  dialog.scrollTop = 0;
}

const TABS = ['findings', 'requirements'];

function showTab(name) {
  for (const one of TABS) {
    byId(`tab-${one}`).setAttribute('aria-selected', String(one === name));
    byId(`pane-${one}`).hidden = one !== name;
  }
  if (name === 'findings') drawRows();
  tell('tab', name);
}
