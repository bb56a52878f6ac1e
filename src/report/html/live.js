// A served page: fetches what it shows, and again when the server says that files changed.

/** Milliseconds until a server that does not answer is asked again. */
const AGAIN = 1500;

const live = { version: 0 };
/** Where not everybody may ask, the address has a token. */
const token = new URLSearchParams(location.search).get('token');
/** Asks the server that the page comes from. */
const askServer = (path, options = {}) => fetch(path, { cache: 'no-store', ...options, headers: { ...options.headers, ...(token ? { 'Lanewright-Token': token } : {}) } });

async function fetchBoth() {
  const response = await askServer('data');
  if (!response.ok) throw new Error(await response.text());
  live.version = Number(response.headers.get('Lanewright-Version'));
  return readParcel(await response.arrayBuffer());
}

on('start', () => {
  byId('title').textContent = state.report.title;
  watchChanges();
});

/** Asks what changed, over and over; the server answers when something did. */
async function watchChanges() {
  for (;;) {
    try {
      const response = await askServer(`changes?after=${live.version}`);
      const { version, error } = await response.json();
      say(error);
      if (version !== live.version && error) live.version = version;
      else if (version !== live.version) await changed();
    } catch {
      say('lanewright does not answer any more. Start it again, and this page goes on.');
      await new Promise((resolve) => { setTimeout(resolve, AGAIN); });
    }
    document.documentElement.dataset.version = String(live.version);
  }
}

/** Fetches and shows what is new; another part of the page may do it in its own way. */
let changed = async () => follow(await fetchBoth());

/** A line across the page that stays until it is no longer true. */
function say(text) {
  const banner = byId('banner');
  banner.hidden = !text;
  banner.textContent = text ?? '';
}
