// A review: the fixes that need review, one after another; what is decided, and saving it.

const review = {
  /** Number of the fix that is looked at, or null, and the key of its finding. */
  at: null, key: null,
  /** What would come of it, as the server said; or the reason why it cannot be told. */
  preview: null, trouble: null,
  /** Numbers of the fixes for which a reason is being typed, or null. */
  rejecting: null,
  busy: false,
};
const STATUS_WORDS = { open: '', later: 'later', accepted: 'accepted', rejected: 'rejected', gone: 'no longer needed' };

const reviewed = () => state.report.review;
const itemNow = () => (review.at === null ? null : reviewed().items[review.at]);
const isOpen = (item) => item.status === 'open' || item.status === 'later';
const toReview = () => reviewed().items.filter((item) => !item.safe && isOpen(item));
const kindOf = (item) => reviewed().items.filter((other) => other.kind === item.kind && isOpen(other));
const reviewShown = () => !byId('pane-review').hidden;

on('start', () => {
  startReviewPane();
  const keys = [
    [['n'], 'Review: next fix', () => stepReview(1)],
    [['p'], 'Review: previous fix', () => stepReview(-1)],
    [['y'], 'Review: accept the fix', () => accept()],
    [['Y'], 'Review: accept all fixes of this kind', () => accept(true)],
    [['x'], 'Review: reject the fix', () => askReason()],
    [['X'], 'Review: reject all fixes of this kind', () => askReason(true)],
    [['l'], 'Review: later', () => later()],
  ].map((entry) => [...entry, reviewShown]);
  KEYS.unshift(...keys, [['u'], 'Undo the last step of the review (Ctrl+Z)', () => act({ do: 'undo' })], [['w'], 'Save the review (Ctrl+S)', saveReview],
    [['d'], 'What saving would change', showDiff]);
  document.addEventListener('keydown', (event) => {
    if (!(event.ctrlKey || event.metaKey) || event.altKey || event.shiftKey) return;
    const key = event.key.toLowerCase();
    const typing = event.target.matches?.('input, select, textarea');
    if (key !== 's' && (key !== 'z' || typing)) return;
    event.preventDefault();
    if (key === 's') saveReview(); else act({ do: 'undo' });
  });
  on('data', followReview);
  on('shown elsewhere', (finding) => (finding && reviewShown() && finding === findingOf(itemNow()) ? [true] : []));
  on('tab', () => drawCard());
  on('card', ({ finding }) => reviewButton(finding));
  window.addEventListener('beforeunload', (event) => { if (reviewed().unsaved) event.preventDefault(); });
  lookAt(toReview()[0]?.id ?? null);
});

/** The finding that proposes a fix. */
function findingOf(item) {
  if (!item) return null;
  return state.report.findings.find((one) => one.code === item.code && one.fix === item.title && (one.subject?.[1] ?? null) === item.subject_id) ?? null;
}

/** Another version of the map: what is looked at stays if it is open, else the next one is. */
function followReview() {
  const item = itemNow();
  const elsewhere = state.primitive || (state.finding && state.finding.key !== review.key);
  lookAt(item && isOpen(item) ? item.id : nextOf(review.at ?? -1, 1)?.id ?? null, Boolean(elsewhere));
}

/** The next fix that needs a review, or the one before; those that were put off come last. */
function nextOf(at, step) {
  const open = toReview();
  const fresh = open.filter((item) => item.status === 'open');
  const queue = fresh.length ? fresh : open;
  return step > 0 ? queue.find((item) => item.id > at) ?? queue[0] : queue.findLast((item) => item.id < at) ?? queue.at(-1);
}

function stepReview(step) {
  const next = nextOf(review.at ?? -1, step);
  if (next) lookAt(next.id);
}

