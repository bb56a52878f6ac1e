"""What the tests of the Python module share."""

import os
import pathlib
import shutil

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
SHARED = pathlib.Path(os.environ.get("LANEWRIGHT_SHARED", ROOT / ".." / "shared"))
SAMPLE = ROOT / "sample_maps" / "crossing_right.osm"


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item, call):
    """Notes what is skipped in the list that scripts/test.sh prints. Where ../shared is, a test may not be skipped."""
    report = yield
    if report.skipped:
        reason = report.longrepr[2].removeprefix("Skipped: ")
        if SHARED.is_dir():
            report.outcome, report.longrepr = "failed", f"this test may not be skipped where ../shared is: {reason}"
        elif listed := os.environ.get("LANEWRIGHT_SKIPPED"):
            with open(listed, "a") as file:
                file.write(f"{item.nodeid}\t{reason}\n")
    return report


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
    """An extract that takes long enough to build to be interrupted."""
    if not SHARED.is_dir():
        pytest.skip("../shared is not here")
    extract = SHARED / "corpus" / "osm" / "harrisburg.osm"
    assert extract.is_file(), f"{extract} is missing"
    return extract
