// What fixes would change, dashed over the map as it would be then.

const ghosts = { shown: true };

on('start', () => {
  KEYS.push([['g'], 'What fixes would change', toggleGhosts]);
  on('overlay', drawGhosts);
  on('chips', () => (state.report.ghosts.length ? [chip(plural(state.report.ghosts.length, 'fix preview'), ghosts.shown, toggleGhosts, {
    title: 'What `lanewright fix` would change, dashed on the map (g)',
  })] : []));
  on('card', ghostCard);
});

function toggleGhosts() {
  ghosts.shown = !ghosts.shown;
  drawChips();
  ask();
}

/** The previews of the chosen finding's fix alone, or else of all findings that the list shows. */
function wantedGhosts() {
  if (!ghosts.shown) return [];
  const all = state.report.ghosts;
  if (state.finding) return all.filter((ghost) => ghost.mends.includes(state.finding.number));
  const listed = new Set((state.shown ?? []).map((finding) => finding.number));
  return all.filter((ghost) => !ghost.mends.length || ghost.mends.some((number) => listed.has(number)));
}

function drawGhosts({ pen, colours }) {
  const { ratio } = pen.frame;
  const [minX, maxY] = toWorld(0, 0), [maxX, minY] = toWorld(view.width, view.height);
  let drawn = 0;
  for (const ghost of wantedGhosts()) {
    const box = ghost.box ??= ghost.shape.reduce((sum, [, points]) => { for (const [x, y] of points) grow(sum, x, y); return sum; }, emptyBox());
    if (box[0] > maxX || box[1] > maxY || box[2] < minX || box[3] < minY) continue;
    const main = state.finding && ghost.mends.includes(state.finding.number);
    const colour = ghost.change === 'removed' ? colours.error : colours.ghost;
    for (const [closed, points] of ghost.shape) {
      pen.begin();
      if (closed) pen.ring(points); else pen.path(points);
      pen.stroke(colours.halo, (main ? 6 : 4.4) * ratio, null, 'round');
      pen.stroke(colour, (main ? 3.4 : 2.2) * ratio, [7 * ratio, 4 * ratio]);
    }
    drawn++;
  }
  view.canvas.dataset.ghosts = String(drawn);
}

/** What would become of the primitives that the chosen finding's fix reaches for, or of the chosen primitive. */
function ghostCard({ finding, primitive }) {
  const id = primitive && String(state.map[primitive.kind].id[primitive.number]);
  const about = state.report.ghosts.filter((ghost) => (finding ? ghost.mends.includes(finding.number)
    : ghost.subject[0] === primitive.kind && ghost.subject[1] === id));
  if (!about.length) return [];
  const rows = about.map((ghost) => [reference(ghost.subject), make('span', { class: 'becomes' }, `${ghost.change}: ${ghost.facts.join('; ')}`)]);
  const title = finding ? 'What the fix changes (dashed)' : 'What fixes would change (dashed)';
  return [make('div', { class: 'ghosts' }, section(title, rows))];
}