/** Shows a fix, and asks what would come of it; the map goes there unless `stay`. */
async function lookAt(id, stay = false) {
  Object.assign(review, { at: id, preview: null, trouble: null, rejecting: null });
  state.report.fix_previews = [];
  const item = itemNow();
  const finding = findingOf(item);
  review.key = finding?.key ?? null;
  if (item && !stay) chooseFinding(finding, { stay: !finding });
  drawReview();
  if (!item || !isOpen(item)) return;
  const map = state.map;
  const answer = await tellServer('review/preview', { item: id });
  if (review.at !== id || state.map !== map) return;
  if (answer.trouble) review.trouble = answer.trouble;
  else {
    review.preview = answer;
    if (finding) state.report.fix_previews = answer.changes.map((change) => ({ ...change, mends: [finding.number] }));
  }
  drawReview();
  ask();
}

/** Posts to the server; what it answers, or { trouble } with the reason. */
async function tellServer(path, content) {
  try {
    const response = await askServer(path, { method: 'POST', headers: { 'Content-Type': 'application/json' }, body: JSON.stringify(content) });
    if (!response.ok || response.headers.get('Content-Type').startsWith('text/plain')) return { trouble: await response.text() };
    return JSON.parse(await response.text());
  } catch (error) {
    return { trouble: `lanewright does not answer: ${error.message}` };
  }
}

/** Has something done; what it changes comes as another version of the map. */
async function act(action) {
  if (review.busy) return false;
  review.busy = true;
  byId('pane-review').classList.add('busy');
  const { said, trouble } = await tellServer('review/do', action);
  review.busy = false;
  byId('pane-review').classList.remove('busy');
  toast(trouble ?? said);
  byId('pane-review').dataset.said = trouble ?? said;
  return !trouble;
}

const numbersOf = (all) => (all ? kindOf(itemNow()) : [itemNow()]).map((item) => item.id);
function accept(all = false) { if (itemNow() && isOpen(itemNow())) act({ do: 'accept', items: numbersOf(all) }); }
function later() {
  const item = itemNow();
  if (!item || !isOpen(item)) return;
  review.at = nextOf(item.id, 1)?.id ?? item.id;
  act({ do: 'later', items: [item.id] });
}
function saveReview() { if (reviewed().unsaved) act({ do: 'save' }); else toast('Nothing to save'); }

/** Asks for the reason of a rejection. */
function askReason(all = false) {
  if (!itemNow() || !isOpen(itemNow())) return;
  review.rejecting = numbersOf(all);
  drawReview();
  byId('reason').focus();
}

async function reject(event) {
  event.preventDefault();
  const [items, reason] = [review.rejecting, byId('reason').value];
  if (items && await act({ do: 'reject', items, reason })) review.rejecting = null;
}

async function showDiff() {
  const { diff, trouble } = await tellServer('review/diff', {});
  const dialog = make('dialog', { class: 'diff', 'aria-label': 'What saving would change', onclose: () => dialog.remove() },
    make('button', { type: 'button', class: 'close', 'aria-label': 'Close', onclick: () => dialog.close() }, '×'),
    make('h2', {}, 'What saving would change'),
    make('pre', {}, ...(trouble ?? (diff || 'Nothing in the map’s files.')).split('\n').map((line) => make('span', { class: { '+': 'added', '-': 'removed' }[line[0]] }, `${line}\n`))));
  document.body.append(dialog);
  dialog.showModal();
}

/* The pane */

function startReviewPane() {
  const tab = make('button', { type: 'button', role: 'tab', id: 'tab-review', 'aria-controls': 'pane-review', 'aria-selected': 'false', onclick: () => showTab('review') }, 'Review');
  byId('tab-findings').before(tab);
  byId('side').append(make('div', { class: 'pane review', id: 'pane-review', role: 'tabpanel', 'aria-labelledby': 'tab-review', hidden: true }));
  byId('side').parentElement.classList.add('reviewing');
  TABS.unshift('review');
  showTab('review');
}

function drawReview() {
  const pane = byId('pane-review');
  const { items } = reviewed();
  const count = (status) => items.filter((item) => item.status === status).length;
  Object.assign(pane.dataset, { at: String(review.at), open: String(toReview().length), accepted: String(count('accepted')), rejected: String(count('rejected')), preview: review.preview ? 'yes' : '', unsaved: reviewed().unsaved ? 'yes' : '' });
  const scrolled = pane.querySelector('.fix-list')?.scrollTop ?? 0;
  const typed = byId('reason')?.value;
  pane.replaceChildren(reviewHead(), itemNow() ? fixNow(itemNow()) : nothingLeft(), fixList(), stepList());
  pane.querySelector('.fix-list').scrollTop = scrolled;
  if (review.rejecting && typed) byId('reason').value = typed;
}

