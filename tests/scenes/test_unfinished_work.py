"""Unfinished work is taken away by a run that puts its own in its place, which says so, and by nobody else."""

import pytest
from drafts import cases_in, drafts_in
from terminals import ended_on_terminal
from workplace import ENDLESS, RATIOS, captured_beam

SMALL = {"modes": {"before": 4, "after": 4}}
OTHER = {**ENDLESS, "rotation": {"angular_velocity": 51.0}}
TAKEN_AWAY = "unfinished work, damaged or of another scene or version, was removed"


def stop_early(here, *words, **options):
    """Run `a` for a while; what it said, and the cases that it left."""
    ended = here.beamwave("run", "a.nml", "--max-seconds", "0.5", *words, **options, status=5)
    return ended, cases_in(here.directory / "output/a.partial")


def test_a_run_with_nothing_to_do_leaves_the_cases_of_another_scene(here):
    here.simulate("a", captured_beam(**SMALL))
    here.scene("a", ENDLESS, RATIOS)
    _, saved = stop_early(here, "--overwrite")
    assert saved
    here.scene("a", captured_beam(**SMALL))
    assert "nothing to do" in here.beamwave("run", "a.nml").stdout
    assert cases_in(here.directory / "output/a.partial") == saved
    here.scene("a", ENDLESS, RATIOS)
    _, more = stop_early(here, "--overwrite")
    assert more > saved


def test_what_a_finished_run_left_of_itself_is_taken_away(here):
    speeds = {"parameter": "rotation%angular_velocity", "values": [10.0, 20.0]}
    here.scene("a", captured_beam(**SMALL), speeds)
    partial = here.directory / "output/a.partial"
    here.run("a")
    partial.mkdir()
    (partial / "lock.host-1-20260101T000000.000").write_text("as far as it came")
    assert "nothing to do" in here.beamwave("run", "a.nml").stdout
    assert here.left() == ["a.nc"]


@pytest.mark.parametrize("words", [(), ("--quiet",)], ids=["aloud", "quiet"])
def test_a_changed_sweep_says_what_it_took_away_though_it_is_stopped(here, words):
    here.scene("a", OTHER, RATIOS)
    stop_early(here)
    here.scene("a", ENDLESS, RATIOS)
    ended, _ = stop_early(here, *words)
    assert ended.stderr.count(TAKEN_AWAY) == 1
    ended, _ = stop_early(here, *words)
    assert TAKEN_AWAY not in ended.stderr


def test_a_single_scene_says_so_too(here):
    here.scene("a", ENDLESS, RATIOS)
    stop_early(here)
    here.scene("a", captured_beam(**SMALL))
    ended = here.beamwave("run", "a.nml")
    assert (ended.returncode, ended.stderr.count(TAKEN_AWAY)) == (0, 1)
    assert TAKEN_AWAY not in here.result("a").attributes["notes"]
    assert here.left() == ["a.nc"]


def test_a_terminal_shows_it_once(here):
    here.scene("a", ENDLESS, RATIOS)
    stop_early(here)
    here.scene("a", captured_beam(**SMALL))
    _, shown = ended_on_terminal(here, "run", "a.nml", streams=("stdout", "stderr"))
    assert shown.count(TAKEN_AWAY) == 1


def test_a_draft_that_cannot_be_read_stays(here):
    here.scene("a", ENDLESS, RATIOS)
    _, saved = stop_early(here)
    (draft,) = drafts_in(here.directory / "output/a.partial")
    elsewhere = here.directory / "elsewhere"
    draft.rename(elsewhere)
    draft.symlink_to("where its disk is not mounted")
    ended = here.beamwave("run", "a.nml", "--max-seconds", "0.5", status=3)
    assert f"{draft.name}: cannot be written" in ended.stderr
    draft.unlink()
    elsewhere.rename(draft)
    _, more = stop_early(here)
    assert more > saved


def test_a_result_that_cannot_be_trusted_is_called_so_again(here):
    growing = captured_beam(rotation={"angular_velocity": 3000.0}, response={"duration": 10.0, "samples": 64})
    here.scene("a", growing, {"parameter": "rotation%angular_velocity", "values": [10.0, 3000.0]})
    assert here.beamwave("run", "a.nml").returncode == 4
    again = here.beamwave("run", "a.nml")
    assert "nothing to do" in again.stdout and "1 of its cases cannot be trusted" in again.stdout
