// What Autoware's planner will do on the chosen lanelet: whom it watches and ignores, where it stops.

/** The hues of the layer, as `draw --planner` has them. */
const PLAN = { own: '#2f9e6e', watched: '#e5484d', ignored: '#8b9198', stuck: '#f0a020', white: '#ffffff', red: '#ff5a5f', amber: '#ffc233', edge: '#12161b' };
/** Pixels per metre from which on marks have words. */
const PLAN_WORDS_FROM = 5;

/** The lanelet that was asked about, by id, and what is told of it. */
const plan = { id: null, forecast: null, shown: true };

on('start', () => {
  KEYS.push([['w'], 'What the planner will do on the chosen lanelet', togglePlan]);
  on('underlay', drawPlanLanes);
  on('overlay', drawPlanMarks);
  on('choice', askPlan);
  on('edit card', planCard);
});
on('data', () => { plan.id = null; });

function togglePlan() {
  plan.shown = !plan.shown;
  drawCard();
}

/** The id of the chosen lanelet if the planner sees an intersection in it. */
function plannedId() {
  const { primitive, map } = state;
  if (primitive?.kind !== 'lanelet' || !tagOf('lanelet', primitive.number, 'turn_direction')) return null;
  return String(map.lanelet.id[primitive.number]);
}

async function askPlan() {
  const id = plannedId();
  if (id === plan.id) return;
  Object.assign(plan, { id, forecast: null });
  if (!id) { markPlan(); return; }
  const response = await askServer('planner', { method: 'POST', body: id });
  const answer = await response.text();
  if (plan.id !== id) return;
  try { [plan.forecast] = JSON.parse(answer).lanelets; } catch { toast(answer); }
  drawCard();
}

/** Says on the page what the layer shows. */
function markPlan() {
  byId('map').dataset.plan = plan.forecast && plan.shown ? `${plan.forecast.watched.length} ${plan.forecast.ignored.length} ${plan.forecast.marks.length}` : '';
}

/** What is drawn now, or nothing. */
const shownPlan = () => (plan.shown && plan.id === plannedId() ? plan.forecast : null);

function drawPlanLanes({ pen }) {
  const forecast = shownPlan();
  markPlan();
  if (!forecast) return;
  const fill = (id, colour, strength, dash) => {
    const lanelet = findPrimitive(String(id), 'lanelet');
    if (!lanelet) return;
    pen.begin();
    pen.outline(lanelet.number);
    pen.context.globalAlpha = strength;
    pen.fill(colour);
    pen.context.globalAlpha = 1;
    if (dash !== undefined) pen.stroke(colour, 1.4 * pen.frame.ratio, dash && dash.map((length) => length * pen.frame.ratio));
  };
  const watched = new Set(forecast.watched.map((one) => one.lanelet));
  for (const id of new Set(forecast.watched.flatMap((one) => one.before))) if (!watched.has(id)) fill(id, PLAN.watched, 0.2);
  for (const id of watched) fill(id, PLAN.watched, 0.42, null);
  for (const one of forecast.ignored) fill(one.lanelet, PLAN.ignored, 0.45, [5, 3]);
  fill(forecast.lanelet, PLAN.own, 0.4, null);
  if (forecast.lines.stuck) {
    pen.begin();
    pen.ring(forecast.lines.stuck.outline.map(onPage));
    pen.context.globalAlpha = 0.35;
    pen.fill(PLAN.stuck);
    pen.context.globalAlpha = 1;
  }
}

/** A place of the map on the plane of the page. */
const onPage = ([x, y]) => [x - state.report.frame.origin[0], y - state.report.frame.origin[1]];

function drawPlanMarks({ pen, colours }) {
  const forecast = shownPlan();
  if (!forecast) return;
  const { ratio, css } = pen.frame;
  const taken = [];
  for (const { ends, what, hue } of forecast.marks) {
    const [[ax, ay], [bx, by]] = ends.map(onPage);
    const [dx, dy] = [(bx - ax) * 0.35, (by - ay) * 0.35];
    const line = [[ax - dx, ay - dy], [bx + dx, by + dy]];
    for (const [colour, width] of [[PLAN.edge, 5], [PLAN[hue], 2.4]]) {
      pen.begin();
      pen.path(line);
      pen.stroke(colour, width * ratio);
    }
    if (css < PLAN_WORDS_FROM) continue;
    // Words of marks that lie close together stand above each other.
    const [x, y] = [pen.px(line[0][0]) / ratio, pen.py(line[0][1]) / ratio];
    let lift = -12;
    while (taken.some(([u, v]) => Math.abs(u - x) < 110 && Math.abs(v - y - lift) < 15)) lift -= 15;
    taken.push([x, y + lift]);
    drawWords(pen, line[0][0], line[0][1], what, colours.ink, colours, lift);
  }
}

/** Below the tags: what is told, in words. */
function planCard() {
  const forecast = plan.id === plannedId() ? plan.forecast : null;
  if (!forecast) return [];
  const lane = (one) => [[swatch(one.because ? PLAN.ignored : PLAN.watched), part(one.turn ?? 'lane'), reference(['lanelet', String(one.lanelet)])],
    ...(one.element ? [[part('because of'), reference(['rule', String(one.element)])]] : [])];
  const show = make('button', { type: 'button', class: 'link', title: 'On the map (w)', onclick: togglePlan }, plan.shown ? 'hide' : 'show');
  return [make('div', { class: 'plan' },
    make('section', {}, make('h3', {}, 'The planner here ', show), make('p', {}, forecast.sentence)),
    ...[section('Watched', forecast.watched.flatMap(lane)), section('Ignored, and why', forecast.ignored.flatMap(lane)),
      section('Front of the vehicle, from the begin', forecast.places.map(([at, what]) => [part(`${at.toFixed(1)} m`), make('span', {}, what)]))].filter(Boolean))];
}
