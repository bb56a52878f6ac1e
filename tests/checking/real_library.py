"""What the scripts share that ask the real Lanelet2 library about maps: an origin for each, a process for each, one answer on stdout."""
import json
import os
import sys
import xml.etree.ElementTree as xml

# The library prints warnings of its own, which go to standard error. This module is imported before the library.
ANSWER = os.fdopen(os.dup(1), "w")
os.dup2(2, 1)

import lanelet2.io


def origin(path):
    """The place of the first node that lies on earth."""
    for _, node in xml.iterparse(path):
        if node.tag == "node":
            lat, lon = float(node.get("lat") or 0), float(node.get("lon") or 0)
            if abs(lat) <= 90 and abs(lon) <= 180:
                return lanelet2.io.Origin(lat, lon)
    return lanelet2.io.Origin(0, 0)


def apart(ask, path):
    """What `ask` says of a map, in a process of its own: the library ends the process on some broken maps. None if it did."""
    read, write = os.pipe()
    child = os.fork()
    if child == 0:
        with os.fdopen(write, "w") as out:
            json.dump(ask(path), out)
        os._exit(0)
    os.close(write)
    with os.fdopen(read) as answer:
        text = answer.read()
    _, status = os.waitpid(child, 0)
    return json.loads(text) if status == 0 and text else None


def answer_all(ask):
    """Reads a JSON list of map files from standard input and writes the list of what `ask` says of each."""
    json.dump([apart(ask, path) for path in json.load(sys.stdin)], ANSWER)
    ANSWER.flush()
