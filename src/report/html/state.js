// What the page knows and what is chosen; everything else listens.

const state = {
  report: null, map: null, index: null,
  /** Findings that pass the filters, in list order. */
  shown: [],
  /** Findings that pass all filters but that of the severity, in list order: they are counted. */
  counted: [],
  /** The chosen finding, or null. */
  finding: null,
  /** The chosen primitive { kind, number }, or null. */
  primitive: null,
  filter: { text: '', severity: new Set(), status: null, rule: null, inView: false, area: null },
};

const listeners = {};
/** Calls `listener` whenever `event` is told. */
function on(event, listener) { (listeners[event] ??= []).push(listener); }
/** What the listeners of an event answer, as one list. */
const asked = (event, detail) => (listeners[event] ?? []).flatMap((listener) => listener(detail) ?? []);
/** Tells everyone who listens. */
function tell(event, detail) { for (const listener of listeners[event] ?? []) listener(detail); }

const KINDS = ['point', 'line', 'polygon', 'lanelet', 'rule'];
const KIND_WORDS = {
  point: 'point', line: 'linestring', polygon: 'polygon', lanelet: 'lanelet', rule: 'regulatory element',
  node: 'node', way: 'way', relation: 'relation',
};
/** What an editor of OpenStreetMap files calls each kind. */
const OSM_KINDS = {
  point: 'node', line: 'way', polygon: 'way', lanelet: 'relation', rule: 'relation', node: 'node', way: 'way', relation: 'relation',
};

/** Makes an element. Text is only ever set as text: what a map says is never markup. */
function make(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value === null || value === undefined || value === false) continue;
    if (name.startsWith('on')) element.addEventListener(name.slice(2), value);
    else if (name === 'class') element.className = value;
    else element.setAttribute(name, value === true ? '' : value);
  }
  element.append(...children.filter((child) => child !== null && child !== undefined));
  return element;
}
const byId = (id) => document.getElementById(id);

/** Chooses a finding; the map flies there unless `stay`. */
function chooseFinding(finding, { stay = false } = {}) {
  state.finding = finding;
  state.primitive = null;
  setHash(finding ? `finding=${encodeLink(finding.key)}` : '');
  tell('choice', { stay });
}

/** Chooses a primitive of the map. */
function choosePrimitive(primitive, { stay = false } = {}) {
  state.finding = null;
  state.primitive = primitive;
  setHash(primitive ? `id=${state.map[primitive.kind].id[primitive.number]}` : '');
  tell('choice', { stay });
}

/** A key in an address, with the signs left readable that may stand there. */
const encodeLink = (text) => encodeURIComponent(text).replace(/%2F/g, '/').replace(/%40/g, '@').replace(/%3A/g, ':');

let ownHash = '';
function setHash(hash) {
  ownHash = hash ? `#${hash}` : '';
  if (location.hash !== ownHash) history.replaceState(null, '', ownHash || location.pathname + location.search);
}

let toastTimer = 0;
/** Says something for a moment. */
function toast(text) {
  const element = byId('toast');
  element.textContent = text;
  element.hidden = false;
  clearTimeout(toastTimer);
  toastTimer = setTimeout(() => { element.hidden = true; }, 2600);
}

/** Copies text, also where the clipboard interface is closed to files. */
async function copy(text) {
  try {
    await navigator.clipboard.writeText(text);
  } catch {
    const area = make('textarea', { class: 'offscreen' });
    area.value = text;
    document.body.append(area);
    area.select();
    document.execCommand('copy');
    area.remove();
  }
  toast(`Copied ${text}`);
}
