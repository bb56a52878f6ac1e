"""Lanelet2 maps for Autoware: built from OpenStreetMap, held against Autoware's requirements, mended.

    import lanewright

    built = lanewright.build("town.osm.pbf", "map")     # what `lanewright build town.osm.pbf -o map` writes
    for finding in lanewright.check("map"):
        print(finding.severity, finding.code, finding.lon, finding.lat, finding.message)

Inputs are paths (str or os.PathLike) or bytes. Units are metres, seconds, radians; speeds km/h; longitude and latitude
degrees; x is east, y is north. Other Python threads go on while a function works, and Ctrl-C ends it.
"""

from ._lanewright import (
    BuildError,
    BuildSummary,
    BuiltMap,
    BuiltTile,
    CheckResult,
    ConfigError,
    Error,
    Fault,
    Finding,
    Fix,
    FixResult,
    InternalError,
    JoinedTiles,
    Measure,
    Mend,
    Note,
    Parameter,
    Place,
    Primitive,
    ReadError,
    Rule,
    Streets,
    WriteError,
    __version__,
    build,
    build_tile,
    check,
    cut,
    fix,
    geometry,
    join_tiles,
    main,
    rules,
)

__all__ = [
    "BuildError",
    "BuildSummary",
    "BuiltMap",
    "BuiltTile",
    "CheckResult",
    "ConfigError",
    "Error",
    "Fault",
    "Finding",
    "Fix",
    "FixResult",
    "InternalError",
    "JoinedTiles",
    "Measure",
    "Mend",
    "Note",
    "Parameter",
    "Place",
    "Primitive",
    "ReadError",
    "Rule",
    "Streets",
    "WriteError",
    "__version__",
    "build",
    "build_tile",
    "check",
    "cut",
    "fix",
    "geometry",
    "join_tiles",
    "main",
    "rules",
]
