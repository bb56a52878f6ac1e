"""Is read by Spark's Python workers in tests: one of them dies in the middle of a tile, where a test has asked for it."""

import os
import signal

import storage_of_tests

import lanewright

storage_of_tests.register()
build_tile = lanewright.build_tile


def build_tile_or_die(*arguments, **options):
    built = build_tile(*arguments, **options)
    try:
        # Only one worker can do this.
        os.unlink(os.environ["LANEWRIGHT_TEST_KILL"])
    except (KeyError, FileNotFoundError):
        return built
    os.kill(os.getpid(), signal.SIGKILL)


lanewright.build_tile = build_tile_or_die
