"""Maps on Spark: the bytes of the program, whatever happens to a tile or a worker."""

import json
import os
import pathlib
import re
import shutil
import struct
import subprocess
import sys

import lanewright
import pytest

from conftest import ROOT, SAMPLE, SHARED

WORKER = ROOT / "tests" / "python" / "worker"
BESIDE = ["lanelet2_map_metadata.yaml", "lanewright.toml", "map_projector_info.yaml"]


@pytest.fixture(scope="module")
def spark(tmp_path_factory):
    """A session with two threads, in which a task may fail three times."""
    try:
        import fsspec  # noqa: F401
        import pyarrow  # noqa: F401
        from pyspark.sql import SparkSession
    except ImportError as missing:
        pytest.skip(f"Spark's packages are needed: {missing}")
    if shutil.which("java") is None and "JAVA_HOME" not in os.environ:
        pytest.skip("Java is needed for Spark")
    folder = tmp_path_factory.mktemp("spark")
    before = dict(os.environ)
    path = os.pathsep.join([str(WORKER), *filter(None, [os.environ.get("PYTHONPATH")])])
    os.environ.update(PYTHONPATH=path, PYSPARK_PYTHON=sys.executable, LANEWRIGHT_TEST_KILL=str(folder / "die"))
    sys.path.insert(0, str(WORKER))
    import storage_of_tests

    storage_of_tests.register()
    options = {
        "spark.ui.enabled": "false",
        "spark.driver.host": "127.0.0.1",
        "spark.driver.bindAddress": "127.0.0.1",
        "spark.local.dir": str(folder),
        "spark.sql.warehouse.dir": str(folder / "warehouse"),
        "spark.sql.shuffle.partitions": "2",
    }
    builder = SparkSession.builder.master("local[2,4]").appName("lanewright")
    for key, value in options.items():
        builder = builder.config(key, value)
    session = builder.getOrCreate()
    session.sparkContext.setLogLevel("OFF")
    yield session
    session.stop()
    sys.path.remove(str(WORKER))
    os.environ.clear()
    os.environ.update(before)


@pytest.fixture
def deadly():
    """The file that makes a worker die; it is there no more when one did."""
    file = pathlib.Path(os.environ["LANEWRIGHT_TEST_KILL"])
    file.touch()
    yield file
    file.unlink(missing_ok=True)


def files(directory):
    """The files of a map, without what is remembered of its tiles."""
    directory = pathlib.Path(directory)
    found = [file for file in directory.rglob("*") if file.is_file() and ".tiles" not in file.relative_to(directory).parts]
    return {str(file.relative_to(directory)): file.read_bytes() for file in found}


def times(directory):
    return {file: file.stat().st_mtime_ns for file in pathlib.Path(directory).rglob("*") if file.is_file()}


def rows(result):
    return {row["tile"]: row for row in result.tiles.collect()}


def run(program, *arguments):
    subprocess.run([program, *map(str, arguments)], check=True, capture_output=True)


def town(tmp_path):
    """An own extract of several tiles: samples beside each other, without bounds, ids made different."""
    step, elements = 0.011, {"node": [], "way": [], "relation": []}
    for at in range(4):
        text = SAMPLE.read_text()
        shift = lambda found: f'lon="{float(found[1]) + at * step:.7f}"'  # noqa: B023, E731
        text = re.sub(r'lon="([^"]+)"', shift, text)
        text = re.sub(r'\b(id|ref)="(\d+)"', lambda found: f'{found[1]}="{int(found[2]) + 1000 * at}"', text)  # noqa: B023
        for kind, found in elements.items():
            found += re.findall(rf"<{kind} [^>]*/>|<{kind} .*?</{kind}>", text, re.DOTALL)
    file = tmp_path / "town.osm"
    file.write_text('<osm version="0.6">\n' + "\n".join(sum(elements.values(), [])) + "\n</osm>\n")
    return file


