"""Maps held against Autoware's requirements, each in a task of Spark."""

import functools
import os
import time
from typing import Any, Dict, Iterable, List, Optional, Union

import lanewright
from pyspark.sql import DataFrame, SparkSession

from ._storage import Place
from ._tasks import MOST_TASKS, Memory, each, scratch, threads_of

#: The columns of `check_maps`.
FINDINGS = (
    "map string, code string, severity string, message string, help string, kind string, id long, lon double, lat double, "
    "x double, y double, file string, line long, error string"
)
#: The columns of `check_maps(per="map")`.
MAPS = "map string, errors long, warnings long, infos long, suppressed long, seconds double, peak_memory long, error string"


def check_maps(
    spark: SparkSession,
    paths: Iterable[Union[str, "os.PathLike[str]"]],
    *,
    per: str = "finding",
    profile: Optional[str] = None,
    select: Any = None,
    ignore: Any = None,
    config: Any = None,
    isolated: bool = False,
    partitions: Optional[int] = None,
    storage_options: Optional[Dict[str, Any]] = None,
) -> DataFrame:
    """Hold maps against Autoware's requirements, each in a task of Spark. It begins when rows are asked for.

    Args:
        spark: The session.
        paths: The maps: .osm files or map directories, divided or not.
        per: What a row is about: 'finding' (FINDINGS) or 'map' (MAPS). A map that cannot be read is a row with its error.
        profile: As for `lanewright.check`, as are the following.
        select: Only these rules or faults.
        ignore: Not these rules or faults.
        config: Settings.
        isolated: Whether to read no lanewright.toml that is not named.
        partitions: Number of tasks; one for each map, up to 20,000, if None.
        storage_options: What fsspec needs to know of the file systems.

    Returns:
        The rows.
    """
    if per not in ("finding", "map"):
        raise ValueError(f"per: expected one of 'finding', 'map', not '{per}'")
    columns = FINDINGS if per == "finding" else MAPS
    options = {
        "profile": profile, "select": select, "ignore": ignore, "config": config, "isolated": isolated,
        "threads": threads_of(spark),
    }
    maps = [(str(Place(path, storage_options)),) for path in paths]
    tasks = max(1, min(partitions or MOST_TASKS, len(maps)))
    table = spark.createDataFrame(maps, "map string").repartition(tasks)
    work = functools.partial(_findings, per, options, storage_options)
    return table.mapInArrow(functools.partial(each, work, columns), columns)


def _findings(
    per: str, options: Dict[str, Any], storage_options: Optional[Dict[str, Any]], row: Dict[str, Any]
) -> List[Dict[str, Any]]:
    """Checks one map, in a task."""
    place, begun, memory = Place(row["map"], storage_options), time.monotonic(), Memory()
    try:
        with scratch() as folder:
            local = place.fetch(folder)
            beside = Place(place.fs._parent(place.path), storage_options) / "map_projector_info.yaml"
            if not place.local and local.is_file() and beside.exists():
                beside.fetch(folder)
            result = lanewright.check(local, **options)
            if per == "map":
                counts = {"errors": result.errors, "warnings": result.warnings, "infos": result.infos}
                peak = {"suppressed": result.suppressed, "peak_memory": memory.peak()}
                return [{"map": row["map"], **counts, **peak, "seconds": time.monotonic() - begun}]
            return [_finding(row["map"], str(local), finding) for finding in result]
    except Exception as error:  # Whatever it is, it is about this map.
        return [{"map": row["map"], "error": str(error)}]


def _finding(map: str, local: str, finding: "lanewright.Finding") -> Dict[str, Any]:
    file = finding.file
    if file is not None and file.startswith(local):
        file = map + file[len(local) :]
    named = ("code", "severity", "message", "help", "kind", "id", "lon", "lat", "x", "y", "line")
    return {"map": map, "file": file, **{name: getattr(finding, name) for name in named}}
