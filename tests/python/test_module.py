"""The functions of the module, on sample maps: what they give, and that it is what the program gives."""

import inspect
import json
import pathlib
import subprocess
import threading

import lanewright
import pytest

from conftest import ROOT

SAMPLES = sorted((ROOT / "sample_maps").glob("*.osm"))
FILES = ["lanelet2_map.osm", "map_projector_info.yaml", "lanewright.toml"]


def contents(directory):
    return {file.name: file.read_bytes() for file in pathlib.Path(directory).iterdir()}


@pytest.mark.parametrize("source", SAMPLES, ids=lambda path: path.stem)
def test_a_map_has_the_bytes_of_the_program(source, program, tmp_path):
    subprocess.run([program, "build", source, "-o", tmp_path / "program"], check=True, capture_output=True)
    built = lanewright.build(source, tmp_path / "module")
    expected = contents(tmp_path / "program")
    assert sorted(expected) == sorted(FILES)
    assert contents(tmp_path / "module") == expected
    assert built.osm == expected["lanelet2_map.osm"]
    # Behind them stands what was written with them.
    assert expected["lanewright.toml"].startswith(built.settings.encode())
    assert built.projector_info.encode() == expected["map_projector_info.yaml"]
    subprocess.run([program, "geometry", source, "-o", tmp_path / "s.geojson"], check=True, capture_output=True)
    assert lanewright.geometry(source).geojson == (tmp_path / "s.geojson").read_bytes()


def test_a_report_is_that_of_the_program(sample, program, tmp_path):
    lanewright.build(sample, tmp_path / "map")
    file = tmp_path / "map" / "lanelet2_map.osm"
    file.write_text(file.read_text().replace('k="turn_direction" v="left"', 'k="turn_direction" v="lft"'))
    done = subprocess.run(
        [program, "check", "map", "--format", "json"], cwd=tmp_path, check=False, capture_output=True, text=True
    )
    assert done.returncode == 1
    report = json.loads(done.stdout)
    result = lanewright.check(tmp_path / "map")
    own = result.to_dict()
    assert [finding["code"] for finding in own["findings"]] == [finding["code"] for finding in report["findings"]]
    own["totals"].pop("cap_per_code"), report["totals"].pop("cap_per_code")
    assert own["totals"] == report["totals"]
    assert result.errors == report["totals"]["error"] and not result.ok
    assert len(result) == len(result.findings) == len(report["findings"])


def test_a_built_map_is_clean_and_can_be_given_on(sample):
    built = lanewright.build(sample)
    summary = built.summary
    assert (summary.roads, summary.intersections) == (4, 1)
    assert summary.lanelets > 4 and summary.regulatory_elements > 0
    assert summary.guesses == len(built.notes)
    assert built.projector == "MGRS"
    for given in (built, built.osm):
        result = lanewright.check(given, ignore="projector")
        assert result.ok, result.counts
    note = built.notes[0]
    assert note.severity == "info" and note.message and note.kind in ("node", "way", "relation")
    assert note.id in (20, 21)
    assert json.loads(json.dumps(built.to_dict()))["summary"] == summary.to_dict()


def test_paths_and_bytes_give_the_same(sample):
    as_path = lanewright.build(sample).osm
    assert lanewright.build(str(sample)).osm == as_path
    assert lanewright.build(sample.read_bytes()).osm == as_path
    assert lanewright.build(bytearray(sample.read_bytes())).osm == as_path
    streets = lanewright.geometry(sample)
    assert lanewright.build(streets.geojson).osm == as_path


@pytest.mark.parametrize("threads", [1, 2, 5])
def test_the_number_of_threads_changes_nothing(sample, threads):
    assert lanewright.build(sample, threads=threads).osm == lanewright.build(sample).osm


def test_options_are_those_of_the_program(sample, program, tmp_path):
    options = ["--driving-side", "left", "--projector", "TransverseMercator"]
    subprocess.run([program, "build", sample, "-o", tmp_path / "map", *options], check=True, capture_output=True)
    built = lanewright.build(sample, driving_side="left", projector="TransverseMercator")
    assert built.osm == (tmp_path / "map" / "lanelet2_map.osm").read_bytes()


