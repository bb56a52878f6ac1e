#!/bin/sh
# CARLA 0.9.16 gives a point 1 km north of a map's origin the latitude of a point 1 km south of it.
#
# One would guess: `Map.transform_to_geolocation` undoes the file's own `+proj=tmerc`, as PROJ does, so that a lanelet map made from the
#   same OpenDRIVE lies where the simulator's GNSS says.
# What happens: the road leads north from 48 degrees; its waypoint has y = -1000, as it should in CARLA's left-handed axes; its latitude
#   comes out below 48 degrees, 2 km off. Longitudes grow too fast as well, by 2 m on 1 km. Up to 0.9.15 north was north: maps and
#   positions that were matched with one version are mirrored with the next.
# Source: carla issue 9389 and pull request 9552 (GeoProjection.cpp); the wheel of 0.9.16.
# Exits 0 while it is so, 1 if that changes. Needs CPython 3.10 to 3.12 on Linux.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/env"
"$place/env/bin/pip" install --quiet --disable-pip-version-check carla==0.9.16 pyproj==3.7.2
cat >"$place/run.py" <<'END'
import carla, pyproj

tmerc = "+proj=tmerc +lat_0=48 +lon_0=9 +k=1 +x_0=0 +y_0=0 +datum=WGS84 +units=m"
lane = '<lane id="%d" type="driving" level="false"><width sOffset="0" a="3.5" b="0" c="0" d="0"/></lane>'
town = carla.Map("north", f"""<?xml version="1.0"?>
<OpenDRIVE>
  <header revMajor="1" revMinor="4" name="north"><geoReference><![CDATA[{tmerc}]]></geoReference></header>
  <road id="1" length="2000" junction="-1">
    <planView><geometry s="0" x="0" y="0" hdg="1.5707963267948966" length="2000"><line/></geometry></planView>
    <elevationProfile><elevation s="0" a="0" b="0" c="0" d="0"/></elevationProfile>
    <lanes><laneSection s="0"><center><lane id="0" type="none" level="false"/></center><right>{lane % -1}</right></laneSection></lanes>
  </road>
</OpenDRIVE>""")
place = town.get_waypoint_xodr(1, -1, 1000.0).transform.location
said = town.transform_to_geolocation(place)
east, north = place.x, -place.y
_, right = pyproj.Proj(tmerc)(east, north, inverse=True)
far = town.transform_to_geolocation(carla.Location(1000, 0, 0)).longitude
print("1 km north of 48 degrees: CARLA %.4f, PROJ %.4f" % (said.latitude, right))
print("1 km east of 9 degrees: CARLA %.5f, PROJ %.5f" % (far, pyproj.Proj(tmerc)(1000, 0, inverse=True)[0]))
raise SystemExit(0 if said.latitude < 47.9911 and right > 48.0089 else 1)
END
"$place/env/bin/python" "$place/run.py"
# Seen:
#   1 km north of 48 degrees: CARLA 47.9910, PROJ 48.0090
#   1 km east of 9 degrees: CARLA 9.01343, PROJ 9.01340
