#!/bin/sh
# ndslive-math 1.1.0: of a box of 100 km around Taveuni, Fiji, which lies on the 180th meridian, no tile is needed; its own north-east corner is
# not in it; and the least box around two tiles side by side is the belt around the earth.
#
# One would guess: the package knows the meridian: tiles have neighbours beyond it, a box says `contains_anti_meridian`, and can be split there. So
#   boxes that cross it contain what is in them, as a box of the same size anywhere else does.
# What happens: `get_tile_ids_for_bounding_box` counts from the west to the east; where the east is the smaller number, it counts nothing, and
#   returns an empty list, though its help promises all tiles that the box meets. `contains` and `intersects` compare longitudes as
#   numbers, so that what lies beyond the meridian is outside. `bounding_box_from_tile_ids` takes least and greatest numbers: two
#   neighbours give 40,000 km, and 4096 tiles for 2. No error, no warning: the map there is empty, or is the whole belt.
#   A way out: `split_over_anti_meridian` before, and both halves.
# Source: ndslive/math/tileid.py (get_tile_ids_for_bounding_box: "all tile IDs that intersect"; bounding_box_from_tile_ids: "minimal bounding box",
#   "tight"; east_neighbour: "wraps around at the antimeridian"), wgs84_aabb.py (contains, intersects), release 1.1.0.
# Exits 0 while it is so, 1 if that changes. Needs CPython 3.10 or newer.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/env"
"$place/env/bin/pip" install --quiet --disable-pip-version-check --no-compile ndslive-math==1.1.0
cat >"$place/run.py" <<'END'
import importlib.metadata

from ndslive.math import PackedTileId, Vec2, Wgs84, Wgs84Aabb, bounding_box_from_tile_ids, get_tile_ids_for_bounding_box

LEVEL = 11  # tiles of 10 km
print("ndslive-math", importlib.metadata.version("ndslive-math"))
results = []
for name, west in ("Taveuni", 179.5), ("the same box 10 degrees further west", 169.5):
    box = Wgs84Aabb(Wgs84(west, -17.3), Vec2(0.95, 0.9))
    corner = box.ne()
    tiles = get_tile_ids_for_bounding_box(*box.sw().to_nds_coordinates(), *corner.to_nds_coordinates(), LEVEL)
    inside = Wgs84Aabb(Wgs84(west + 0.7, -17.0), Vec2(0.1, 0.1))
    pair = [PackedTileId.from_wgs84(west + 0.49, -17, LEVEL)]
    pair.append(pair[0].east_neighbour())
    x0, y0, x1, y1 = bounding_box_from_tile_ids(pair)
    width = (x1 - x0 + 1) / 2**32 * 360
    cover = len(get_tile_ids_for_bounding_box(x0, y0, x1, y1, LEVEL))
    results.append((len(tiles), box.contains(corner), box.intersects(inside), cover))
    print(f"{name}: contains_anti_meridian {box.contains_anti_meridian()}, tiles {len(tiles)}, contains its north-east corner {results[-1][1]}, "
          f"meets a box inside {results[-1][2]}; box around two neighbours {width:.2f} degrees wide, {cover} tiles")
    if box.contains_anti_meridian():
        halves = box.split_over_anti_meridian()
        print("  in two halves: tiles", sum(len(get_tile_ids_for_bounding_box(
            *half.sw().to_nds_coordinates(), *(corner if half is halves[1] else Wgs84(179.99999, half.ne().y)).to_nds_coordinates(), LEVEL)) for half in halves))
raise SystemExit(0 if results[0] == (0, False, False, 4096) and results[1][0] > 100 and results[1][1:] == (True, True, 2) else 1)
END
"$place/env/bin/python" "$place/run.py"
# Seen:
#   ndslive-math 1.1.0
#   Taveuni: contains_anti_meridian True, tiles 0, contains its north-east corner False, meets a box inside False; box around two neighbours 360.00 degrees wide, 4096 tiles
#     in two halves: tiles 132
#   the same box 10 degrees further west: contains_anti_meridian False, tiles 132, contains its north-east corner True, meets a box inside True; box around two neighbours 0.18 degrees wide, 2 tiles
