"""What the tests of the Python module share."""

import os
import pathlib
import shutil

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
SAMPLE = ROOT / "sample_maps" / "crossing_right.osm"


@pytest.fixture
def sample(tmp_path):
    """A sample map, alone in a directory that no settings reach."""
    return pathlib.Path(shutil.copy(SAMPLE, tmp_path / "crossing_right.osm"))


@pytest.fixture
def program():
    """The native program."""
    given = os.environ.get("LANEWRIGHT_PROGRAM")
    if not given:
        pytest.skip("LANEWRIGHT_PROGRAM names no program")
    return given


@pytest.fixture
def city():
    """An extract that takes long enough to build to be called off."""
    shared = pathlib.Path(os.environ.get("LANEWRIGHT_SHARED", ROOT / ".." / "shared"))
    extract = shared / "corpus" / "osm" / "harrisburg.osm"
    if not extract.is_file():
        pytest.skip("../shared is not here")
    return extract
