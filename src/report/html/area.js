// A rectangle drawn on the map: only findings in it are shown.

/** A rectangle with a side shorter than this, in pixels, was a slip of the hand. */
const LEAST_AREA = 6;

const area = { armed: false, drawn: null };

function startArea() {
  grips.push((event) => (event.shiftKey || area.armed ? areaGrip(event.offsetX, event.offsetY) : null));
  on('underlay', drawArea);
  on('data', (before) => {
    const [from, to] = [before.frame.origin, state.report.frame.origin];
    state.filter.area = state.filter.area?.map((v, i) => v + from[i % 2] - to[i % 2]) ?? null;
  });
}

/** Shows only what lies in a box [minX, minY, maxX, maxY] of the map, or all again. */
function chooseArea(box) {
  armArea(false);
  if (!box && !state.filter.area) return;
  state.filter.area = box;
  filter();
  ask();
}

/** The next drag draws an area. */
function armArea(armed = true) {
  area.armed = armed;
  view.canvas.classList.toggle('drawing', armed);
  drawChips();
}

function areaGrip(x, y) {
  const from = toWorld(x, y);
  const box = (to) => [Math.min(from[0], to[0]), Math.min(from[1], to[1]), Math.max(from[0], to[0]), Math.max(from[1], to[1])];
  return {
    move(u, v) { area.drawn = box(toWorld(u, v)); ask(); },
    drop(u, v) {
      area.drawn = null;
      if (Math.min(Math.abs(u - x), Math.abs(v - y)) >= LEAST_AREA) chooseArea(box(toWorld(u, v)));
      else { armArea(false); ask(); }
    },
    cancel() { area.drawn = null; ask(); },
  };
}

function drawArea({ pen, colours }) {
  const box = area.drawn ?? state.filter.area;
  view.canvas.dataset.area = box ? box.map((v) => v.toFixed(2)).join(' ') : '';
  if (!box) return;
  const [minX, minY, maxX, maxY] = box;
  pen.begin();
  pen.ring([[minX, minY], [maxX, minY], [maxX, maxY], [minX, maxY]]);
  pen.context.globalAlpha = 0.08;
  pen.fill(colours.choice);
  pen.context.globalAlpha = 1;
  pen.stroke(colours.choice, 1.6 * pen.frame.ratio, [6 * pen.frame.ratio, 4 * pen.frame.ratio]);
}

/** The button that draws an area, or leaves the one that is drawn. */
function areaChip() {
  if (state.filter.area) return chip('In the area ×', true, () => chooseArea(null), { title: 'Show findings outside of the drawn area, too (Esc)' });
  return chip('Area', area.armed, () => armArea(!area.armed), { title: 'Draw an area on the map; only its findings are shown (a, or drag with Shift)' });
}
