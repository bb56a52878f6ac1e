#!/bin/sh
# maliput-malidrive 0.21.0: asked for lanes within 1 m of a car that stands in the middle of a lane, it finds none; in a map with a motorway
# elsewhere, a street is not found within 20 m.
#
# One would guess: `FindRoadPositions(position, radius)` returns the positions on all lanes that are within the radius; a car on a lane is
#   0 m from it, so that with a radius of zero its lane is in the list. The documentation says just that.
# What happens: a search tree holds samples of each lane, at steps of a tenth of the mean length of all lanes in the map. Only lanes with a sample
#   in a box of the size of the radius are looked at. Alone in its map, a street of 100 m has samples at each 10 m, and a radius of 5 m finds it
#   everywhere. With a motorway of 3 km in the same file, 1 km away, the step is 155 m: the street is found near its ends alone.
#   `ToRoadPosition`, which looks further, finds the lane at 0 m each time.
#   Who lists what is near (lanes at a crossing, the oncoming lane) gets an empty list, or the neighbour without the own lane. No error.
#   maliput's sources have a wider box since; releases on PyPI end at 0.21.0.
# Source: maliput, include/maliput/api/road_geometry.h (FindRoadPositions: a radius of zero gives results within linear_tolerance) and
#   geometry_base/kd_tree_strategy.cc; maliput_malidrive, builder/road_geometry_builder.cc (ComputeKdTreeSamplingStep); wheels of PyPI.
# Exits 0 while it is so, 1 if that changes, 2 if it cannot be installed. Needs CPython 3.10 on Linux.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
fits() { "$1" -c 'import sys; sys.exit(sys.version_info[:2] != (3, 10))' 2>/dev/null; }
python=python3
if fits python3.10; then python=python3.10; fi
{ fits "$python" && "$python" -m venv "$place/env" && "$place/env/bin/pip" install --quiet --disable-pip-version-check --no-compile --no-deps \
  --only-binary :all: maliput-malidrive==0.21.0 maliput==1.15.0; } ||
  { echo "maliput-malidrive 0.21.0 cannot be installed here: it needs CPython 3.10 on Linux and PyPI" >&2; exit 2; }
cat >"$place/run.py" <<'END'
import importlib.metadata
import os
import pathlib
import sys

import maliput_malidrive
from maliput import api, plugin

os.environ.setdefault("MALIPUT_PLUGIN_PATH", maliput_malidrive.get_plugin_path())


def road(number, y, length):
    """Straight to the east, one lane for each direction."""
    lane = '<lane id="{}" type="driving" level="false"><link/><width sOffset="0" a="3.5" b="0" c="0" d="0"/></lane>'
    return (f'<road name="" length="{length}" id="{number}" junction="-1"><link/><planView><geometry s="0" x="0" y="{y}" hdg="0" length="{length}">'
            f'<line/></geometry></planView><elevationProfile/><lateralProfile/><lanes><laneSection s="0"><left>{lane.format(1)}</left><center>'
            f'<lane id="0" type="none" level="false"/></center><right>{lane.format(-1)}</right></laneSection></lanes></road>')


def found(name, radii, *roads):
    """In how many of 99 places, one each metre in the middle of lane -1 of the street, a search finds this lane."""
    path = pathlib.Path(sys.argv[1]) / "map.xodr"
    path.write_text('<?xml version="1.0"?><OpenDRIVE><header revMajor="1" revMinor="6" name="" version="1" date="" north="0" south="0" east="0" '
                    'west="0" vendor=""/>' + "".join(roads) + "</OpenDRIVE>")
    manager = plugin.MaliputPluginManager()  # noqa: F841, kept alive
    network = plugin.create_road_network("maliput_malidrive", {"opendrive_file": str(path), "linear_tolerance": "1e-3", "angular_tolerance": "1e-3"})
    geometry = network.road_geometry()
    places = [api.InertialPosition(x, -1.75, 0) for x in range(1, 100)]

    def own(result):
        return result.road_position.lane.id().string() == "1_0_-1" and result.distance < 1e-3

    counts = [sum(any(map(own, geometry.FindRoadPositions(place, radius))) for place in places) for radius in radii]
    straight = sum(own(geometry.ToRoadPosition(place)) for place in places)
    print(f"{name}: ToRoadPosition {straight} of {len(places)}; FindRoadPositions",
          ", ".join(f"within {radius} m {count}" for radius, count in zip(radii, counts)))
    return straight, counts


print(*(f"{name} {importlib.metadata.version(name)}" for name in ("maliput-malidrive", "maliput")))
radii = [0, 1, 2, 3, 5, 20]
alone = found("street of 100 m", radii, road(1, 0, 100))
both = found("street, and a motorway of 3 km", radii, road(1, 0, 100), road(2, 1000, 3000))
so = alone == (99, [0, 0, 40, 60, 99, 99]) and both[0] == 99 and both[1][:2] == [0, 0] and both[1] == sorted(both[1]) and both[1][-1] < 50
raise SystemExit(0 if so else 1)
END
status=0
"$place/env/bin/python" "$place/run.py" "$place" >"$place/log" 2>&1 || status=1
grep -v -e '^\[INFO\]' -e '^$' "$place/log"
if [ "$status" -ne 0 ]; then exit 1; fi
# Seen:
#   maliput-malidrive 0.21.0 maliput 1.15.0
#   street of 100 m: ToRoadPosition 99 of 99; FindRoadPositions within 0 m 0, within 1 m 0, within 2 m 40, within 3 m 60, within 5 m 99, within 20 m 99
#   street, and a motorway of 3 km: ToRoadPosition 99 of 99; FindRoadPositions within 0 m 0, within 1 m 0, within 2 m 4, within 3 m 6, within 5 m 10, within 20 m 40