def broken(sample, directory):
    """A map with an error of which the position, the ids and the fix are known."""
    lanewright.build(sample, directory)
    file = directory / "lanelet2_map.osm"
    file.write_text(file.read_text().replace('k="turn_direction" v="left"', 'k="turn_directoin" v="left"'))
    return file


def test_a_finding_has_typed_fields(sample, tmp_path):
    file = broken(sample, tmp_path / "map")
    result = lanewright.check(tmp_path / "map", select="vm-03-02")
    finding = result.findings[0]
    assert finding.code == f"{finding.rule}/{finding.fault}" and finding.rule == "vm-03-02"
    assert finding.severity == "error" and finding.message and finding.help
    assert (finding.kind, type(finding.id)) == ("lanelet", int)
    assert isinstance(finding.lon, float) and isinstance(finding.x, float)
    assert finding.file.endswith(file.name)
    assert f'id="{finding.id}"' in file.read_text().splitlines()[finding.line - 1]
    assert finding.to_dict()["code"] == finding.code
    assert str(finding.id) in repr(finding)


def test_tables_and_features(sample, tmp_path):
    broken(sample, tmp_path / "map")
    result = lanewright.check(tmp_path / "map")
    rows, features = result.to_rows(), result.to_geojson()
    assert len(rows) == len(features["features"]) == len(result)
    assert features["type"] == "FeatureCollection"
    assert all(feature["geometry"] is None or feature["geometry"]["type"] for feature in features["features"])
    assert {row["code"] for row in rows} == {finding.code for finding in result}
    json.dumps([rows, features, result.to_dict()])
    outlines = lanewright.build(sample).to_geojson()["features"]
    assert len(outlines) == lanewright.build(sample).summary.lanelets


def test_a_fix_is_shown_made_and_written(sample, tmp_path):
    file = broken(sample, tmp_path / "map")
    before = file.read_bytes()
    fixed = lanewright.fix(tmp_path / "map")
    assert file.read_bytes() == before, "nothing is written unasked"
    assert fixed.changed and fixed.fixed and fixed.left.ok
    assert "+" in fixed.diff and "turn_directoin" in fixed.diff
    fixed.write()
    assert lanewright.check(tmp_path / "map").ok
    again = lanewright.fix(tmp_path / "map", write=True)
    assert not again.changed and again.diff == ""
    in_memory = lanewright.fix(before, ignore="projector")
    assert in_memory.osm == file.read_bytes()


def test_a_baseline_leaves_out_what_it_lists(sample, tmp_path):
    broken(sample, tmp_path / "map")
    first = lanewright.check(tmp_path / "map")
    first.write_baseline(tmp_path / "debts.json")
    second = lanewright.check(tmp_path / "map", baseline=tmp_path / "debts.json")
    assert len(second) == 0 and second.known == len(first) > 0


def test_rules_are_all_there():
    rules = {rule.id: rule for rule in lanewright.rules()}
    documents = {path.stem for path in (ROOT / "rules").glob("vm-*.md")}
    assert documents <= set(rules)
    area = rules["vm-03-08"]
    assert area.check in ("automatic", "partial", "manual") and area.prose
    assert any(fault.code == "vm-03-08/lane-node-missing" and fault.help for fault in area.faults)
    assert all(parameter.unit and parameter.meaning for parameter in area.parameters.values())


def test_python_threads_work_side_by_side(sample):
    expected = lanewright.build(sample).osm
    results = []
    threads = [threading.Thread(target=lambda: results.append(lanewright.build(sample).osm)) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert results == [expected] * 4


def test_everything_says_what_it_is():
    for name in lanewright.__all__:
        thing = getattr(lanewright, name)
        if name.startswith("__"):
            continue
        assert inspect.getdoc(thing), name
        if inspect.isclass(thing) and not issubclass(thing, Exception):
            for member in vars(thing):
                if not member.startswith("_"):
                    assert inspect.getdoc(getattr(thing, member)), f"{name}.{member}"
    for function in (lanewright.build, lanewright.geometry, lanewright.check, lanewright.fix):
        for parameter in inspect.signature(function).parameters:
            assert f"{parameter}:" in function.__doc__, f"{function.__name__}: {parameter}"
