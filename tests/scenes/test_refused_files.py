"""What the system refuses, files, memory or a full disk, ends with 3, a message, and no half-written result."""

import os
import resource
import signal
from pathlib import Path

import pytest
import results
from mounts import in_own_mounts
from workplace import captured_beam

FULL = Path("/dev/full")
LARGE = captured_beam(response={"duration": 1.0, "samples": 200_000})  # 3.2 MB of histories
SWEEP = {"parameter": "rotation%angular_velocity", "first": 0.0, "last": 100.0, "count": 20}
ON_LARGE = 2_000_000  # bytes: room for the file's head, not for the histories
ON_NOTHING = 20_000  # not even for the head


def assert_refused(ended, *named):
    """Status 3 and one message that names what was refused."""
    assert ended.returncode == 3, (ended.returncode, ended.stderr)
    for word in named:
        assert len([line for line in ended.stderr.splitlines() if word in line]) == 1
    for noise in ["HDF5-DIAG", "fault", "Backtrace", "SIG"]:
        assert noise not in ended.stderr


def with_files_up_to(length):
    """What a child calls so that its files can grow to so many bytes: as on a full disk, but without mounting."""

    def limit():
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)  # a write fails instead of killing the process
        resource.setrlimit(resource.RLIMIT_FSIZE, (length, length))

    return {"preexec_fn": limit, "restore_signals": False}


def test_a_missing_scene_is_named(here):
    assert_refused(here.beamwave("run", "missing.nml"), "missing.nml", "No such file")


def test_a_directory_without_scenes_is_named(here):
    (here.directory / "empty").mkdir()
    assert_refused(here.beamwave("run", "empty"), "empty", "*.nml")


@pytest.mark.skipif(os.geteuid() == 0, reason="root may read everything")
def test_a_scene_that_may_not_be_read_is_named(here):
    (here.directory / here.scene("a", captured_beam())).chmod(0)
    assert_refused(here.beamwave("run", "a.nml"), "a.nml", "Permission denied")


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_a_directory_that_may_not_be_written_is_named(here):
    here.scene("a", captured_beam())
    (here.directory / "output").mkdir(mode=0o555)
    assert_refused(here.beamwave("run", "a.nml"), "output/a.partial")


@pytest.mark.parametrize("directory", ["a.nml/output", "/proc/none/output"])
def test_a_directory_that_cannot_be_made_is_named(here, directory):
    here.scene("a", captured_beam())
    assert_refused(here.beamwave("run", "a.nml", "--output", directory), directory)


def test_directories_that_are_missing_are_made(here):
    here.scene("a", captured_beam())
    assert here.beamwave("run", "a.nml", "--output", "new/deep").returncode == 0
    assert here.left("new/deep") == ["a.nc"]


def test_a_read_only_file_system_is_named(here):
    here.scene("a", captured_beam())
    ended = in_own_mounts(here, "mkdir disk && mount -t tmpfs -o ro none disk && beamwave run a.nml --output disk")
    assert_refused(ended, "disk/a.partial")


def test_a_directory_that_cannot_have_the_result_is_named_before_any_work(here):
    here.scene("a", captured_beam(), SWEEP)
    ended = in_own_mounts(
        here,
        "mkdir disk && mount -t tmpfs none disk && mkdir disk/a.partial && mount -t tmpfs none disk/a.partial\n"
        "mount -o remount,ro disk && beamwave run a.nml --output disk",
    )
    assert_refused(ended, "disk/: cannot be written")
    assert "are saved" not in ended.stderr


def with_stack_of(kilobytes, most=None):
    """What a child calls so that its stack has so many kB, and may be given up to `most`."""
    hard = 1024 * (kilobytes if most is None else most)
    return {"preexec_fn": lambda: resource.setrlimit(resource.RLIMIT_STACK, (1024 * kilobytes, hard))}


@pytest.mark.parametrize("kilobytes", [16, 17, 18, 19, 20, 64, 100])
def test_a_stack_that_is_too_small_is_told(here, kilobytes):
    here.scene("a", captured_beam(response={"duration": 0.1, "samples": 64, "points": [0.5, 1.0]}, spectrum={}), SWEEP)
    for words in [["run", "a.nml"], ["check", "a.nml"], ["effects", "a.nml"]]:
        ended = here.beamwave(*words, **with_stack_of(kilobytes))
        if kilobytes < 32 and ended.returncode == -signal.SIGSEGV:
            continue  # the system could not even start the program, nor any other
        if kilobytes > 32 and ended.returncode == 0:
            continue  # it takes less
        assert_refused(ended)
        assert "ulimit -s" in ended.stderr


def test_a_stack_grows_as_far_as_it_may(here):
    here.scene("a", captured_beam(response={"duration": 0.1, "samples": 64}, spectrum={}), SWEEP)
    here.beamwave("run", "a.nml", **with_stack_of(64, 8192), status=0)


