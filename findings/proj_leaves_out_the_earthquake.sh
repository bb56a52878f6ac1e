#!/bin/sh
# PROJ 9.5.1 (pyproj 3.7.2): from JGD2000 to JGD2011, Japan's datums before and after the earthquake of 2011, nothing moves, not even in
# Miyagi, where the ground moved by metres; the accuracy is said to be 1 m, and who insists on the best operation gets the same.
#
# One would guess: the operation whose area holds the place is taken; without its grid file there is a warning, a bad accuracy, or with
#   `only_best=True` and `allow_ballpark=False` an error.
# What happens: without the grid of Tohoku (no wheel brings it, the network is off) PROJ takes "JGD2000 to JGD2011 (2)", three zeros, which
#   is defined for Japan except those prefectures. Its bounding box holds them all the same, so that it counts as fitting: even
#   `TransformerGroup.best_available` is True. Plane rectangular zones and UTM do the same: a survey made before 2011 comes out unmoved.
# Source: EPSG operations 6713 and 6698 with their areas of use, in the `proj.db` that the wheel brings; pyproj, `Transformer.from_crs`.
# Exits 0 while it is so, 1 if that changes.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/env"
"$place/env/bin/pip" install --quiet --disable-pip-version-check pyproj==3.7.2
cat >"$place/run.py" <<'END'
import warnings
import pyproj
from pyproj.transformer import Transformer, TransformerGroup

pyproj.network.set_network_enabled(False)
before, after, east, north = "EPSG:4612", "EPSG:6668", 141.5, 38.4  # in Miyagi
with warnings.catch_warnings(record=True) as warned:
    warnings.simplefilter("always")
    transformer = Transformer.from_crs(before, after, always_xy=True, only_best=True, allow_ballpark=False)
    group = TransformerGroup(before, after, always_xy=True)
    planes = Transformer.from_crs("EPSG:2452", "EPSG:6678", only_best=True)  # plane rectangular zone X
moved = transformer.transform(east, north)
print(f"PROJ {pyproj.proj_version_str}; {(east, north)} -> {moved}, said to be right within {transformer.accuracy} m")
print("zone X: (1000.0, 2000.0) ->", tuple(round(value, 6) for value in planes.transform(1000.0, 2000.0)))
print("taken:", transformer.description)
print("its area:", transformer.area_of_use.name)
print("left out:", [(o.name, o.area_of_use.name[:51]) for o in group.unavailable_operations])
print("best available:", group.best_available, "warnings:", len(warned))
still = max(abs(moved[0] - east), abs(moved[1] - north)) < 1e-9 and transformer.accuracy == 1.0
excluded = "excluding northern prefectures" in transformer.area_of_use.name
raise SystemExit(0 if still and excluded and group.best_available and not warned and len(group.unavailable_operations) == 1 else 1)
END
"$place/env/bin/python" "$place/run.py"
# Seen:
#   PROJ 9.5.1; (141.5, 38.4) -> (141.5, 38.4), said to be right within 1.0 m
#   zone X: (1000.0, 2000.0) -> (1000.0, 2000.0)
#   taken: axis order change (2D) + JGD2000 to JGD2011 (2) + axis order change (2D)
#   its area: Japan - onshore and offshore, excluding northern prefectures of 'main province' (see remarks).
#   left out: [('JGD2000 to JGD2011 (1)', 'Japan - northern Honshu prefectures affected by 201')]
#   best available: True warnings: 0
