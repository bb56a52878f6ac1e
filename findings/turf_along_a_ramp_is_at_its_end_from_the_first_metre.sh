#!/bin/sh
# Turf 7.4.0: who is a metre into a ramp that climbs 60 m in 1 km is at 60 m; the ramp cut into pieces of 100 m climbs in the first of them.
#
# One would guess: `along` and `lineSliceAlong` go by the plan and take no notice of heights, or find the height between both points of the
#   line, as the place is found. A third coordinate that is not understood would be left out.
# What happens: the place is computed from the point at the far end of the segment, backwards, with the help of `destination`, which keeps the
#   third coordinate of the point that it starts from. So each place of a segment has the height of its end, but for the first point of the line.
#   `lineSliceAlong` and `lineChunk` do so at both ends of a piece. With the line turned around the same place is at 0 m: 999 m from one end
#   and 1 m from the other, heights differ by 60 m. Where a line has many points the error is a step of each segment; where
#   a slope is drawn by its two ends, as straight slopes are, it is the whole rise. `nearestPointOnLine` gives no height at all.
# Source: @turf/along 7.4.0, @turf/line-slice-along 7.4.0 (both measure back from `coords[i]`), @turf/destination 7.4.0 (height of the origin);
#   the readmes do not speak of heights; RFC 7946, 3.1.1 (the third element is the altitude); packages of npm. Needs Node.js.
# Exits 0 while it is so, 1 if that changes.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
npm install --silent --no-audit --no-fund --prefix "$place" @turf/along@7.4.0 @turf/line-slice-along@7.4.0 @turf/line-chunk@7.4.0 \
    @turf/destination@7.4.0 @turf/length@7.4.0 @turf/nearest-point-on-line@7.4.0 @turf/helpers@7.4.0 >/dev/null
cat >"$place/run.js" <<'END'
const { along } = require("@turf/along");
const { lineSliceAlong } = require("@turf/line-slice-along");
const { lineChunk } = require("@turf/line-chunk");
const { destination } = require("@turf/destination");
const { length } = require("@turf/length");
const { nearestPointOnLine } = require("@turf/nearest-point-on-line");
const { lineString } = require("@turf/helpers");

const metres = { units: "meters" };
const foot = [8.4, 49, 0];
const ramp = lineString([foot, [...destination([8.4, 49], 1000, 30, metres).geometry.coordinates, 60]]);
const back = lineString([...ramp.geometry.coordinates].reverse());
const height = (coordinates) => coordinates.map((position) => position[2]).join(" to ");
const seen = [];
const say = (text, value) => { seen.push(value); console.log(`${text}: ${value}`); };

console.log(`ramp of ${length(ramp, metres).toFixed(0)} m, heights ${height(ramp.geometry.coordinates)}`);
for (const far of [0, 1, 500, 999]) {
  const place = along(ramp, far, metres);
  const gone = length(lineString([foot, place.geometry.coordinates]), metres);
  say(`along by ${far} m, found ${gone.toFixed(1)} m from the foot, which should be ${(far * 0.06).toFixed(1)} m up`, `height ${place.geometry.coordinates[2]}`);
}
say("the same line from above, along by 1 m, which should be 59.9 m up", `height ${along(back, 1, metres).geometry.coordinates[2]}`);
say("lineSliceAlong from 100 m to 200 m, should be 6 to 12", `height ${height(lineSliceAlong(ramp, 100, 200, metres).geometry.coordinates)}`);
const pieces = lineChunk(ramp, 100, metres).features;
say("lineChunk by 100 m, first two pieces, should be 0 to 6, 6 to 12", pieces.slice(0, 2).map((f) => height(f.geometry.coordinates)).join(", "));
say("nearestPointOnLine in the middle", `height ${nearestPointOnLine(ramp, along(ramp, 500, metres)).geometry.coordinates[2]}`);
const so = JSON.stringify(seen) === JSON.stringify(
  ["height 0", "height 60", "height 60", "height 60", "height 0", "height 60 to 60", "0 to 60, 60 to 60", "height undefined"]);
process.exit(so ? 0 : 1);
END
node "$place/run.js"
# Seen:
#   ramp of 1000 m, heights 0 to 60
#   along by 0 m, found 0.0 m from the foot, which should be 0.0 m up: height 0
#   along by 1 m, found 1.0 m from the foot, which should be 0.1 m up: height 60
#   along by 500 m, found 500.0 m from the foot, which should be 30.0 m up: height 60
#   along by 999 m, found 999.0 m from the foot, which should be 59.9 m up: height 60
#   the same line from above, along by 1 m, which should be 59.9 m up: height 0
#   lineSliceAlong from 100 m to 200 m, should be 6 to 12: height 60 to 60
#   lineChunk by 100 m, first two pieces, should be 0 to 6, 6 to 12: 0 to 60, 60 to 60
#   nearestPointOnLine in the middle: height undefined
