"""Times lanewright against SUMO's netconvert and the Lanelet2 library; prints tables of time and peak memory.

usage: bench.py LANEWRIGHT [--oracle PYTHON] [--shared DIR] [--runs N] [--before PROGRAM] [--only WHAT]

PYTHON has the wheels of eclipse-sumo and lanelet2; DIR is the directory with corpus/ and tools/. All programs take
turns, so that a busy machine slows all of them alike; each time is the least of N runs: on the clock, and of all
processors together. PROGRAM is an older lanewright, which `build` and `geometry` are held against. WHAT is one of
streets, checks, cities, fixes, watched, older. Exit code 1 if a target is missed.
"""

import argparse
import os
import pathlib
import re
import statistics
import subprocess
import sys
import tempfile
import time

# Least ratios of netconvert's time to ours, and of the Lanelet2 library's.
GEOMETRY, BUILD, CHECK = 20.0, 7.0, 1.0
# The map that is laid side by side for `check`, and how often: to about a quarter, a half and all of 100 MB.
TILED, TILES = "autoware_road_shoulder.osm", (12, 24, 48)
# Tiled maps must not cost more a tile than this many times what the fewest tiles cost.
GROWTH = 1.25
# Built cities. `check` may take these shares of the time in which the library loads them, and so many times the file in memory.
CITIES = ("osm_more/bus.osm", "osm_more/krems.osm", "osm/harrisburg.osm", "osm_more/campo_grande.osm")
WALL, PROCESSORS, MEMORY = 0.8, 1.0, 2.5
# Of maps drawn by hand, of one of these with negative ids as editors write them (more than 10,000 findings), and of a built city from
# which all that is asked of intersections was taken: `fix --unsafe` may cost so many times what `check` costs, on the median and at most.
STRIPPED, MENDING, WORST = "osm_more/campo_grande.osm", 3.0, 6.0
# After a save that changed one tag of a map of so many MB, `check --watch` has said what is found within so many seconds.
WATCHED, SEEN = 50, 0.2
# `build` and `geometry` may take these shares of what an older program takes, where one is given.
OLDER = {"build": 0.5, "geometry": 0.6}
OLDER_CITIES = ("osm/harrisburg.osm", "osm_more/campo_grande.osm")

def netconvert(oracle, extract, output):
    """As osmWebWizard calls it for a network of all roads (tools/osmWebWizard.py and osmBuild.py of SUMO 1.28)."""
    code = "import sumo; print(sumo.SUMO_HOME)"
    home = pathlib.Path(subprocess.check_output([oracle, "-c", code], text=True).strip())
    options = "--geometry.remove --ramps.guess --junctions.join --tls.guess-signals --tls.discard-simple --tls.join "
    options += "--output.original-names --output.street-names --tls.default-type actuated"
    types = home / "data/typemap/osmNetconvert.typ.xml"
    command = [home / "bin/netconvert", "-t", types, *options.split(), "--osm-files", extract, "-o", output]
    return command, {"SUMO_HOME": str(home)}


def run(command, extra=None):
    """Seconds on the clock, seconds of processors and peak memory in MB of a command; its output is dropped."""
    start = time.monotonic()
    quiet = subprocess.DEVNULL
    child = subprocess.Popen([str(c) for c in command], stdout=quiet, stderr=quiet, env={**os.environ, **(extra or {})})
    _, status, usage = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    if child.returncode not in (0, 1):
        sys.exit(f"{command[0]} ended with {child.returncode}: {' '.join(map(str, command))}")
    return time.monotonic() - start, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024


def least(commands, runs):
    """The commands take turns; the least times and memory of each."""
    found = [[run(*command) for command in commands] for _ in range(runs)]
    return [tuple(map(min, zip(*measured))) for measured in zip(*found)]


def table(title, names, measured, base, targets):
    """Prints a table and returns whether every target is met, in time and in memory."""
    print(f"\n{title}\n\n| | wall, s | CPU, s | peak, MB | faster | memory | target |\n|---|---:|---:|---:|---:|---:|---|")
    good = True
    for name, (wall, processors, peak), target in zip(names, measured, targets):
        faster, memory = measured[base][0] / wall, peak / measured[base][2]
        met = target is None or (faster >= target and memory < 1.0)
        good &= met
        wanted = "" if target is None else f"{target:g} times, less memory: {'met' if met else 'MISSED'}"
        print(f"| {name} | {wall:.3f} | {processors:.3f} | {peak:.0f} | {faster:.1f} | {memory:.2f} | {wanted} |")
    return good


def streets(ours, oracle, shared, runs, work):
    extract = shared / "corpus/osm/harrisburg.osm"
    commands = [
        netconvert(oracle, extract, work / "net.xml.gz"),
        ([ours, "geometry", extract, "-o", work / "streets.geojson"],),
        ([ours, "build", extract, "-o", work / "map"],),
    ]
    names = ["netconvert", "lanewright geometry", "lanewright build"]
    title = f"From OpenStreetMap: {extract.name}, {extract.stat().st_size / 1e6:.1f} MB"
    return table(title, names, least(commands, runs), 0, [None, GEOMETRY, BUILD])


