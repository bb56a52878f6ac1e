"""What tasks of Spark share: rows in and out, a place to work in, and how much memory they take."""

import contextlib
import pathlib
import sys
import tempfile
from typing import Any, Callable, Dict, Iterable, Iterator, Optional

import pyarrow  # type: ignore[import-untyped]
from pyspark.sql import SparkSession

from ._storage import Place

#: Most tasks of a job, unless more are asked for: of more, Spark's driver is busy with counting them.
MOST_TASKS = 20_000


def threads_of(spark: SparkSession) -> int:
    """How many threads a task may use."""
    return int(spark.conf.get("spark.task.cpus", "1") or 1)


@contextlib.contextmanager
def scratch(beside: Optional[Place] = None) -> Iterator[pathlib.Path]:
    """A directory that is gone afterwards; on the same disk as a local place."""
    home = beside.path if beside is not None and beside.local else None
    with tempfile.TemporaryDirectory(prefix="lanewright-", dir=home) as scratch:
        yield pathlib.Path(scratch)


def each(
    work: Callable[[Dict[str, Any]], Iterable[Dict[str, Any]]], columns: str, batches: Iterable[pyarrow.RecordBatch]
) -> Iterator[pyarrow.RecordBatch]:
    """Rows that come of rows, one after the other."""
    types = {"string": pyarrow.string(), "int": pyarrow.int32(), "long": pyarrow.int64(), "double": pyarrow.float64()}
    schema = pyarrow.schema([(name, types[kind]) for name, kind in (one.split() for one in columns.split(", "))])
    for batch in batches:
        for row in batch.to_pylist():
            made = [{name: one.get(name) for name in schema.names} for one in work(row)]
            if made:
                yield pyarrow.RecordBatch.from_pylist(made, schema=schema)


class Memory:
    """The most memory that this process takes from now on; where the system does not count anew, the most since it began."""

    def __init__(self) -> None:
        with contextlib.suppress(OSError), open("/proc/self/clear_refs", "w") as counter:
            counter.write("5")

    def peak(self) -> int:
        """Bytes."""
        with contextlib.suppress(OSError), open("/proc/self/status") as status:
            for line in status:
                if line.startswith("VmHWM:"):
                    return 1024 * int(line.split()[1])
        import resource  # Windows has none.

        most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        return most if sys.platform == "darwin" else 1024 * most
