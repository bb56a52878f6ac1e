"""Bad input: a clear exception, no leak, and the interpreter goes on."""

import os
import pathlib
import resource
import signal
import subprocess
import sys
import threading
import time

import lanewright
import pytest


def test_a_missing_file():
    for verb in (lanewright.build, lanewright.geometry, lanewright.check, lanewright.fix):
        with pytest.raises(lanewright.ReadError) as caught:
            verb("no_such_map.osm")
        assert "no_such_map.osm" in str(caught.value)
        assert caught.value.message


def test_a_directory(tmp_path):
    with pytest.raises(lanewright.ReadError):
        lanewright.build(tmp_path)
    with pytest.raises(lanewright.ReadError, match="no .osm file"):
        lanewright.check(tmp_path)


@pytest.mark.parametrize(
    "content", [b"", b"no map", b"\x00" * 1000, b"\x1f\x8b broken", b"<osm>", b"<html></html>", b'{"type": 1}', b"\xff\xfe<"]
)
def test_bytes_that_are_no_map(content):
    for verb in (lanewright.build, lanewright.geometry, lanewright.check, lanewright.fix):
        with pytest.raises((lanewright.ReadError, lanewright.BuildError)) as caught:
            verb(content, name="bad.osm")
        assert caught.value.message


def test_a_file_that_is_cut_off_says_where(sample):
    text = sample.read_bytes()
    sample.write_bytes(text[: len(text) // 2])
    with pytest.raises(lanewright.ReadError) as caught:
        lanewright.build(sample)
    error = caught.value
    assert error.file.endswith("crossing_right.osm") and error.line > 1 and error.help


def test_an_extract_is_no_lanelet2_map_and_the_other_way_around(sample):
    with pytest.raises(lanewright.Error, match="extract"):
        lanewright.check(sample)
    with pytest.raises(lanewright.BuildError, match="Lanelet2 map already"):
        lanewright.build(lanewright.build(sample).osm)


def test_names_and_types_of_options(sample):
    cases = [
        (TypeError, {"drivingside": "left"}, "drivingside"),
        (TypeError, {"driving_side": 3}, "'left', 'right', 'auto'"),
        (ValueError, {"driving_side": "up"}, "'left', 'right', 'auto'"),
        (ValueError, {"projector": "UTM"}, "'MGRS'"),
        (TypeError, {"threads": "two"}, "threads"),
        (TypeError, {"threads": True}, "threads"),
        (ValueError, {"threads": 0}, "threads"),
        (TypeError, {"config": 3}, "config"),
        (TypeError, {"config": {"markings": object()}}, "config.markings"),
    ]
    for kind, options, words in cases:
        with pytest.raises(kind, match=words):
            lanewright.build(sample, **options)
    with pytest.raises(TypeError):
        lanewright.build()
    with pytest.raises(TypeError, match="bytes"):
        lanewright.build(None)
    with pytest.raises(ValueError, match="'ours', 'tier4'"):
        lanewright.check(b"<osm/>", profile="theirs")
    with pytest.raises(lanewright.ConfigError):
        lanewright.build(sample, config={"no_such_table": 1})
    with pytest.raises(lanewright.ConfigError):
        lanewright.check(lanewright.build(sample), select="vm-99")


def test_what_cannot_be_written(sample, tmp_path):
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(lanewright.WriteError):
        lanewright.build(sample, tmp_path / "file")
    assert (tmp_path / "file").read_text() == "in the way"
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "lanewright.toml").write_text("")
    with pytest.raises(lanewright.WriteError, match="lanewright.toml"):
        lanewright.build(sample, tmp_path / "other")
    with pytest.raises(lanewright.WriteError):
        lanewright.fix(lanewright.build(sample).osm.replace(b"turn_direction", b"turn_directoin"), write=True)


def called_off(work):
    """Presses Ctrl-C a little after some work has begun; gives how long it then went on, seconds."""
    pressed = []
    # Where a test runs in the background, Ctrl-C was not meant for it.
    signal.signal(signal.SIGINT, signal.default_int_handler)

    def press():
        pressed.append(time.monotonic())
        os.kill(os.getpid(), signal.SIGINT)

    timer = threading.Timer(0.5, press)
    timer.start()
    try:
        with pytest.raises(KeyboardInterrupt):
            work()
    finally:
        timer.cancel()
        timer.join()
    return time.monotonic() - pressed[0]


def test_ctrl_c_calls_a_build_off(city, sample, tmp_path):
    after = called_off(lambda: lanewright.build(city, tmp_path / "map"))
    assert after < 2.0
    assert list(tmp_path.glob("map*")) == [], "nothing half-written"
    assert lanewright.build(sample).summary.intersections == 1, "the process goes on"


def memory():
    """Resident memory of this process, bytes."""
    pages = int(pathlib.Path("/proc/self/statm").read_text().split()[1])
    return pages * resource.getpagesize()


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="reads /proc")
def test_memory_does_not_grow(sample):
    def round_of_calls():
        for _ in range(5):
            lanewright.check(lanewright.build(sample))
            for bad in (b"<osm>", b"no map"):
                with pytest.raises(lanewright.Error):
                    lanewright.check(bad)
            with pytest.raises(lanewright.ReadError):
                lanewright.build("no_such_map.osm")

    for _ in range(4):
        round_of_calls()
    before, threads = memory(), threading.active_count()
    for _ in range(8):
        round_of_calls()
    assert memory() - before < 16e6, f"{(memory() - before) / 1e6:.1f} MB more after 40 rounds"
    assert threading.active_count() == threads
    assert len(list(pathlib.Path("/proc/self/task").iterdir())) <= threads + 2, "no thread is left behind"


