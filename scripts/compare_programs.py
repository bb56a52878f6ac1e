#!/usr/bin/env python3
"""Holds two lanewright programs against each other: the same bytes of every map that they build, and how long each takes.

Usage: compare_programs.py ONE OTHER INPUT.osm... [--runs N] [--at-most RATIO]
The programs take turns; of each the least time of N runs counts. Exits with 1 where a byte differs, or where ONE takes more than
RATIO times as long as OTHER over all inputs together.
"""

import argparse
import hashlib
import pathlib
import subprocess
import sys
import tempfile
import time


def build(program, source, directory):
    """Seconds, and a digest of every file that was written and of what was printed."""
    output = pathlib.Path(directory, "map")
    start = time.monotonic()
    done = subprocess.run([program, "build", source, "-o", output], capture_output=True, check=False)
    seconds = time.monotonic() - start
    digest = hashlib.sha256(bytes([done.returncode]) + done.stdout.replace(bytes(output), b"") + done.stderr)
    for file in sorted(output.glob("*")):
        digest.update(file.name.encode() + file.read_bytes())
    return seconds, digest.hexdigest()


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("one")
    parser.add_argument("other")
    parser.add_argument("inputs", nargs="+")
    parser.add_argument("--runs", type=int, default=1)
    parser.add_argument("--at-most", type=float, default=None)
    options = parser.parse_args()

    total = {options.one: 0.0, options.other: 0.0}
    different = []
    for source in options.inputs:
        least = dict.fromkeys(total, float("inf"))
        digests = set()
        for _ in range(options.runs):
            for program in total:
                with tempfile.TemporaryDirectory() as directory:
                    seconds, digest = build(program, source, directory)
                least[program] = min(least[program], seconds)
                digests.add(digest)
        for program, seconds in least.items():
            total[program] += seconds
        if len(digests) > 1:
            different.append(source)
    for source in different:
        print(f"{source}: the two programs build different maps", file=sys.stderr)
    ratio = total[options.one] / total[options.other]
    print(f"{len(options.inputs)} maps, {len(different)} differ; {total[options.one]:.2f} s and {total[options.other]:.2f} s: {ratio:.2f} times")
    sys.exit(bool(different) or (options.at_most is not None and ratio > options.at_most))


if __name__ == "__main__":
    main()
