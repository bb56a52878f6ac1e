"""OpenStreetMap elements in a Parquet table, written as OpenStreetMap XML. The table is read block by block."""

import decimal
import gzip
import pathlib
from typing import Any, Dict, Iterator
from xml.sax.saxutils import quoteattr

import pyarrow.dataset  # type: ignore[import-untyped]

from ._storage import Place

#: What cannot stand in XML, in whatever way it is written.
_UNWRITABLE = {code: None for code in range(32) if code not in (9, 10, 13)}
#: Rows that are in memory at a time.
_ROWS = 50_000
_COLUMNS = ("id", "type", "lat", "lon", "tags", "nds", "members", "visible")


def write_osm(table: Place, file: pathlib.Path) -> None:
    """Writes the elements of a table (a file, or a directory of files) into a .osm.gz file: nodes, ways, relations."""
    elements = pyarrow.dataset.dataset(table.path, filesystem=table.fs, format="parquet")
    missing = [name for name in ("id", "type", "lat", "lon", "tags") if name not in elements.schema.names]
    if missing:
        raise ValueError(f"{table} has no column {', '.join(missing)}: it is no table of OpenStreetMap elements (docs/scale.md)")
    columns = [name for name in _COLUMNS if name in elements.schema.names]
    with gzip.open(file, "wt", compresslevel=1, encoding="utf-8") as out:
        out.write('<?xml version="1.0" encoding="UTF-8"?>\n<osm version="0.6" generator="lanewright">\n')
        for kind in ("node", "way", "relation"):
            rows = elements.scanner(
                columns=columns,
                filter=pyarrow.dataset.field("type") == kind,
                batch_size=_ROWS,
                batch_readahead=2,
                fragment_readahead=1,
            )
            for batch in rows.to_batches():
                out.writelines(_element(kind, row) for row in batch.to_pylist() if row.get("visible") is not False)
        out.write("</osm>\n")


def _element(kind: str, row: Dict[str, Any]) -> str:
    """An element, and what is in it."""
    head = f'<{kind} id="{row["id"]}"'
    if kind == "node" and row["lat"] is not None and row["lon"] is not None:
        head += f' lat="{_degrees(row["lat"])}" lon="{_degrees(row["lon"])}"'
    inner = "".join(_inner(row))
    return f"{head}>{inner}</{kind}>\n" if inner else f"{head}/>\n"


def _inner(row: Dict[str, Any]) -> Iterator[str]:
    for node in row.get("nds") or []:
        yield f'<nd ref="{node["ref"] if isinstance(node, dict) else node}"/>'
    for member in row.get("members") or []:
        yield f'<member type="{member["type"]}" ref="{member["ref"]}" role={_quoted(member["role"] or "")}/>'
    tags = row["tags"] or []
    for key, value in tags.items() if isinstance(tags, dict) else tags:
        yield f"<tag k={_quoted(key)} v={_quoted(value or '')}/>"


def _degrees(value: Any) -> str:
    return format(value, "f") if isinstance(value, decimal.Decimal) else repr(float(value))


def _quoted(text: str) -> str:
    return quoteattr(text.translate(_UNWRITABLE), {"\n": "&#10;", "\r": "&#13;", "\t": "&#9;"})