def test_many_points_take_no_stack(here):
    beam = {"length": [0.5, 0.5], "diameter": [0.037, 0.025], "density": 7870.0, "youngs_modulus": 2e11}
    places = [i / 999 for i in range(1000)]
    response = {"duration": 0.01, "samples": 64, "points": places, "velocity": True}
    scene = captured_beam(rotation=None, response=response, impact={"mass_ratio": 0.2, "profile_points": 1_000_000})
    here.scene("a", {**scene, "beam": beam})
    ended = here.beamwave("run", "a.nml", "--quiet", **with_stack_of(400))
    assert ended.returncode in (0, 4), ended.stderr


@pytest.mark.parametrize("size", ["1M", "100k", "8k"])
def test_a_full_disk_leaves_no_half_written_result(here, size):
    here.scene("a", LARGE)
    script = f"""mkdir disk && mount -t tmpfs -o size={size} none disk
    beamwave run a.nml --output disk; status=$?
    find disk -type f; exit $status"""
    ended = in_own_mounts(here, script)
    assert_refused(ended, "disk/a.partial", "No space left on device")
    assert ended.stdout == ""


@pytest.mark.parametrize("length", [ON_LARGE, ON_NOTHING])
def test_a_file_that_may_not_grow_leaves_no_half_written_result(here, length):
    here.scene("a", LARGE)
    assert_refused(here.beamwave("run", "a.nml", **with_files_up_to(length)), "output/a.partial")
    assert here.left() == []
    assert here.beamwave("run", "a.nml").returncode == 0


def test_a_full_disk_keeps_the_older_result(here):
    older = here.simulate("a", captured_beam())
    here.scene("a", LARGE)
    assert_refused(here.beamwave("run", "a.nml", "--overwrite", **with_files_up_to(ON_LARGE)), "output/a.partial")
    assert results.differences(here.result("a"), older) == []


def test_a_sweep_goes_on_when_the_full_disk_has_room_again(here):
    here.scene("a", captured_beam(response={"duration": 1.0, "samples": 20_000}), SWEEP)
    assert_refused(here.beamwave("run", "a.nml", **with_files_up_to(ON_LARGE)), "output/a.partial")
    assert "a.nc" not in here.left()
    resumed = here.run("a")
    assert here.beamwave("run", "a.nml", "--output", "clean").returncode == 0
    assert results.differences(resumed, here.result("a", "clean")) == []


def test_other_scenes_run_where_one_is_refused(here):
    here.scene("large", LARGE)
    here.scene("small", captured_beam())
    assert_refused(here.beamwave("run", "large.nml", "small.nml", **with_files_up_to(ON_LARGE)), "large")
    assert here.left() == ["small.nc"]


@pytest.mark.parametrize("megabytes", [200, 400, 800])
def test_memory_that_is_refused_is_named_before_any_work(here, megabytes):
    spectrum = captured_beam(response={"duration": 1.0, "samples": 100_000_000}, spectrum={})
    here.scene("a", spectrum)
    limited = {"preexec_fn": lambda: resource.setrlimit(resource.RLIMIT_AS, (megabytes * 2**20,) * 2)}
    if here.beamwave("--version", **limited).returncode != 0:
        pytest.skip(f"the program does not start in {megabytes} MB, as under a sanitizer")
    assert_refused(here.beamwave("run", "a.nml", **limited), "a.nml", "not enough memory")
    assert not (here.directory / "output").exists()


@pytest.mark.parametrize("megabytes", [130, 160, 200, 250])
def test_a_spectrum_in_little_memory_ends(here, megabytes):
    here.scene("a", captured_beam(response={"duration": 1.0, "samples": 4096}, spectrum={}))
    limited = {"preexec_fn": lambda: resource.setrlimit(resource.RLIMIT_AS, (megabytes * 2**20,) * 2)}
    if here.beamwave("--version", **limited).returncode != 0:
        pytest.skip(f"the program does not start in {megabytes} MB, as under a sanitizer")
    ended = here.beamwave("run", "a.nml", timeout=10, **limited)
    assert ended.returncode in (0, 3)
    assert here.left(".") == ["a.nml"] if ended.returncode == 3 else ["a.nc", "a.nml"]


COMMANDS = [["--version"], ["--help"], ["describe"], ["check", "a.nml"], ["run", "a.nml"]]


@pytest.mark.parametrize("words", COMMANDS, ids=" ".join)
def test_a_report_that_cannot_be_written_is_said(here, words):
    here.scene("a", captured_beam())
    with FULL.open("w") as full:
        ended = here.beamwave(*words, stdout=full)
    assert ended.returncode == 3
    assert "standard output cannot be written" in ended.stderr


def test_quiet_needs_no_standard_output(here):
    here.scene("a", captured_beam())
    with FULL.open("w") as full:
        assert here.beamwave("run", "a.nml", "--quiet", stdout=full).returncode == 0
    assert here.left() == ["a.nc"]


@pytest.mark.skipif(not Path("/sys").is_dir(), reason="there is no /sys, in which nobody makes a directory")
def test_a_directory_that_cannot_be_made_is_told_with_the_reason_of_the_first_that_is_refused(here):
    here.scene("a", captured_beam())
    ended = here.beamwave("run", "a.nml", "--output", "/sys/none/deeper", status=3)
    assert "/sys/none/deeper" in ended.stderr
    assert "No such file" not in ended.stderr
