#!/bin/sh
# Turf 7.4.0: a lane bound that `lineOffset` draws 3.5 m beside a line is only 2.3 m away at 49 degrees north, and on slanting roads askew.
#
# One would guess: with `{units: "meters"}` the distance is metres on the ground, as in Turf's `buffer`, `destination` and `length`.
# What happens: metres become degrees as on the equator, and the shift is done in the plane of longitude and latitude. Beside a road to the
#   north the result is too narrow by the cosine of the latitude; beside a road to the east it is right; a road to the north-east is
#   shifted 23 degrees off the perpendicular, so that the ends of both bounds do not face each other. `buffer` of the same line is right.
#   (Positive is to the right, unlike `offset_curve` of GEOS, where it is to the left.)
# Source: @turf/line-offset 7.4.0, processSegment; Turf issues 1838 and 2278; packages of npm. Needs Node.js.
# Exits 0 while it is so, 1 if that changes.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
npm install --silent --no-audit --no-fund --prefix "$place" \
    @turf/line-offset@7.4.0 @turf/destination@7.4.0 @turf/distance@7.4.0 @turf/bearing@7.4.0 @turf/buffer@7.4.0 @turf/helpers@7.4.0 >/dev/null
cat >"$place/run.js" <<'END'
const { lineOffset } = require("@turf/line-offset");
const { destination } = require("@turf/destination");
const { distance } = require("@turf/distance");
const { bearing } = require("@turf/bearing");
const { buffer } = require("@turf/buffer");
const { lineString } = require("@turf/helpers");

const metres = { units: "meters" };
// the shift of the first point of a line 100 m long: how far, and by how many degrees to the right of the line's course
function shift(latitude, course) {
  const start = [8, latitude];
  const line = lineString([start, destination(start, 100, course, metres).geometry.coordinates]);
  const moved = lineOffset(line, 3.5, metres).geometry.coordinates[0];
  const angle = (bearing(start, moved) - course + 360) % 360;
  return [distance(start, moved, metres).toFixed(2), angle.toFixed(0)];
}
const seen = {};
for (const latitude of [0, 49, 60]) {
  for (const [name, course] of [["north", 0], ["north-east", 45], ["east", 90]]) {
    const [far, angle] = shift(latitude, course);
    seen[latitude + name] = far + " m at " + angle;
    console.log(`at ${latitude} degrees, road to the ${name}: ${far} m, ${angle} degrees from its course`);
  }
}
const road = lineString([[8, 49], destination([8, 49], 100, 0, metres).geometry.coordinates]);
const west = Math.min(...buffer(road, 3.5, metres).geometry.coordinates[0].map((place) => place[0]));
const beside = distance([west, 49.0004], [8, 49.0004], metres).toFixed(2);
console.log(`buffer at 49 degrees, road to the north: ${beside} m`);
const so = seen["0north"] === "3.50 m at 90" && seen["49north"] === "2.30 m at 90" && seen["60north"] === "1.75 m at 90" &&
  seen["49east"] === "3.50 m at 90" && seen["49north-east"] === "3.19 m at 112" && beside === "3.50";
process.exit(so ? 0 : 1);
END
node "$place/run.js"
# Seen:
#   at 0 degrees, road to the north: 3.50 m, 90 degrees from its course
#   at 0 degrees, road to the north-east: 3.50 m, 90 degrees from its course
#   at 0 degrees, road to the east: 3.50 m, 90 degrees from its course
#   at 49 degrees, road to the north: 2.30 m, 90 degrees from its course
#   at 49 degrees, road to the north-east: 3.19 m, 112 degrees from its course
#   at 49 degrees, road to the east: 3.50 m, 90 degrees from its course
#   at 60 degrees, road to the north: 1.75 m, 90 degrees from its course
#   at 60 degrees, road to the north-east: 3.23 m, 121 degrees from its course
#   at 60 degrees, road to the east: 3.50 m, 90 degrees from its course
#   buffer at 49 degrees, road to the north: 3.50 m
