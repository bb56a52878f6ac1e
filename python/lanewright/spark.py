"""Maps of whole countries on Apache Spark: `pip install lanewright[spark]`, docs/scale.md.

    from pyspark.sql import SparkSession
    from lanewright.spark import build_tiles, check_maps

    spark = SparkSession.builder.getOrCreate()
    result = build_tiles(spark, "country_cut", "hdfs:///maps/country")
    result.tiles.orderBy("seconds", ascending=False).show()
    check_maps(spark, ["hdfs:///maps/country"]).groupBy("code").count().show()

Scheduling and retries are Spark's. Paths are those of fsspec: of the local disk where all machines see the same, `hdfs://`,
`s3://` and so on. The package must be installed where Spark's Python workers run.
"""

import functools
import json
import os
import pathlib
import tempfile
import time
import uuid
from dataclasses import dataclass
from typing import Any, Dict, List, Optional, Sequence, Tuple, Union

import lanewright
from pyspark.sql import DataFrame, SparkSession

from ._check_maps import FINDINGS, MAPS, check_maps
from ._elements import write_osm
from ._storage import Place
from ._tasks import MOST_TASKS, Memory, each, scratch, threads_of

__all__ = ["TILES", "FINDINGS", "MAPS", "BuiltTiles", "build_tiles", "check_maps"]

_Path = Union[str, "os.PathLike[str]"]

#: The columns of `BuiltTiles.tiles`. Findings are counted where the build was to check; seconds, processor seconds and peak memory
#: (bytes, of the worker) are those of the call that built the tile, and null in a later one.
TILES = (
    "tile string, column int, row int, cells int, elements long, notes long, errors long, warnings long, infos long, "
    "seconds double, cpu_seconds double, peak_memory long, error string"
)
_CELLS = "lanelet2_map.osm"
_METADATA = "lanelet2_map_metadata.yaml"
_BESIDE = ("map_projector_info.yaml", "lanewright.toml", _METADATA)
#: The folder in the output with what is remembered of its tiles.
_MEMORY = ".tiles"


@dataclass(frozen=True)
class BuiltTiles:
    """What came of a map that was built in tiles.

    Attributes:
        tiles: A row for each tile (TILES).
        missing: The tiles that could not be built, COLUMN_ROW. A further call builds only these.
        complete: Whether the map is complete. If not, its list of cells was not written, and nothing loads it.
        output: The directory of the map.
    """

    tiles: DataFrame
    missing: List[str]
    complete: bool
    output: str


def build_tiles(
    spark: SparkSession,
    input: _Path,
    output: _Path,
    *,
    tiles: Optional[int] = None,
    cells: Optional[int] = None,
    margin: Optional[int] = None,
    driving_side: Optional[str] = None,
    projector: Optional[str] = None,
    dem: Optional[_Path] = None,
    profile: Optional[str] = None,
    config: Any = None,
    isolated: bool = False,
    check: bool = False,
    partitions: Optional[int] = None,
    storage_options: Optional[Dict[str, Any]] = None,
) -> BuiltTiles:
    """Build a map in tiles, each in a task of Spark, and write it in cells: the bytes of `lanewright build --tiles`.

    A tile that cannot be built is a row with its error, and the others stand. What was built is not built again by a further call
    with the same input and output, be it after an error or when all is done.

    Args:
        spark: The session.
        input: A folder that `lanewright cut` has made; or OpenStreetMap data (.osm, .osm.gz, .osm.pbf), or a Parquet table of its
            elements (docs/scale.md), which are cut by this process first.
        output: The directory of the map.
        tiles: Width and height of a tile, metres; of this argument and those down to `isolated`, a cut folder has its own.
        cells: As for `lanewright.cut`, as are the following.
        margin: How far around a tile data are read with it.
        driving_side: Side of the road on which people drive.
        projector: Projection of the map.
        dem: A terrain model.
        profile: Whose reading of the requirements the map follows.
        config: Settings.
        isolated: Whether to read no lanewright.toml that is not named.
        check: Whether to hold each tile against Autoware's requirements, too, and count what is found in it.
        partitions: Number of tasks; one for each tile, up to 20,000, if None.
        storage_options: What fsspec needs to know of the file systems.

    Returns:
        A row for each tile, and whether the map is complete, as BuiltTiles.

    Raises:
        lanewright.Error: The input cannot be read or has no road; tiles disagree, so that a larger margin is needed; the output
            holds another map.
    """
    said = {
        "tiles": tiles, "cells": cells, "margin": margin, "driving_side": driving_side, "projector": projector,
        "dem": dem, "profile": profile, "config": config, "isolated": isolated or None,
    }
    said = {name: value for name, value in said.items() if value is not None}
    goal = _Goal(Place(output, storage_options))
    description, data = goal.cut(Place(input, storage_options), said)
    head = json.loads(description)
    listed = [(tile["column"], tile["row"], tile["bytes"]) for tile in head.pop("tiles")]
    job = _Job(json.dumps(head), data, goal.place, goal.contested(), check, threads_of(spark))
    todo, rows = listed, {}
    while True:
        job.begin()
        try:
            rows.update({row["tile"]: row for row in _run(spark, job, todo, partitions)})
        finally:
            job.end()
        missing = sorted(name for name, row in rows.items() if row["error"] is not None)
        table = spark.createDataFrame([tuple(rows[_name(column, row)]) for column, row, _ in listed], TILES)
        if missing:
            return BuiltTiles(table, missing, False, str(goal.place))
        again = goal.join(description, job.contested)
        if again is None:
            return BuiltTiles(table, [], True, str(goal.place))
        job.contested = again.contested
        wanted = set(again.again)
        todo = [tile for tile in listed if tile[:2] in wanted]


