// The pane of the stages: which is shown, what its colours mean, the chosen road with what can be changed, the edits.

/** Tags of a road that have a field of their own: [key, what stands in an empty field]. */
const FIELDS = [['lanes', ''], ['lanes:forward', ''], ['lanes:backward', ''], ['width', 'metres'], ['oneway', 'yes, no or -1']];

function startPanel() {
  const tab = make('button', { type: 'button', role: 'tab', id: 'tab-stages', 'aria-controls': 'pane-stages', 'aria-selected': 'false', onclick: () => showTab('stages') }, 'Stages');
  const pane = make('div', { class: 'pane stages', id: 'pane-stages', role: 'tabpanel', 'aria-labelledby': 'tab-stages', hidden: true });
  byId('tab-findings').before(tab);
  byId('side').append(pane);
  TABS.unshift('stages');
  showTab('stages');
  for (const event of ['stage', 'built', 'way', 'data']) on(event, drawPanel);
  drawPanel();
}

function drawPanel() {
  const pane = byId('pane-stages');
  const focused = document.activeElement?.id;
  const scrolled = pane.scrollTop;
  pane.replaceChildren(stageList(), editorState(), editor.way ? wayPanel(editor.byId.get(editor.way)) : hint(), editList());
  pane.scrollTop = scrolled;
  if (focused && pane.querySelector(`#${CSS.escape(focused)}`)) byId(focused).focus();
}

function stageList() {
  const stage = allStages()[stages.at];
  const rows = allStages().map(({ name, title }, at) => make('li', {}, make('button', {
    type: 'button', id: `stage-${name}`, class: 'stage-row', 'aria-pressed': String(at === stages.at), onclick: () => showStage(at),
  }, make('kbd', {}, String(at + 1)), make('b', {}, name), make('span', {}, title))));
  const key = stage.key.map(([names, word]) => {
    const look = lookOf(names);
    const mark = swatch(palette()[look.fill ?? look.stroke] ?? look.fill ?? look.stroke);
    return make('span', {}, mark, word);
  });
  return make('section', {}, make('ol', { class: 'stage-list' }, ...rows), make('p', { class: 'stage-key' }, ...key));
}

function editorState() {
  const { part, took } = workshop();
  const words = editor.took ? `Built in ${editor.took.build} ms, on the screen after ${editor.took.all} ms.` : `Built in ${took} ms.`;
  return make('section', { class: 'editor' },
    make('p', { class: editor.trouble ? 'trouble' : 'small', id: 'editor-state', role: 'status' }, editor.trouble ?? words),
    part && make('p', { class: 'small' }, `Only what lies around here is built: ${part.ways.toLocaleString('en')} of ${part.of.toLocaleString('en')} ways, inside the dashed frame. Move the map to build elsewhere.`));
}

const hint = () => make('p', { class: 'small hint' }, 'Click a road to change it. Drag a node to move it. The input file is not written to.');

/* The chosen road */

function wayPanel({ id, tags }) {
  const own = new Map(tags);
  const fields = FIELDS.map(([key, placeholder]) => make('label', {}, make('span', {}, key), make('input', {
    id: `tag-${key}`, type: 'text', value: own.get(key) ?? '', placeholder, autocomplete: 'off', spellcheck: 'false',
    onchange: (event) => setTag(id, key, event.target.value, own.get(key)),
  })));
  const others = tags.filter(([key]) => !FIELDS.some(([field]) => field === key));
  const roads = workshop().roads.filter((road) => road.way === id);
  return make('section', { class: 'road', id: 'road' },
    make('button', { type: 'button', class: 'close', 'aria-label': 'Close', onclick: () => chooseWay(null) }, '×'),
    make('h3', {}, `way ${id}`, make('span', { class: 'small' }, ` ${own.get('name') ?? own.get('ref') ?? ''}`)),
    make('form', { class: 'fields', onsubmit: (event) => { event.preventDefault(); document.activeElement?.blur(); } }, ...fields),
    ...roads.map(roadRow),
    tagTable(others));
}

function setTag(way, key, text, before) {
  const value = text.trim() || null;
  if (value !== (before ?? null)) commit({ edit: 'tag', way, key, value });
}

/** A road of the way: inside an intersection or not, why, and who is to decide. */
function roadRow({ ends, merged, why }) {
  const decided = madeEdits().findLast((edit) => edit.edit === 'merge' && edit.nodes.join() === ends.join());
  const choice = decided?.merge ?? null;
  const button = (label, merge, title) => make('button', {
    type: 'button', class: 'chip', 'aria-pressed': String(choice === merge), title, 'data-merge': String(merge),
    onclick: () => { if (choice !== merge) commit({ edit: 'merge', nodes: ends, merge }); },
  }, label);
  return make('div', { class: 'decision', 'data-merged': String(merged), 'data-ends': ends.join(' ') },
    make('p', {}, make('b', {}, merged ? 'Inside an intersection' : 'A road of its own'), ` · nodes ${ends[0]} to ${ends[1]}`),
    why && make('p', { class: 'small why' }, why),
    make('p', { class: 'chips' }, button('As found', null, 'Let the program decide'), button('Merge', true, 'It lies inside an intersection'),
      button('Keep apart', false, 'It does not lie inside an intersection')));
}

/* Edits */

function wordsOf(edit) {
  if (edit.edit === 'move') return `node ${edit.node} to ${edit.lat.toFixed(7)}, ${edit.lon.toFixed(7)}`;
  if (edit.edit === 'tag') return `way ${edit.way}: ${edit.key}${edit.value === null ? ' removed' : `=${edit.value}`}`;
  const what = edit.merge === null ? 'as found' : edit.merge ? 'merge' : 'keep apart';
  return `${what}: nodes ${edit.nodes.join(' to ')}`;
}

function editList() {
  const button = (id, label, enabled, onclick, title) => make('button', { type: 'button', id, class: 'chip', disabled: !enabled, onclick, title }, label);
  const made = madeEdits();
  const merges = made.some((edit) => edit.edit === 'merge');
  return make('section', { class: 'edits' }, make('h3', {}, made.length ? plural(made.length, 'edit') : 'Edits'),
    make('p', { class: 'chips' },
      button('undo', 'Undo', editor.at > 0, undo, 'Ctrl+Z'), button('redo', 'Redo', editor.at < editor.edits.length, redo, 'Ctrl+Y'),
      button('save-osm', 'Save .osm', made.length > 0, () => save('osm'), 'Download the input with the edits of nodes and tags'),
      button('save-toml', 'Save lanewright.toml', merges, () => save('toml'), 'Download the lines that merge and keep apart')),
    make('ol', { class: 'edit-list' }, ...editor.edits.map((edit, at) => make('li', { class: at < editor.at ? null : 'undone' }, wordsOf(edit)))));
}

/** Downloads what the edits make of the input, or of its lanewright.toml. */
async function save(what) {
  const response = await fetch(`save/${what}`, question());
  const name = response.headers.get('Lanewright-Name');
  if (!name) { toast(await response.text()); return; }
  const link = make('a', { href: URL.createObjectURL(await response.blob()), download: decodeURIComponent(name) });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
  toast(`${link.download}: put it where you want it; the input is as it was`);
}
