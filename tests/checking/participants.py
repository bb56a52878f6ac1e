#!/usr/bin/env python3
"""Who may enter a lanelet, and how fast, by the C++ Lanelet2 library: JSON questions on stdin, JSON answers on stdout.

A question: [participant, {key: value, ...}]. Its answer: [whether it may enter, km/h].
"""
import json
import sys

from lanelet2 import traffic_rules
from lanelet2.core import Lanelet, LineString3d, Point3d, getId


def line(y):
    return LineString3d(getId(), [Point3d(getId(), x, y, 0) for x in (0, 10)])


answers = []
for participant, tags in json.load(sys.stdin):
    rules = traffic_rules.create(traffic_rules.Locations.Germany, participant)
    lanelet = Lanelet(getId(), line(3), line(0))
    for key, value in tags.items():
        lanelet.attributes[key] = value
    answers.append([rules.canPass(lanelet), rules.speedLimit(lanelet).speedLimit])
json.dump(answers, sys.stdout)
