// From the page's packed data to typed arrays and findings.

/** The bytes of a script element, which holds them as base64. */
function bytesOf(id) {
  const text = atob(byId(id).textContent);
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; i++) bytes[i] = text.charCodeAt(i);
  return bytes;
}

/** Undoes raw deflate. */
async function unpack(packed) {
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream('deflate-raw'));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** Undoes byte planes and differences: 4 bytes to Int32Array, 8 bytes to BigInt64Array. */
function column(bytes, { count, width }) {
  const words = new Int32Array(count * (width / 4));
  const out = new Uint8Array(words.buffer);
  for (let plane = 0; plane < width; plane++) {
    const from = plane * count;
    for (let i = 0, to = plane; i < count; i++, to += width) out[to] = bytes[from + i];
  }
  if (width === 4) {
    for (let i = 1; i < count; i++) words[i] += words[i - 1];
    return words;
  }
  const wide = new BigInt64Array(words.buffer);
  for (let i = 1; i < count; i++) wide[i] += wide[i - 1];
  return wide;
}

/** Where each list starts, from how long each is. */
function offsets(counts) {
  const starts = new Int32Array(counts.length + 1);
  for (let i = 0; i < counts.length; i++) starts[i + 1] = starts[i] + counts[i];
  return starts;
}

/** The map: columns by name, positions in metres, tags and lists by number; `level` is missing where nothing passes over anything. */
async function readMap(packed) {
  const bytes = await unpack(packed);
  const length = new DataView(bytes.buffer).getUint32(0, true);
  const header = JSON.parse(new TextDecoder().decode(bytes.subarray(4, 4 + length)));
  const columns = {};
  let at = 4 + length;
  for (const one of header.columns) {
    columns[one.name] = column(bytes.subarray(at, at + one.count * one.width), one);
    at += one.count * one.width;
  }
  const metres = (steps) => Float64Array.from(steps, (v) => v / 1000);
  const tagStart = offsets(columns['tags.count']);
  const map = {
    point: { id: columns['point.id'], tags: columns['point.tags'] },
    line: {
      id: columns['line.id'], tags: columns['line.tags'], start: offsets(columns['line.count']), points: columns['line.points'],
      level: columns['line.level'],
    },
    polygon: {
      id: columns['polygon.id'], tags: columns['polygon.tags'], start: offsets(columns['polygon.count']), points: columns['polygon.points'],
      level: columns['polygon.level'],
    },
    lanelet: {
      id: columns['lanelet.id'], tags: columns['lanelet.tags'], left: columns['lanelet.left'], right: columns['lanelet.right'],
      start: offsets(columns['lanelet.count']), rules: columns['lanelet.rules'], level: columns['lanelet.level'],
    },
    rule: {
      id: columns['rule.id'], tags: columns['rule.tags'], start: offsets(columns['rule.count']),
      role: columns['rule.role'], kind: columns['rule.kind'], member: columns['rule.member'],
    },
    x: metres(columns['point.x']),
    y: metres(columns['point.y']),
    string: (number) => header.strings[number],
    tagSets: tagStart.length - 1,
    /** The key-value pairs of a set of tags. */
    pairs(set) {
      const pairs = [];
      for (let i = tagStart[set]; i < tagStart[set + 1]; i++) {
        pairs.push([header.strings[columns['tags.key'][i]], header.strings[columns['tags.value'][i]]]);
      }
      return pairs;
    },
  };
  return map;
}

/** Report and map, each packed: title, frame, requirements, findings; and columns of numbers. */
async function readBoth(report, map) {
  const [facts, columns] = await Promise.all([unpack(report), readMap(map)]);
  return { report: JSON.parse(new TextDecoder().decode(facts)), map: columns };
}

/** What a served page fetches: the length of the packed report, the report, the map. */
function readParcel(buffer) {
  const length = new DataView(buffer).getUint32(0, true);
  return readBoth(new Uint8Array(buffer, 4, length), new Uint8Array(buffer, 4 + length));
}