def tiled(oracle, shared, tiles, work):
    path = work / f"tiled_{tiles}.osm"
    subprocess.check_call([oracle, shared / "tools/tile_map.py", shared / "corpus/lanelet2" / TILED, path, str(tiles)])
    return path


def loading(oracle, path):
    """The command by which the Lanelet2 library loads a map."""
    load = "import sys, lanelet2\nfrom lanelet2.projection import UtmProjector\n"
    load += "origin = lanelet2.io.Origin(*map(float, sys.argv[2:4]))\nlanelet2.io.loadRobust(sys.argv[1], UtmProjector(origin))"
    with open(path, encoding="utf-8") as text:
        first = next(line for line in text if "<node " in line)
    origin = [first.split(f'{name}="')[1].split('"')[0] for name in ("lat", "lon")]
    return ([oracle, "-c", load, path, *origin],)


def cities(ours, oracle, shared, runs, work):
    print("\nChecking built cities with all rules; shares of what the Lanelet2 library takes to load them\n")
    print("| map | MB | wall | CPU | peak, times the file | aims |\n|---|---:|---:|---:|---:|---|")
    good = True
    for city in CITIES:
        extract = shared / "corpus" / city
        subprocess.check_call([ours, "build", extract, "-o", work / extract.stem], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        path = work / extract.stem / "lanelet2_map.osm"
        check = ([ours, "check", path, "--format", "json"],)
        (load_wall, load_processors, _), (wall, processors, peak) = least([loading(oracle, path), check], runs)
        size = path.stat().st_size / 1e6
        shares = (wall / load_wall, processors / load_processors, peak * 1.048576 / size)
        met = all(share <= aim for share, aim in zip(shares, (WALL, PROCESSORS, MEMORY)))
        good &= met
        columns = " | ".join(f"{share:.2f}" for share in shares)
        print(f"| {extract.stem} | {size:.1f} | {columns} | {WALL}, {PROCESSORS}, {MEMORY}: {'met' if met else 'MISSED'} |")
    return good


def checks(ours, oracle, shared, runs, work):
    maps = [tiled(oracle, shared, tiles, work) for tiles in TILES]
    check = [([ours, "check", path, "--isolated", "--format", "json"],) for path in maps]
    measured = least([loading(oracle, maps[-1]), *check], runs)
    title = f"Checking with all rules: {TILED} tiled, {maps[-1].stat().st_size / 1e6:.0f} MB"
    names = ["Lanelet2 library, load alone", "lanewright check"]
    good = table(title, names, [measured[0], measured[-1]], 0, [None, CHECK])
    print("\n| tiles | MB | wall, s | CPU, ms/tile |\n|---:|---:|---:|---:|")
    costs = [processors / tiles for tiles, (_, processors, _) in zip(TILES, measured[1:])]
    for tiles, path, (wall, *_), cost in zip(TILES, maps, measured[1:], costs):
        print(f"| {tiles} | {path.stat().st_size / 1e6:.0f} | {wall:.2f} | {cost * 1e3:.1f} |")
    linear = costs[-1] <= GROWTH * costs[0]
    print(f"\na tile of the largest costs {costs[-1] / costs[0]:.2f} times one of the smallest: {'met' if linear else 'MISSED'}")
    return good and linear


MARKS = ("turn_direction", "intersection_area", "lane_change", "location", "one_way", "participant:vehicle")


def bare(built, path):
    """Writes a map as `build` writes them without what is asked of intersections: areas, turns, rights of way, crosswalk elements."""
    gone = ('v="intersection_area"', 'v="right_of_way"', 'v="crosswalk"')
    element, removed = [], set()
    with open(built, encoding="utf-8") as lines, open(path, "w", encoding="utf-8") as output:
        for line in lines:
            start = line.lstrip()
            if any(start.startswith(f'<tag k="{mark}"') for mark in MARKS):
                continue
            element.append(line)
            if start.startswith(("</", "<?", "<osm")) or (len(element) == 1 and start.endswith("/>\n")):
                text = "".join(element)
                is_element = any(mark in text for mark in gone) and 'v="lanelet"' not in text
                removed.update([text.split('id="')[1].split('"')[0]] if is_element else [])
                output.write("" if is_element else text)
                element = []
    with open(path, encoding="utf-8") as lines:
        kept = [line for line in lines if 'role="regulatory_element"' not in line or line.split('ref="')[1].split('"')[0] not in removed]
    path.write_text("".join(kept), encoding="utf-8")


def negated(drawn, path):
    """Writes a map with all ids negative, as editors write them for new elements."""
    text = drawn.read_text(encoding="utf-8")
    text = re.sub(r"(<(?:node|way|relation)\b[^>]*?\bid=[\"'])(\d)", r"\1-\2", text)
    path.write_text(re.sub(r"(\bref=[\"'])(\d)", r"\1-\2", text), encoding="utf-8")
    return path


def fixes(ours, shared, runs, work):
    print("\nMending: `fix --unsafe` in times of `check`, CPU\n\n| map | MB | check, s | fix, s | times | aim |\n|---|---:|---:|---:|---:|---|")
    city = work / "city"
    stripped = work / "stripped.osm"
    subprocess.check_call([ours, "build", shared / "corpus" / STRIPPED, "-o", city], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    bare(city / "lanelet2_map.osm", stripped)
    drawn = sorted((shared / "corpus").glob("lanelet2*/*.osm"))
    negative = negated(shared / "corpus/lanelet2" / TILED, work / "negative_ids.osm")
    times = []
    for path in [*drawn, negative, stripped]:
        commands = [([ours, "check", path, "--format", "json"],), ([ours, "fix", path, "--unsafe", "--diff"],)]
        (_, check, _), (_, fix, _) = least(commands, runs if path != stripped else 1)
        times.append(fix / check)
        size = path.stat().st_size / 1e6
        print(f"| {path.stem} | {size:.1f} | {check:.2f} | {fix:.2f} | {times[-1]:.1f} | {WORST:g}: {'met' if times[-1] <= WORST else 'MISSED'} |")
    median = statistics.median(times)
    print(f"| median | | | | {median:.1f} | {MENDING:g}: {'met' if median <= MENDING else 'MISSED'} |")
    return median <= MENDING and max(times) <= WORST


def watched(ours, oracle, shared, runs, work):
    """Saves a map again and again, each time with another value of one tag, and waits until `check --watch` has judged it."""
    one = (shared / "corpus/lanelet2" / TILED).stat().st_size / 1e6
    path = tiled(oracle, shared, round(WATCHED / one), work)
    text = path.read_text(encoding="utf-8")
    key = '<tag k="speed_limit" v="'
    begin = text.index(key) + len(key)
    end = text.index('"', begin)
    child = subprocess.Popen([ours, "check", path, "--isolated", "--watch"], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    seconds = []
    for save in range(runs + 1):
        saved = time.monotonic()
        if not any(line.startswith("watching") for line in child.stderr):
            sys.exit(f"{ours} check --watch ended")
        seconds += [time.monotonic() - saved] if save else []
        path.write_text(f"{text[:begin]}{20 + save}{text[end:]}", encoding="utf-8")
    child.kill()
    child.wait()
    met = min(seconds) <= SEEN
    print(f"\nfindings {min(seconds):.2f} s after a save of {len(text) / 1e6:.0f} MB; aim {SEEN:g}: {'met' if met else 'MISSED'}")
    return met


def older(ours, before, shared, runs, work):
    print("\nIn shares of what an older program takes, CPU\n\n| command | map | older, s | now, s | share | aim |\n|---|---|---:|---:|---:|---|")
    good = True
    for verb, aim in OLDER.items():
        for city in OLDER_CITIES:
            path = shared / "corpus" / city
            output = lambda program: work / f"{verb}-{program}" if verb == "build" else work / f"{program}.geojson"
            commands = [([program, verb, path, "-o", output(name)],) for program, name in ((before, "older"), (ours, "now"))]
            (_, old, _), (_, now, _) = least(commands, runs)
            good &= now <= aim * old
            print(f"| {verb} | {path.stem} | {old:.2f} | {now:.2f} | {now / old:.2f} | {aim:g}: {'met' if now <= aim * old else 'MISSED'} |")
    return good


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    root = pathlib.Path(__file__).resolve().parent.parent
    parser.add_argument("lanewright", type=pathlib.Path)
    parser.add_argument("--oracle", default=sys.executable)
    parser.add_argument("--shared", type=pathlib.Path, default=root.parent / "shared")
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--before", type=pathlib.Path)
    parser.add_argument("--only", choices=["streets", "checks", "cities", "fixes", "watched", "older"])
    args = parser.parse_args()
    with tempfile.TemporaryDirectory(dir=os.environ.get("TMPDIR")) as work:
        ours, shared, work = args.lanewright.resolve(), args.shared.resolve(), pathlib.Path(work)
        places = (ours, args.oracle, shared, args.runs, work)
        tables = {name: lambda of=of: of(*places) for name, of in (("streets", streets), ("checks", checks), ("cities", cities), ("watched", watched))}
        tables["fixes"] = lambda: fixes(ours, shared, args.runs, work)
        if args.before:
            tables["older"] = lambda: older(ours, args.before.resolve(), shared, args.runs, work)
        good = [of() for name, of in tables.items() if args.only in (None, name)]
    sys.exit(0 if all(good) else 1)


if __name__ == "__main__":
    main()
