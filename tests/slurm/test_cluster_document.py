"""docs/cluster.md, carried out as it stands: its shell blocks from `Check first` on and then its Python, in one directory."""

import subprocess
import sys

import pytest
import results
from documents import blocks, text_of
from slurm import PROJECT, SECONDS, needs_mpi

DOCUMENT = text_of("docs/cluster.md")
WAIT = "while squeue --noheader | grep -q .; do sleep 0.2; done\n"  # each block begins when the jobs before it ended


def carry_out(place, environment, *command):
    """Run a command in the directory; return what it says."""
    options = {"cwd": place.directory, "env": environment, "stdin": subprocess.DEVNULL, "timeout": SECONDS}
    done = subprocess.run(command, capture_output=True, text=True, check=False, **options)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def place(jobs, shared):
    """The directory in which all was carried out."""
    needs_mpi(jobs)
    place = shared("document")
    environment = {**jobs.environment, "BEAMWAVE": str(PROJECT)}
    place.said = carry_out(place, environment, "bash", "-euc", WAIT.join([*blocks(DOCUMENT, "sh", after="Check first"), ""]))
    place.said += carry_out(place, environment, sys.executable, "-c", "\n".join(blocks(DOCUMENT, "python")))
    return place


def test_the_sweep_is_finished_and_its_log_ends_with_the_report(place):
    assert "JobState=COMPLETED" in place.said
    assert "output/map.nc" in place.said
    assert place.result("map").sizes["case"] == 500


def test_the_array_leaves_a_result_for_each_scene(place):
    assert place.left("output/scan") == ["mass 0.1.nc", "mass 0.2.nc", "mass 0.5.nc"]


def test_the_parts_leave_the_result_of_the_ranks(place):
    assert results.differences(place.result("map", "parts"), place.result("map")) == []


def test_what_depends_on_the_continued_run_follows_it(place):
    assert (place.directory / "after.log").read_text() == "long/map.nc\n"
    assert results.differences(place.result("map", "long"), place.result("map")) == []


def test_the_post_processing_leaves_its_pictures_and_its_table(place):
    for name in ["spectrum.png", "measured_wavenumber.png", "peaks.csv"]:
        assert (place.directory / f"output/spectrum_{name}").stat().st_size > 0


def test_the_collected_numbers_are_those_of_the_files(place):
    result = place.result("map")
    wanted = (result["rotation_angular_velocity"] == 50.0) & (abs(result["impact_mass_ratio"] - 0.5) < 0.01)
    assert f"{result['angular_frequency'][wanted, 0].item()} rad/s" in place.said
    scan = results.read(place.directory / "scan.nc")
    first = place.result("mass 0.1", "output/scan")
    assert scan.sizes["scene"] == 3
    assert (scan["phase_velocity"][0] == first["phase_velocity"]).all()
