#!/bin/sh
# Turf 7.4.0: `cleanCoords` makes of a bridge 10 m up, in a straight street, a street at ground level; if the street has a bend of a centimetre
# there, the bridge stays.
#
# One would guess: "removes redundant coordinates" takes out points that are there twice and those that lie on the line between their neighbours; what
#   is on the line in the plan and 10 m above it in space is not redundant, all the more since the heights of the points that stay are kept.
# What happens: whether a point lies on the line is asked of longitude and latitude alone. Of the street the two ends are left, both at 0 m, and the
#   line climbs no more. Two points at one place, one above the other, are one. The length in the plan is the same, so a check of lengths finds nothing.
#   A polygon of the bridge's deck, whose long sides are straight, sinks to the ground as well. A centimetre of bend in the plan keeps the
#   point, and with it the height.
# Source: @turf/clean-coords 7.4.0 (cleanLine), @turf/boolean-point-on-line 7.4.0; its readme ("removes redundant coordinates from any GeoJSON
#   geometry"); RFC 7946, 3.1.1 (altitude); packages of npm. Needs Node.js.
# Exits 0 while it is so, 1 if that changes.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
npm install --silent --no-audit --no-fund --prefix "$place" @turf/clean-coords@7.4.0 @turf/length@7.4.0 @turf/helpers@7.4.0 >/dev/null
cat >"$place/run.js" <<'END'
const { cleanCoords } = require("@turf/clean-coords");
const { length } = require("@turf/length");
const { lineString, polygon } = require("@turf/helpers");

// 400 m along the meridian: up to a bridge of 200 m, and down again
const profile = [[0, 0], [100, 10], [300, 10], [400, 0]];
const line = (bend, east = 0) => profile.map(([far, up], i) => [8.4 + east + (i === 1 ? bend : 0), 49 + far / 111200, up]);
const show = (coordinates) => coordinates.map((position) => position[2]).join(" ");
const seen = [];
const clean = (name, shape) => {
  const before = shape.geometry.coordinates, after = cleanCoords(shape).geometry.coordinates;
  const rings = shape.geometry.type === "Polygon" ? [before[0], after[0]] : [before, after];
  const same = length(shape).toFixed(4) === length(cleanCoords(shape)).toFixed(4);
  seen.push(show(rings[1]));
  console.log(`${name}: heights ${show(rings[0])}; cleaned ${show(rings[1])}${same ? "; as long as before" : ""}`);
};
clean("straight street", lineString(line(0)));
clean("bent by 1 cm", lineString(line(1.4e-7)));
clean("deck", polygon([[...line(0), ...line(0, 0.0001).reverse(), line(0)[0]]]));
clean("a step of 3 m at one place", lineString([[8.4, 49, 0], [8.401, 49.001, 0], [8.401, 49.001, 3], [8.402, 49, 3]]));
const so = JSON.stringify(seen) === JSON.stringify(["0 0", "0 10 10 0", "0 0 0 0 0", "0 3 3"]);
process.exit(so ? 0 : 1);
END
node "$place/run.js"
# Seen:
#   straight street: heights 0 10 10 0; cleaned 0 0; as long as before
#   bent by 1 cm: heights 0 10 10 0; cleaned 0 10 10 0; as long as before
#   deck: heights 0 10 10 0 0 10 10 0 0; cleaned 0 0 0 0 0; as long as before
#   a step of 3 m at one place: heights 0 0 3 3; cleaned 0 3 3; as long as before
