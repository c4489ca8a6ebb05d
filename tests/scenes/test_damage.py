"""Damage to what a run left is found, told, and costs no more than what it hit; the same command ends with the right bits."""

import os
import random
import re
import shutil

import pytest
import results
from journals import cases_in, journals_in, records
from workplace import captured_beam

SEED = int(os.environ.get("BEAMWAVE_SEED", "20261122"))
DRAWS = int(os.environ.get("BEAMWAVE_DRAWS", "6"))
CASES = 40
SCENE = captured_beam(modes={"before": 10, "after": 10}, response={"duration": 0.5, "samples": 1024})
SPEEDS = {"parameter": "rotation%angular_velocity", "first": 0.0, "last": 100.0, "count": CASES}


@pytest.fixture(scope="module")
def killed(shared, injector):
    """A run that was killed in the middle of a record, and what it would have given."""
    whole, place = shared("whole"), shared("killed")
    for here in (whole, place):
        here.scene("a", SCENE, SPEEDS)
    injector.run(place, "run", "a.nml", fault=f"write:{CASES - 5}:torn")
    return place.directory, whole.run("a")


def flip_a_bit(dice, data):
    place = dice.randrange(len(data))
    return data[:place] + bytes([data[place] ^ (1 << dice.randrange(8))]) + data[place + 1 :]


def swap_two_words(dice, data):
    while True:
        one, other = sorted(8 * dice.randrange(len(data) // 8) for _ in range(2))
        if data[one : one + 8] != data[other : other + 8]:
            break
    words = data[one : one + 8], data[other : other + 8]
    return data[:one] + words[1] + data[one + 8 : other] + words[0] + data[other + 8 :]


def cut_the_end(dice, data):
    return data[: dice.randrange(len(data))]


def cut_some_bytes_out(dice, data):
    place = dice.randrange(len(data))
    return data[:place] + data[place + dice.randrange(1, 20_000) :]


def zero_a_page(dice, data):
    place = 4096 * dice.randrange(len(data) // 4096)
    return data[:place] + bytes(4096) + data[place + 4096 :]


def cases_in_bytes(data):
    return {case for case, _, _ in records(data) if case > 0}


def untouched(before, after):
    """Cases whose records are as they were."""
    return {case for case, first, end in records(before) if case > 0 and before[first:end] in after}


@pytest.mark.parametrize("damage", [flip_a_bit, swap_two_words, cut_the_end, cut_some_bytes_out, zero_a_page])
def test_a_damaged_journal_costs_what_the_damage_hit(here, killed, damage):
    directory, whole = killed
    dice = random.Random(f"{SEED} {damage.__name__}")
    for draw in range(DRAWS):
        shutil.rmtree(here.directory)
        shutil.copytree(directory, here.directory)
        partial = here.directory / "output/a.partial"
        (journal,) = journals_in(partial)
        before = journal.read_bytes()
        after = damage(dice, before)
        journal.write_bytes(after)
        ended = here.beamwave("run", "a.nml")
        assert ended.returncode == 0, (draw, ended)
        taken = re.search(r"(\d+) cases were taken over from an earlier run", ended.stdout)
        sound = untouched(before, after)
        assert (int(taken[1]) if taken else 0) == len(sound), draw
        if damage is not cut_the_end and len(sound) < len(cases_in_bytes(before)):
            assert re.search(r"journals of an earlier run were not as it had left them in \d+ places", ended.stderr), draw
        assert results.differences(here.result("a"), whole) == []
        assert here.left() == ["a.nc"]


def leave_nothing(path):
    path.write_bytes(b"")


def leave_a_part(path):
    path.write_bytes(path.read_bytes()[:30_000])


def leave_rubbish(path):
    path.write_bytes(b"no NetCDF file" * 100)


@pytest.mark.parametrize("leave", [leave_nothing, leave_a_part, leave_rubbish])
def test_a_damaged_result_is_called_that(here, leave):
    here.scene("a", captured_beam())
    expected = here.run("a")
    leave(here.directory / "output/a.nc")
    left = (here.directory / "output/a.nc").read_bytes()
    ended = here.beamwave("run", "a.nml")
    assert ended.returncode == 3
    assert "output/a.nc: is damaged, cut short or no NetCDF-4 file; --overwrite replaces it" in ended.stderr
    assert (here.directory / "output/a.nc").read_bytes() == left
    assert results.differences(here.run("a", "--overwrite"), expected) == []


@pytest.mark.parametrize("words", [(), ("--overwrite",)], ids=["run", "--overwrite"])
def test_a_locked_result_is_called_that(here, words):
    import fcntl

    here.scene("a", captured_beam())
    here.run("a")
    with (here.directory / "output/a.nc").open("r+b") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        ended = here.beamwave("run", "a.nml", *words)
    assert ended.returncode == 3
    assert "output/a.nc: is locked: another program is changing it" in ended.stderr


def test_what_cannot_be_read_stays(here, killed):
    directory, _ = killed
    shutil.copytree(directory, here.directory, dirs_exist_ok=True)
    partial = here.directory / "output/a.partial"
    saved = cases_in(partial)
    (journal,) = journals_in(partial)
    elsewhere = here.directory / "elsewhere"
    journal.rename(elsewhere)
    journal.mkdir()
    ended = here.beamwave("run", "a.nml")
    assert ended.returncode == 3 and f"{journal.name}: is no file" in ended.stderr
    journal.rmdir()
    elsewhere.rename(journal)
    assert cases_in(partial) == saved
    assert f"{len(saved)} cases were taken over" in here.beamwave("run", "a.nml").stdout