def test_a_town_in_tiles_is_the_town_in_one_piece(spark, program, deadly, tmp_path):
    """One tile of damaged data and one worker that dies: the other tiles stand, and a second call builds what is missing."""
    from lanewright.spark import build_tiles

    extract = SHARED / "corpus" / "osm" / "harrisburg.osm"
    if not extract.is_file():
        extract = town(tmp_path)
    size = 4000 if extract.stat().st_size > 1e6 else 800
    run(program, "build", extract, "-o", tmp_path / "whole", "--cells", 100, "--isolated")
    run(program, "cut", extract, "-o", tmp_path / "cut", "--tiles", size, "--isolated")
    listed = json.loads((tmp_path / "cut" / "cut.json").read_text())["tiles"]
    assert len(listed) >= (16 if size == 4000 else 4)
    # The smallest tile with something in it.
    damaged = min(listed, key=lambda tile: (tile["bytes"] < 3000, tile["bytes"]))
    name = f"{damaged['column']}_{damaged['row']}"
    data = tmp_path / "cut" / "tiles" / f"{name}.osm"
    good = data.read_bytes()
    data.write_bytes(good[: len(good) // 2])

    first = build_tiles(spark, tmp_path / "cut", tmp_path / "map")
    assert not deadly.exists(), "no worker died"
    assert (first.missing, first.complete) == ([name], False)
    of_first = rows(first)
    assert len(of_first) == len(listed)
    assert f"{name}.osm" in of_first[name]["error"]
    assert all(row["error"] is None for tile, row in of_first.items() if tile != name)
    assert not (tmp_path / "map" / "lanelet2_map_metadata.yaml").exists()
    stood = times(tmp_path / "map" / "lanelet2_map.osm")

    data.write_bytes(good)
    second = build_tiles(spark, tmp_path / "cut", tmp_path / "map")
    of_second = rows(second)
    assert second.complete and second.missing == []
    assert [tile for tile, row in of_second.items() if row["seconds"] is not None] == [name]
    now = times(tmp_path / "map" / "lanelet2_map.osm")
    assert {file: now[file] for file in stood} == stood, "a tile that stood was built again"
    whole = files(tmp_path / "whole")
    built = files(tmp_path / "map")
    assert sorted(built) == sorted(whole)
    assert built == whole
    assert sum(row["cells"] for row in of_second.values()) == len(whole) - 3
    assert all(row["peak_memory"] > 1e6 for row in of_first.values())

    before = times(tmp_path / "map")
    third = build_tiles(spark, tmp_path / "cut", tmp_path / "map")
    assert third.complete and times(tmp_path / "map") == before, "a second run changes something"

    def counts(result):
        return {tile: (row["cells"], row["elements"], row["notes"]) for tile, row in rows(result).items()}

    assert counts(third) == counts(second)


def table(extract, file):
    """The elements of an extract as a Parquet table."""
    import pyarrow
    import pyarrow.parquet
    from xml.etree import ElementTree

    kinds = {"node": 0, "way": 1, "relation": 2}
    elements = [one for one in ElementTree.parse(extract).getroot() if one.tag in kinds]
    number = lambda one, key: float(one.get(key)) if one.get(key) else None  # noqa: E731
    schema = pyarrow.schema([
        ("id", pyarrow.int64()), ("type", pyarrow.string()), ("lat", pyarrow.float64()), ("lon", pyarrow.float64()),
        ("tags", pyarrow.map_(pyarrow.string(), pyarrow.string())),
        ("nds", pyarrow.list_(pyarrow.struct([("ref", pyarrow.int64())]))),
        ("members", pyarrow.list_(pyarrow.struct(
            [("type", pyarrow.string()), ("ref", pyarrow.int64()), ("role", pyarrow.string())]
        ))),
    ])
    made = [{
        "id": int(one.get("id")), "type": one.tag, "lat": number(one, "lat"), "lon": number(one, "lon"),
        "tags": [(tag.get("k"), tag.get("v")) for tag in one.iter("tag")],
        "nds": [{"ref": int(node.get("ref"))} for node in one.iter("nd")],
        "members": [
            {"type": member.get("type"), "ref": int(member.get("ref")), "role": member.get("role")}
            for member in one.iter("member")
        ],
    } for one in elements]
    # Not in the order of a file.
    pyarrow.parquet.write_table(pyarrow.Table.from_pylist(made[::-1], schema), file, row_group_size=50)


def terrain(file):
    """A GeoTIFF in degrees that rises from west to east around the samples, 60 x 60 heights."""
    side, step = 60, 0.002
    west, north = 8.52, 49.06
    heights = struct.pack(f"<{side * side}f", *(100.0 + 0.5 * (at % side) for at in range(side * side)))
    doubles = struct.pack("<9d", step, step, 0.0, 0.0, 0.0, 0.0, west, north, 0.0)
    keys = struct.pack("<16H", 1, 1, 0, 3, 1024, 0, 1, 2, 1025, 0, 1, 1, 2048, 0, 1, 4326)
    first = 8 + len(heights)
    tags = [
        (256, 3, 1, side), (257, 3, 1, side), (258, 3, 1, 32), (259, 3, 1, 1), (262, 3, 1, 1), (273, 4, 1, 8), (277, 3, 1, 1),
        (278, 3, 1, side), (279, 4, 1, len(heights)), (339, 3, 1, 3),
        (33550, 12, 3, first), (33922, 12, 6, first + 24), (34735, 3, 16, first + 72),
    ]
    directory = struct.pack("<H", len(tags)) + b"".join(struct.pack("<HHII", *tag) for tag in tags) + bytes(4)
    file.write_bytes(b"II*\0" + struct.pack("<I", first + 104) + heights + doubles + keys + directory)
    return file


def test_a_table_of_elements_and_a_file_system_elsewhere(spark, program, tmp_path):
    from lanewright.spark import build_tiles, check_maps

    extract = town(tmp_path)
    dem = terrain(tmp_path / "ground.tif")
    run(program, "build", extract, "-o", tmp_path / "whole", "--tiles", 800, "--isolated", "--dem", dem)
    (tmp_path / "elements").mkdir()
    table(extract, tmp_path / "elements" / "part-0.parquet")
    elsewhere = f"elsewhere://{tmp_path}"
    options = {"tiles": 800, "isolated": True, "dem": dem, "check": True}
    for source, to in (("elements", "from_table"), ("town.osm", "from_file")):
        made = build_tiles(spark, f"{elsewhere}/{source}", f"{elsewhere}/{to}", **options)
        assert made.complete, made.tiles.collect()
        assert files(tmp_path / to) == files(tmp_path / "whole"), source
    found = rows(made)
    before = times(tmp_path / "from_file")
    again = build_tiles(spark, f"{elsewhere}/town.osm", f"{elsewhere}/from_file", **options)
    assert again.complete and times(tmp_path / "from_file") == before

    maps = [f"{elsewhere}/from_file", str(tmp_path / "whole"), str(tmp_path / "none")]
    of_maps = {row["map"]: row for row in check_maps(spark, maps, per="map").collect()}
    expected = lanewright.check(tmp_path / "whole")
    for name in maps[:2]:
        row = of_maps[name]
        assert (row["errors"], row["warnings"], row["infos"]) == (expected.errors, expected.warnings, expected.infos)
    assert "none" in of_maps[maps[2]]["error"] and of_maps[maps[2]]["errors"] is None
    assert sum(row["errors"] for row in found.values()) == expected.errors
    findings = [row for row in check_maps(spark, maps).collect()]
    for name in maps[:2]:
        assert [row["code"] for row in findings if row["map"] == name] == [finding.code for finding in expected]
        assert all(row["file"] is None or row["file"].startswith(name) for row in findings if row["map"] == name)
    assert [row["map"] for row in findings if row["error"] is not None] == [maps[2]]


def test_an_id_that_two_elements_want(spark, program, tmp_path):
    """Only the tiles are built again in which it stands, and neither element has it."""
    from lanewright.spark import build_tiles

    run(program, "cut", town(tmp_path), "-o", tmp_path / "cut", "--tiles", 800, "--isolated")
    assert build_tiles(spark, tmp_path / "cut", tmp_path / "map").complete
    cells = "".join(file.read_text() for file in (tmp_path / "map" / "lanelet2_map.osm").iterdir())
    areas = re.findall(r'<way id="(\d+)"(?:(?!</way>).)*"intersection_area"', cells, re.DOTALL)
    records = {file: json.loads(file.read_text()) for file in (tmp_path / "map" / ".tiles" / "records").iterdir()}
    wanted, has = next((int(area), file) for area in areas for file, record in records.items() if int(area) in record["own"])
    # As if another element, far away, had the same.
    other = next(file for file, record in records.items() if file != has and record["own"])
    records[other]["own"].append(wanted)
    other.write_text(json.dumps(records[other]))
    (tmp_path / "map" / "lanelet2_map_metadata.yaml").unlink()

    again = build_tiles(spark, tmp_path / "cut", tmp_path / "map")
    assert again.complete
    built = {tile for tile, row in rows(again).items() if row["seconds"] is not None}
    assert {has.stem, other.stem} <= built and len(built) < len(records)
    assert json.loads((tmp_path / "map" / ".tiles" / "contested.json").read_text()) == [wanted]
    cells = "".join(file.read_text() for file in (tmp_path / "map" / "lanelet2_map.osm").iterdir())
    assert f'"{wanted}"' not in cells and '"intersection_area"' in cells


def test_what_is_refused(spark, sample, tmp_path):
    from lanewright.spark import build_tiles, check_maps

    lanewright.cut(sample, tmp_path / "cut", tiles=800)
    with pytest.raises(ValueError, match="is cut already"):
        build_tiles(spark, tmp_path / "cut", tmp_path / "map", tiles=900)
    with pytest.raises(lanewright.ReadError):
        build_tiles(spark, tmp_path / "none.osm", tmp_path / "map")
    with pytest.raises(lanewright.ConfigError, match="whole cells"):
        build_tiles(spark, sample, tmp_path / "map", tiles=850)
    assert build_tiles(spark, tmp_path / "cut", tmp_path / "map").complete
    lanewright.cut(sample, tmp_path / "other", tiles=900)
    with pytest.raises(lanewright.WriteError, match="other data or sizes"):
        build_tiles(spark, tmp_path / "other", tmp_path / "map")
    lanewright.build(sample, tmp_path / "there")
    with pytest.raises(lanewright.WriteError, match="is there already"):
        build_tiles(spark, tmp_path / "cut", tmp_path / "there")
    with pytest.raises(ValueError, match="per"):
        check_maps(spark, [], per="lanelet")


def test_the_stages_without_spark(sample, program, tmp_path):
    """What Spark does can be done by whoever has machines."""
    text = lanewright.cut(sample, tmp_path / "cut", tiles=800, cells=50)
    described = json.loads(text)
    assert (tmp_path / "cut" / "cut.json").read_text() == text
    assert (described["tile"], described["cell"], described["margin"]) == (800, 50, 600)
    records, cells = tmp_path / "records", {}
    records.mkdir()
    for tile in described["tiles"]:
        name, built = f"{tile['column']}_{tile['row']}", []
        data = tmp_path / "cut" / "tiles" / f"{name}.osm"
        assert data.stat().st_size == tile["bytes"]
        for at, given in enumerate((data, data.read_bytes())):
            folder = tmp_path / f"{name}_{at}"
            folder.mkdir()
            built.append((lanewright.build_tile(text, (tile["column"], tile["row"]), given, folder), files(folder)))
        (first, of_first), (second, of_second) = built
        assert first.record == second.record and of_first == of_second
        assert sorted(of_first) == sorted(first.cells)
        cells.update({f"lanelet2_map.osm/{cell}": content for cell, content in of_first.items()})
        (records / f"{name}.json").write_bytes(first.record)
    joined = lanewright.join_tiles(text, records)
    assert joined.again == [] and joined.contested == []
    run(program, "build", sample, "-o", tmp_path / "whole", "--tiles", 800, "--cells", 50)
    assert {**cells, **{name: content.encode() for name, content in joined.files.items()}} == files(tmp_path / "whole")
    with pytest.raises(lanewright.ReadError, match="remembered of a tile"):
        lanewright.join_tiles(text, tmp_path)
    with pytest.raises(lanewright.ReadError, match="cut by lanewright 0.0.0"):
        lanewright.join_tiles(text.replace(lanewright.__version__, "0.0.0", 1), records)
