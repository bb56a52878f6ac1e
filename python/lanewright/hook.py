"""The hook of pre-commit: holds each of the maps that it is given against the rules."""

import sys

from ._lanewright import main


def run():
    """Check the files on the command line; exit code 1 if one of them has errors, 2 if one cannot be read."""
    return max((main(["check", "--format", "concise", "--", map_file]) for map_file in sys.argv[1:]), default=0)