const plainButton = (id, label, title, onclick, disabled = false) => make('button', { type: 'button', id, class: 'chip', title, onclick, disabled }, label);

function reviewHead() {
  const { counts: [before, after], unsaved, can_undo: canUndo, items } = reviewed();
  const decided = items.filter((item) => !item.safe && !isOpen(item)).length;
  const all = items.filter((item) => !item.safe).length;
  const change = (at, word) => make('span', {}, `${word} ${before[at]}${before[at] === after[at] ? '' : ` → ${after[at]}`}`);
  return make('section', { class: 'review-head' },
    make('p', {}, make('b', {}, `${decided} of ${all} decided`), change(0, 'errors'), change(1, 'warnings')),
    make('progress', { max: String(Math.max(all, 1)), value: String(decided), 'aria-label': 'Decided' }),
    make('p', { class: 'chips' },
      make('button', { type: 'button', id: 'save', class: 'chip main', disabled: !unsaved, title: 'Write the map and the baseline (Ctrl+S)', onclick: saveReview }, 'Save'),
      plainButton('undo', 'Undo', 'Go back to the state before the last step (u)', () => act({ do: 'undo' }), !canUndo),
      plainButton('diff', 'Changes', 'What saving would change in the files (d)', showDiff, !unsaved),
      plainButton('reload', 'Reload', 'Read the files again and make the decisions on what they say now', () => act({ do: 'reload' }))));
}

function nothingLeft() {
  return make('section', { class: 'fix-now' }, make('p', {}, toReview().length ? 'Choose a fix in the list.' : 'No fix that needs a review is left.'));
}

/** The fix that is looked at. */
function fixNow(item) {
  const { preview, trouble } = review;
  const list = (title, rows) => (rows?.length ? make('div', {}, make('h3', {}, title), make('ul', { class: 'plain' }, ...rows.map((row) => make('li', {}, row)))) : null);
  const changes = preview?.changes.map((change) => make('span', {}, reference(change.subject), ` ${change.facts.join('; ')}`));
  return make('section', { class: 'fix-now', id: 'fix-now' },
    make('p', { class: 'kind' }, make('span', { class: `dot ${item.severity}` }), make('span', { class: 'code' }, item.code), item.subject,
      item.status === 'open' ? null : make('span', { class: 'status' }, STATUS_WORDS[item.status])),
    make('h2', {}, item.title),
    decisionButtons(item),
    review.rejecting && reasonForm(),
    make('dl', { class: 'why' }, make('dt', {}, 'Why'), make('dd', {}, item.message),
      item.assumes && make('dt', {}, 'Takes for granted'), item.assumes && make('dd', {}, item.assumes),
      item.reason && make('dt', {}, 'Rejected because'), item.reason && make('dd', {}, item.reason)),
    preview?.refused || trouble ? make('p', { class: 'trouble' }, trouble ?? `It would not be kept: ${preview.refused}`) : null,
    pictures(preview, item),
    isOpen(item) && !preview && !trouble ? make('p', { class: 'small' }, 'Trying it…') : null,
    list('Changes', changes), list('Makes as well', preview?.also), list('Brings', preview?.brings),
    list('Autoware before and after', preview?.planner.flatMap(([then, now]) => [`before: ${then}`, `after: ${now}`])),
    make('p', { class: 'actions' }, make('button', { type: 'button', onclick: () => showRule(ruleOf(item)) }, 'What the rule requires')));
}

