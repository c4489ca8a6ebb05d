"""Damage to the head or the length of unfinished work is found and said, and the same command ends with the right bits. What
is changed among the numbers of a draft is not found: it has no checksums."""

import os
import random
import shutil
import struct

import netCDF4
import pytest
import results
from drafts import cases_in, drafts_in
from workplace import captured_beam

SEED = int(os.environ.get("BEAMWAVE_SEED", "20261122"))
DRAWS = int(os.environ.get("BEAMWAVE_DRAWS", "6"))
CASES = 40
SCENE = captured_beam(modes={"before": 10, "after": 10}, response={"duration": 0.5, "samples": 1024})
SPEEDS = {"parameter": "rotation%angular_velocity", "first": 0.0, "last": 100.0, "count": CASES}
TAKEN_AWAY = "unfinished work, damaged or of another scene or version, was removed"


@pytest.fixture(scope="module")
def half(shared):
    """Half of the cases, and what a whole run gives."""
    whole, place = shared("whole"), shared("half")
    for here in (whole, place):
        here.scene("a", SCENE, SPEEDS)
    assert place.beamwave("run", "a.nml", "--part", "1/2").returncode == 0
    assert len(cases_in(place.directory / "output/a.partial")) == CASES // 2
    return place.directory, whole.run("a")


def head_of(data):
    """How long the head is: the numbers of the first variable, which counts cases, lie behind it."""
    return data.index(struct.pack(">8i", *range(1, 9)))


def flip_a_bit(dice, data):
    place = dice.randrange(head_of(data))
    return data[:place] + bytes([data[place] ^ (1 << dice.randrange(8))]) + data[place + 1 :]


def swap_two_words(dice, data):
    while True:
        one, other = sorted(4 * dice.randrange(head_of(data) // 4) for _ in range(2))
        if data[one : one + 4] != data[other : other + 4]:
            break
    words = data[one : one + 4], data[other : other + 4]
    return data[:one] + words[1] + data[one + 4 : other] + words[0] + data[other + 4 :]


def cut_the_end(dice, data):
    return data[: dice.randrange(len(data))]


def cut_some_bytes_out(dice, data):
    place = dice.randrange(len(data))
    return data[:place] + data[place + dice.randrange(1, 20_000) :]


def zero_a_page(dice, data):
    place = 4096 * dice.randrange(head_of(data) // 4096)
    return data[:place] + bytes(4096) + data[place + 4096 :]


@pytest.mark.parametrize("damage", [flip_a_bit, swap_two_words, cut_the_end, cut_some_bytes_out, zero_a_page])
def test_a_damaged_draft_is_taken_away(here, half, damage):
    directory, whole = half
    dice = random.Random(f"{SEED} {damage.__name__}")
    for draw in range(DRAWS):
        shutil.rmtree(here.directory)
        shutil.copytree(directory, here.directory)
        (draft,) = drafts_in(here.directory / "output/a.partial")
        draft.write_bytes(damage(dice, draft.read_bytes()))
        ended = here.beamwave("run", "a.nml")
        assert ended.returncode == 0, (draw, ended)
        # room for texts that are put in the end may hold anything
        assert (TAKEN_AWAY in ended.stderr) != (f"{CASES // 2} cases were taken over from an earlier run" in ended.stdout), draw
        assert TAKEN_AWAY in ended.stderr or damage not in (cut_the_end, cut_some_bytes_out), draw
        assert results.differences(here.result("a"), whole) == []
        assert here.left() == ["a.nc"]


def test_a_case_with_a_status_that_is_none_is_run_again(here, half):
    directory, whole = half
    shutil.copytree(directory, here.directory, dirs_exist_ok=True)
    (draft,) = drafts_in(here.directory / "output/a.partial")
    with netCDF4.Dataset(draft, "r+") as file:
        file["case_status"][:4] = [77, -5, 100_000, 6]
    ended = here.beamwave("run", "a.nml", status=0)
    assert f"{CASES // 2 - 2} cases were taken over from an earlier run" in ended.stdout  # half has each second case
    assert results.differences(here.result("a"), whole) == []


def leave_nothing(path):
    path.write_bytes(b"")


def leave_a_part(path):
    path.write_bytes(path.read_bytes()[:30_000])


def leave_rubbish(path):
    path.write_bytes(b"no NetCDF file" * 100)


@pytest.mark.parametrize("leave", [leave_nothing, leave_a_part, leave_rubbish])
def test_a_damaged_result_is_called_that(here, leave):
    expected = here.simulate("a", captured_beam())
    leave(here.directory / "output/a.nc")
    left = (here.directory / "output/a.nc").read_bytes()
    ended = here.beamwave("run", "a.nml", status=3)
    assert "output/a.nc: is damaged, cut short or no NetCDF file; --overwrite replaces it" in ended.stderr
    assert (here.directory / "output/a.nc").read_bytes() == left
    assert results.differences(here.run("a", "--overwrite"), expected) == []


@pytest.mark.parametrize("words", [(), ("--overwrite",)], ids=["run", "--overwrite"])
def test_a_locked_result_is_called_that(here, words):
    import fcntl

    here.simulate("a", captured_beam())
    with (here.directory / "output/a.nc").open("r+b") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        ended = here.beamwave("run", "a.nml", *words)
    assert ended.returncode == 3
    assert "output/a.nc: is locked: another program is changing it" in ended.stderr


def test_what_cannot_be_read_stays(here, half):
    directory, _ = half
    shutil.copytree(directory, here.directory, dirs_exist_ok=True)
    partial = here.directory / "output/a.partial"
    (draft,) = drafts_in(partial)
    elsewhere = here.directory / "elsewhere"
    draft.rename(elsewhere)
    draft.mkdir()
    ended = here.beamwave("run", "a.nml")
    assert ended.returncode == 3 and f"{draft.name}: cannot be" in ended.stderr
    draft.rmdir()
    elsewhere.rename(draft)
    assert f"{CASES // 2} cases were taken over" in here.beamwave("run", "a.nml").stdout
