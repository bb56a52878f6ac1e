// Which findings are shown: text, severity, state against an earlier report, requirement, part of the map.

/** The worst first. */
const SEVERITIES = ['error', 'warning', 'info'];
const ruleOf = (finding) => finding.code.split('/')[0];
const plural = (count, word) => `${count.toLocaleString('en')} ${word}${count === 1 ? '' : 's'}`;

/** Everything of a finding that a search looks into, lower case; made once. */
function haystack(finding) {
  return (finding.words ??= [
    finding.message, finding.code, finding.subject?.join(' '), ...finding.related.map(([subject, part]) => `${subject.join(' ')} ${part}`),
  ].join('\n').toLowerCase());
}

function passes(finding, words, areas) {
  const { status, rule } = state.filter;
  if (status && !status.has(finding.status)) return false;
  if (rule && ruleOf(finding) !== rule) return false;
  for (const area of areas) {
    const at = spot(finding);
    if (!at || at[0] < area[0] || at[1] < area[1] || at[0] > area[2] || at[1] > area[3]) return false;
  }
  return words.every((word) => haystack(finding).includes(word));
}

/** Applies the filters and tells what is shown. */
function filter() {
  const words = state.filter.text.toLowerCase().split(/\s+/).filter(Boolean);
  const areas = [state.filter.inView ? [...toWorld(0, view.height), ...toWorld(view.width, 0)] : null, state.filter.area].filter(Boolean);
  const found = state.report.findings.filter((finding) => passes(finding, words, areas)).sort((a, b) => a.group - b.group || a.number - b.number);
  state.shown = found.filter((finding) => state.filter.severity.has(finding.severity));
  state.counted = found.filter((finding) => !state.filter.severity.has(finding.severity));
  tell('shown');
}

function startFilters() {
  byId('filters').addEventListener('submit', (event) => {
    event.preventDefault();
    const primitive = primitiveNamedBy(byId('search').value);
    if (primitive) choosePrimitive(primitive);
  });
  let timer = 0;
  byId('search').addEventListener('input', (event) => {
    clearTimeout(timer);
    timer = setTimeout(() => { state.filter.text = event.target.value; filter(); }, 90);
  });
  if (state.report.earlier !== null) state.filter.status = new Set(['new', 'same', 'gone']);
  on('moved', () => { if (state.filter.inView) filter(); });
  on('shown', drawChips);
  on('data', filter);
}

/** What a text names by its id, with or without its kind: `2500`, `lanelet 2500`, `way 17`; null if it names nothing of the map. */
function primitiveNamedBy(text) {
  const [, word, id] = /^\s*(?:([a-z ]+?)\s+)?#?(-?\d+)\s*$/i.exec(text) ?? [];
  if (!id) return null;
  const kind = word && Object.keys(KIND_WORDS).find((one) => [one, KIND_WORDS[one]].includes(word.toLowerCase()));
  return word && !kind ? null : findPrimitive(id, kind ?? null);
}

/** Shows only one requirement's findings, or all again. */
function onlyRule(rule) {
  state.filter.rule = rule;
  filter();
}

function chip(label, pressed, press, { dot = null, title = null } = {}) {
  return make('button', { type: 'button', class: 'chip', 'aria-pressed': String(pressed), onclick: press, title },
    dot && make('span', { class: `dot ${dot}` }), label);
}

/** Adds or takes out; the last one left is not taken out but stays alone. */
function toggle(set, value) {
  if (!set.delete(value)) set.add(value);
  filter();
}

function drawChips() {
  const { findings } = state.report;
  const { severity, status, rule, inView } = state.filter;
  const count = (test) => findings.reduce((sum, finding) => sum + (test(finding) ? 1 : 0), 0);
  const chips = [];
  for (const word of SEVERITIES) {
    const many = count((finding) => finding.severity === word);
    if (many) chips.push(chip(plural(many, word), severity.has(word), () => toggle(severity, word), { dot: word }));
  }
  for (const word of status ? ['new', 'same', 'gone'] : []) {
    chips.push(chip(`${count((finding) => finding.status === word)} ${word}`, status.has(word), () => toggle(status, word), {
      title: `Compared with ${state.report.earlier}`,
    }));
  }
  chips.push(chip('In view', inView, () => { state.filter.inView = !inView; filter(); }, { title: 'Only findings in the part of the map that is shown' }));
  chips.push(areaChip());
  if (rule) chips.push(chip(`${rule} ×`, true, () => onlyRule(null), { title: 'Show all requirements' }));
  const primitive = primitiveNamedBy(state.filter.text);
  if (primitive) {
    const name = `${wordOf(primitive)} ${state.map[primitive.kind].id[primitive.number]}`;
    chips.unshift(chip(`Go to ${name}`, false, () => choosePrimitive(primitive), { title: `Show ${name} (Enter)` }));
  }
  chips.push(...asked('chips'));
  const focused = [...byId('chips').children].indexOf(document.activeElement);
  byId('chips').replaceChildren(...chips);
  if (focused >= 0) chips[Math.min(focused, chips.length - 1)].focus();
}