function decisionButtons(item) {
  if (!isOpen(item)) return null;
  const alike = kindOf(item).length;
  return make('p', { class: 'chips' },
    make('button', { type: 'button', id: 'accept', class: 'chip main', title: 'y', disabled: Boolean(review.preview?.refused), onclick: () => accept() }, 'Accept'),
    plainButton('reject', 'Reject', 'x', () => askReason()),
    plainButton('later', 'Later', 'l', later),
    plainButton('previous', '‹', 'Previous (p)', () => stepReview(-1)), plainButton('next', '›', 'Next (n)', () => stepReview(1)),
    alike > 1 ? plainButton('accept-kind', `Accept all ${alike} of this kind`, 'Shift+Y', () => accept(true)) : null,
    alike > 1 ? plainButton('reject-kind', 'Reject them', 'Shift+X', () => askReason(true)) : null);
}

function reasonForm() {
  const many = review.rejecting.length > 1 ? ` of ${review.rejecting.length} fixes` : '';
  return make('form', { class: 'fields', onsubmit: reject },
    make('label', {}, make('span', {}, `Reason${many}`), make('input', { id: 'reason', type: 'text', required: true, autocomplete: 'off', placeholder: 'for colleagues and CI' })),
    make('p', { class: 'chips' }, make('button', { type: 'submit', id: 'reject-now', class: 'chip main' }, 'Reject'),
      plainButton('keep-open', 'Cancel', 'Leave it open', () => { review.rejecting = null; drawReview(); })));
}

/** The place before and after; a click shows both large. */
function pictures(preview, item) {
  if (!preview?.pictures) return null;
  const figure = (svg, caption) => make('figure', {}, make('img', { src: `data:image/svg+xml;charset=utf-8,${encodeURIComponent(svg)}`, alt: `${item.title}: ${caption}` }), make('figcaption', {}, caption));
  const both = () => [figure(preview.pictures[0], 'Before'), figure(preview.pictures[1], 'After')];
  const enlarge = () => {
    const dialog = make('dialog', { class: 'pair', 'aria-label': 'Before and after', onclick: () => dialog.close(), onclose: () => dialog.remove() }, ...both());
    document.body.append(dialog);
    dialog.showModal();
  };
  return make('button', { type: 'button', class: 'pair', title: 'Larger', onclick: enlarge }, ...both());
}

/** All fixes by kind, with what was decided. */
function fixList() {
  const kinds = new Map();
  for (const item of reviewed().items) if (!item.safe) kinds.set(item.kind, [...(kinds.get(item.kind) ?? []), item]);
  const safe = reviewed().items.filter((item) => item.safe && isOpen(item));
  const row = (item) => make('li', {}, make('button', {
    type: 'button', class: `fix-row ${item.status}`, 'aria-pressed': String(item.id === review.at), onclick: () => lookAt(item.id),
  }, make('span', { class: `dot ${item.severity}` }), make('span', {}, item.subject), make('span', { class: 'small' }, STATUS_WORDS[item.status])));
  const groups = [...kinds.values()].map((items) => make('li', { class: 'fix-kind' }, make('p', { class: 'small' }, make('b', {}, items[0].code), ` ${items[0].kind.slice(items[0].code.length + 2)}`), make('ul', {}, ...items.map(row))));
  return make('div', { class: 'fix-list' }, make('h3', {}, 'Fixes that need a review'), make('ul', {}, ...groups),
    safe.length ? make('h3', {}, 'Safe fixes') : null,
    safe.length ? make('p', { class: 'chips' }, plainButton('accept-safe', `Accept all ${safe.length}`, 'As `lanewright fix` makes them without asking', () => act({ do: 'accept', items: safe.map((item) => item.id) }))) : null);
}

function stepList() {
  const { steps, baseline } = reviewed();
  return make('details', { class: 'step-list' }, make('summary', {}, plural(steps.length, 'step')), make('ol', {}, ...steps.map((step) => make('li', {}, step))),
    make('p', { class: 'small' }, `Saving writes rejected fixes with their reasons into ${baseline}.`));
}

/** On the card of a finding: to the review of its fix. */
function reviewButton(finding) {
  const item = finding?.fix && reviewed().items.find((one) => isOpen(one) && findingOf(one) === finding);
  return item ? [make('p', { class: 'actions' }, make('button', { type: 'button', onclick: () => { showTab('review'); lookAt(item.id); } }, 'Review this fix'))] : [];
}