def _name(column: int, row: int) -> str:
    return f"{column}_{row}"


class _Goal:
    """The directory of a map, and what is remembered of its tiles in a hidden folder there."""

    def __init__(self, place: Place):
        self.place, self.memory = place, place / _MEMORY

    def cut(self, input: Place, said: Dict[str, Any]) -> Tuple[str, Place]:
        """The description of the cut data, and where they lie; they are cut if they are not yet."""
        if not self.memory.exists():
            there = [name for name in (_CELLS, *_BESIDE) if (self.place / name).exists()]
            if there:
                raise lanewright.WriteError(f"{self.place / there[0]} is there already; give another output")
        given = input / "cut.json"
        if given.exists():
            if said:
                raise ValueError(f"{', '.join(said)}: {input} is cut already, and has its own")
            description, data = given.read().decode(), input
        else:
            description, data = self._cut_here(input, said)
        kept = self.memory / "cut.json"
        if not kept.exists():
            self.memory.make()
            kept.write(description.encode())
        elif kept.read().decode() != description:
            raise lanewright.WriteError(f"{self.place} holds tiles of other data or sizes; give another output")
        return description, data

    def _cut_here(self, input: Place, said: Dict[str, Any]) -> Tuple[str, Place]:
        """Cuts data that are not cut, unless an earlier call has done it with the same."""
        if not input.exists():
            raise lanewright.ReadError(f"{input} is not there")
        table = input.is_directory() or input.path.endswith(".parquet")
        about = [str(input), input.state()]
        begun = json.dumps([about, lanewright.__version__, sorted((name, str(value)) for name, value in said.items())])
        data, noted = self.memory / "cut", self.memory / "input.json"
        if noted.exists() and noted.read().decode() == begun and (self.memory / "cut.json").exists():
            return (self.memory / "cut.json").read().decode(), data
        if noted.exists():
            raise lanewright.WriteError(f"{self.place} holds tiles of other data or sizes; give another output")
        data.remove()
        self.memory.make()
        with scratch(self.memory) as folder:
            if table:
                source = folder / "elements.osm.gz"
                write_osm(input, source)
            else:
                source = input.fetch(folder)
            made = pathlib.Path(data.path) if data.local else folder / "cut"
            description = lanewright.cut(source, made, **{"tiles": 8000, **said})
            if not data.local:
                for local, to in ((made, data), (made / "tiles", data / "tiles")):
                    to.make()
                    to.put(sorted(file for file in local.iterdir() if file.is_file()))
        noted.write(begun.encode())
        return description, data

    def contested(self) -> List[int]:
        """The ids that two elements of the map want, as far as it is known."""
        known = self.memory / "contested.json"
        return json.loads(known.read()) if known.exists() else []

    def join(self, description: str, contested: List[int]) -> "Optional[lanewright.JoinedTiles]":
        """Puts the tiles together. What must be built again first is forgotten and told."""
        if (self.place / _METADATA).exists():
            return None
        with scratch(self.memory) as folder:
            records = (self.memory / "records").fetch(folder)
            joined = lanewright.join_tiles(description, records, contested=contested)
        if joined.again:
            for column, row in joined.again:
                (self.memory / "records" / f"{_name(column, row)}.json").remove()
            # Not before the tiles are forgotten that know nothing of it.
            (self.memory / "contested.json").write(json.dumps(joined.contested).encode())
            return joined
        # The list of the cells comes last: with it the map is there.
        for name in _BESIDE:
            (self.place / name).write(joined.files[name].encode())
        return None