def test_the_command_is_the_program(sample, program, tmp_path):
    command = pathlib.Path(sys.executable).with_name("lanewright")
    for arguments in (
        ["--version"],
        ["--help"],
        ["rules"],
        ["explain", "vm-03-08"],
        ["build", sample.name, "-o", "map"],
        ["check", "map", "--format", "json"],
        ["check", "map"],
        ["check", "nothing.osm"],
        ["no-such-verb"],
        ["build"],
        [],
    ):
        one, other = (
            subprocess.run([name, *arguments], cwd=tmp_path, check=False, capture_output=True) for name in (command, program)
        )
        assert (one.returncode, one.stdout, one.stderr) == (other.returncode, other.stdout, other.stderr), arguments


def test_the_command_ends_at_ctrl_c_as_the_program_does(city, program, tmp_path):
    command = pathlib.Path(sys.executable).with_name("lanewright")
    codes = []
    for name in (command, program):
        for heard in (signal.SIG_DFL, signal.SIG_IGN):
            running = subprocess.Popen(
                [name, "build", city, "-o", tmp_path / "map"],
                stdout=subprocess.DEVNULL,
                preexec_fn=lambda: signal.signal(signal.SIGINT, heard),
            )
            time.sleep(0.5)
            running.send_signal(signal.SIGINT)
            codes.append(running.wait(timeout=60))
    assert codes == [-signal.SIGINT, 0] * 2, "it ends, unless it was started where Ctrl-C is not heard"


def test_the_hook_looks_at_every_map(sample, tmp_path):
    lanewright.build(sample, tmp_path / "good")
    lanewright.build(sample, tmp_path / "bad")
    file = tmp_path / "bad" / "lanelet2_map.osm"
    file.write_text(file.read_text().replace("turn_direction", "turn_directoin"))
    hook = pathlib.Path(sys.executable).with_name("lanewright-hook")
    maps = [tmp_path / name / "lanelet2_map.osm" for name in ("good", "bad")]
    codes = [subprocess.run([hook, *given], check=False, capture_output=True).returncode for given in ([maps[0]], maps, [])]
    assert codes == [0, 1, 0]
