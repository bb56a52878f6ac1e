// What each primitive looks like, by its tags, in light and in dark.

const PALETTES = {
  light: {
    ground: '#f3f2ee', road: '#868d97', shoulder: '#a3a8af', walk: '#ddd5c3', bicycle: '#a98a84', unknown: '#b9bdc2',
    box: '#79808a', boxEdge: '#c79a1b', seam: 'rgba(40,46,54,.22)', hatched: '#b4b8be', forbidden: 'rgba(205,70,80,.20)',
    watched: 'rgba(60,120,210,.18)', bump: 'rgba(220,180,60,.55)', lot: 'rgba(190,196,186,.6)', passage: 'rgba(176,146,104,.5)',
    left: '#e8a33d', straight: '#5aa9dd', right: '#42b883', crossing: 'rgba(52,58,66,.30)', zebra: 'rgba(255,255,255,.78)',
    paint: '#ffffff', yellow: '#ffc933', kerb: '#353b43', barrier: '#5b4b8a', virtual: 'rgba(236,243,252,.6)', other: '#8d6cc9', stop: '#e5383b',
    arrow: 'rgba(255,255,255,.62)', lamp: '#17191c', sign: '#2f6fd0', choice: '#1257d6', halo: '#ffffff', ink: '#20242a',
    parts: ['#7b3fe4', '#0b8f8c', '#c2410c', '#b8256e', '#3f6212', '#155e9c'],
    error: '#d92d3a', warning: '#dd7b07', info: '#2b74d8', preview: '#0d9a5c',
  },
  dark: {
    ground: '#14171b', road: '#3b424c', shoulder: '#30353d', walk: '#4a453a', bicycle: '#54413e', unknown: '#3a3e45',
    box: '#434b56', boxEdge: '#b48d25', seam: 'rgba(0,0,0,.35)', hatched: '#565c65', forbidden: 'rgba(226,92,100,.24)',
    watched: 'rgba(84,148,236,.24)', bump: 'rgba(220,180,60,.4)', lot: 'rgba(86,92,84,.5)', passage: 'rgba(146,118,82,.5)',
    left: '#d4902e', straight: '#4a98cf', right: '#38a775', crossing: 'rgba(0,0,0,.34)', zebra: 'rgba(226,231,238,.62)',
    paint: '#d9dee6', yellow: '#d9aa2b', kerb: '#8b95a3', barrier: '#9a87d8', virtual: 'rgba(180,200,226,.35)', other: '#a58be0', stop: '#ff6266',
    arrow: 'rgba(226,231,238,.5)', lamp: '#050607', sign: '#5a93ea', choice: '#7cb0ff', halo: '#14171b', ink: '#eef1f5',
    parts: ['#b793ff', '#3fd0c9', '#ff9d66', '#ff7fbb', '#a9d65c', '#6dbcff'],
    error: '#ff6470', warning: '#ffab40', info: '#69a9ff', preview: '#3ddc8f',
  },
};

/** The palette of the theme that is on. */
const palette = () => PALETTES[document.documentElement.dataset.theme === 'dark' ? 'dark' : 'light'];

/** Reads the tags of every set once: class of a lanelet, a line and a polygon. */
function classify(map) {
  const classes = { lanelet: [], line: [], polygon: [] };
  for (let set = 0; set < map.tagSets; set++) {
    const tags = new Map(map.pairs(set));
    classes.lanelet.push(laneletClass(tags));
    classes.line.push(lineClass(tags));
    classes.polygon.push(polygonClass(tags));
  }
  return classes;
}

/** Surface and turn of a lanelet. */
function laneletClass(tags) {
  const turn = ['left', 'straight', 'right'].find((word) => tags.get('turn_direction') === word) ?? null;
  const onlyBicycles = tags.get('participant:bicycle') === 'yes' && !tags.has('participant:vehicle');
  const surface = {
    road: onlyBicycles && !turn ? 'bicycle' : 'road', road_shoulder: 'shoulder', pedestrian_lane: 'walk', walkway: 'walk',
    bicycle_lane: 'bicycle', crosswalk: 'crossing',
  }[tags.get('subtype')] ?? 'unknown';
  return { surface, turn: surface === 'road' ? turn : null };
}

/** How a line is drawn: `colour` of the palette, width and dash in metres, least width in pixels; null for not as a line. */
function lineClass(tags) {
  const subtype = tags.get('subtype') ?? '';
  const line = (name, colour, width, least, dash = null, extra = {}) => ({ name, colour, width, least, dash, ...extra });
  const paint = tags.get('color') === 'yellow' ? 'yellow' : 'paint';
  const painted = (name, width, least) => {
    const sides = subtype.includes('_') ? subtype.split('_') : [subtype];
    const dashes = sides.map((word) => (word === 'dashed' ? PAINT.dash : null));
    return line(`${name} ${subtype} ${paint}`, paint, width, least, dashes[0], dashes.length === 2 ? { double: dashes } : {});
  };
  switch (tags.get('type')) {
    case 'line_thin': return painted('thin', PAINT.thin, 0.6);
    case 'line_thick': return painted('thick', PAINT.thick, 1);
    case 'guide_line': return line(`guide ${paint}`, paint, PAINT.thin, 0.6, PAINT.dash);
    case 'virtual': return line('virtual', 'virtual', 0.07, 0.6, [0.4, 0.4], { fine: true });
    case 'road_border': case 'curbstone': case 'road_boarder': return line('kerb', 'kerb', PAINT.kerb, 0.8, null, { coarse: true });
    case 'guard_rail': case 'wall': case 'fence': return line('barrier', 'barrier', 0.3, 1, [0.9, 0.25]);
    case 'stop_line': case 'yield_line': return line('stop', 'stop', 0.45, 1.4, null, { over: true });
    case 'pedestrian_marking': case 'zebra_marking': case 'bike_marking': return line('zebra-edge', 'zebra', 0.08, 0.5, null, { fine: true });
    case 'traffic_light': return { signal: 'light' };
    case 'light_bulbs': return { signal: 'bulbs' };
    case 'traffic_sign': return { signal: 'sign' };
    default: return line('other', 'other', 0.08, 0.6, null, { fine: true });
  }
}

/** The palette's colour of an area. */
function polygonClass(tags) {
  if (tags.get('type') === 'multipolygon' && tags.get('participant:vehicle') === 'yes') return 'passage';
  return {
    intersection_area: 'box', hatched_road_markings: 'hatched', no_stopping_area: 'forbidden', no_parking_area: 'forbidden',
    no_obstacle_segmentation_area: 'forbidden', no_obstacle_segmentation_area_for_run_out: 'forbidden', obstacle_removal_area: 'forbidden',
    detection_area: 'watched', crosswalk_polygon: 'crossing', speed_bump: 'bump',
  }[tags.get('type')] ?? 'lot';
}
