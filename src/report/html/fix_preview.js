// What fixes would change, dashed over the map as it would be then.

const fixPreviews = { shown: true };

on('start', () => {
  KEYS.push([['g'], 'What fixes would change', toggleFixPreviews]);
  on('overlay', drawFixPreviews);
  on('chips', () => (state.report.fix_previews.length ? [chip(plural(state.report.fix_previews.length, 'fix preview'), fixPreviews.shown, toggleFixPreviews, {
    title: 'What `lanewright fix` would change, dashed on the map (g)',
  })] : []));
  on('card', fixPreviewCard);
});

function toggleFixPreviews() {
  fixPreviews.shown = !fixPreviews.shown;
  drawChips();
  ask();
}

/** The previews of the chosen finding's fix alone, or else of all findings that the list shows. */
function wantedFixPreviews() {
  if (!fixPreviews.shown) return [];
  const all = state.report.fix_previews;
  if (state.finding) return all.filter((preview) => preview.mends.includes(state.finding.number));
  const listed = new Set((state.shown ?? []).map((finding) => finding.number));
  return all.filter((preview) => !preview.mends.length || preview.mends.some((number) => listed.has(number)));
}

function drawFixPreviews({ pen, colours }) {
  const { ratio } = pen.frame;
  const [minX, maxY] = toWorld(0, 0), [maxX, minY] = toWorld(view.width, view.height);
  let drawn = 0;
  for (const preview of wantedFixPreviews()) {
    const box = preview.box ??= preview.shape.reduce((sum, [, points]) => { for (const [x, y] of points) grow(sum, x, y); return sum; }, emptyBox());
    if (box[0] > maxX || box[1] > maxY || box[2] < minX || box[3] < minY) continue;
    const main = state.finding && preview.mends.includes(state.finding.number);
    const colour = preview.change === 'removed' ? colours.error : colours.preview;
    for (const [closed, points] of preview.shape) {
      pen.begin();
      if (closed) pen.ring(points); else pen.path(points);
      pen.stroke(colours.halo, (main ? 6 : 4.4) * ratio, null, 'round');
      pen.stroke(colour, (main ? 3.4 : 2.2) * ratio, [7 * ratio, 4 * ratio]);
    }
    drawn++;
  }
  view.canvas.dataset.fixPreviews = String(drawn);
}

/** What would become of the primitives that the chosen finding's fix reaches for, or of the chosen primitive. */
function fixPreviewCard({ finding, primitive }) {
  const id = primitive && String(state.map[primitive.kind].id[primitive.number]);
  const about = state.report.fix_previews.filter((preview) => (finding ? preview.mends.includes(finding.number)
    : preview.subject[0] === primitive.kind && preview.subject[1] === id));
  if (!about.length) return [];
  const rows = about.map((preview) => [reference(preview.subject), make('span', { class: 'becomes' }, `${preview.change}: ${preview.facts.join('; ')}`)]);
  const title = finding ? 'What the fix changes (dashed)' : 'What fixes would change (dashed)';
  return [make('div', { class: 'fix-previews' }, section(title, rows))];
}