@dataclass
class _Job:
    """What every task must know. It is sent to the workers."""

    description: str
    data: Place
    output: Place
    contested: List[int]
    check: bool
    threads: int
    round: str = ""

    def open(self) -> Place:
        """Where tiles of this round are built. Who is late, and was given up, finds it gone and puts nothing into its place."""
        return self.output / _MEMORY / "open" / self.round

    def records(self) -> Place:
        return self.output / _MEMORY / "records"

    def begin(self) -> None:
        self.round = uuid.uuid4().hex
        for folder in (self.open(), self.records(), self.output / _CELLS):
            folder.make()

    def end(self) -> None:
        (self.output / _MEMORY / "open").remove()


def _run(spark: SparkSession, job: _Job, tiles: Sequence[Tuple[int, int, int]], partitions: Optional[int]) -> List[Any]:
    """Builds tiles, the largest first; those that are built already only give their row."""
    tasks = max(1, min(partitions or MOST_TASKS, len(tiles)))
    largest_first = sorted(tiles, key=lambda tile: (-tile[2], tile))
    rows = [(column, row, at % tasks) for at, (column, row, _) in enumerate(largest_first)]
    table = spark.createDataFrame(rows, "column int, row int, task int").repartitionByRange(tasks, "task")
    return table.mapInArrow(functools.partial(each, functools.partial(_tile, job), TILES), TILES).collect()


def _tile(job: _Job, row: Dict[str, Any]) -> List[Dict[str, Any]]:
    """Builds one tile, in a task. Its record comes last: a tile with a record has all of its cells in their place."""
    name = _name(row["column"], row["row"])
    told = {"tile": name, "column": row["column"], "row": row["row"]}
    begun, worked, memory = time.monotonic(), time.process_time(), Memory()
    try:
        record = job.records() / f"{name}.json"
        if record.exists():
            return [{**told, **_counts(record.read())}]
        content = _build(job, row["column"], row["row"])
        record.write(content)
        told.update(_counts(content))
    except Exception as error:  # Whatever it is, it is about this tile.
        told["error"] = str(error) if isinstance(error, lanewright.Error) else f"{type(error).__name__}: {error}"
    spent = {"seconds": time.monotonic() - begun, "cpu_seconds": time.process_time() - worked}
    return [{**told, **spent, "peak_memory": memory.peak()}]


def _counts(record: bytes) -> Dict[str, Any]:
    known = json.loads(record)
    errors, warnings, infos = known["findings"] or (None, None, None)
    counts = {"cells": len(known["cells"]), "elements": known["elements"], "notes": known["notes"]}
    return {**counts, "errors": errors, "warnings": warnings, "infos": infos}


def _build(job: _Job, column: int, row: int) -> bytes:
    """Builds a tile, moves its cells into their place, and gives its record."""
    data = job.data / "tiles" / f"{_name(column, row)}.osm"
    dem = _terrain(job.data) if json.loads(job.description)["terrain"] else None
    # Beside the map where that is a local disk, so that cells need only be moved.
    with scratch(job.open()) as folder:
        tile = lanewright.build_tile(
            job.description, (column, row), data.path if data.local else data.read(), folder,
            contested=job.contested, dem=dem, check=job.check, threads=job.threads,
        )
        if job.output.local:
            drafts = Place(folder)
        else:
            drafts = job.open() / uuid.uuid4().hex
            drafts.make()
            drafts.put(folder / cell for cell in tile.cells)
        for cell in tile.cells:
            (drafts / cell).move(job.output / _CELLS / cell)
        return tile.record


#: The terrain model that this worker has fetched last, and the directory that goes with it.
_FETCHED: "Dict[str, Tuple[pathlib.Path, tempfile.TemporaryDirectory[str]]]" = {}


def _terrain(data: Place) -> pathlib.Path:
    """The terrain model of cut data, for all tiles of a worker."""
    place = data / "terrain.tif"
    if str(place) not in _FETCHED:
        _FETCHED.clear()
        folder = tempfile.TemporaryDirectory(prefix="lanewright-")
        _FETCHED[str(place)] = place.fetch(folder.name), folder
    return _FETCHED[str(place)][0]
