"""Whatever call the system refuses, and wherever the program is killed, a run ends with the right bits or with 3, keeps every
finished case, and the same command goes on from there. Here a sample of all calls; BEAMWAVE_FAULTS sets how many for each
situation, and 'all' takes every one."""

import errno
import os
import random
import shutil

import pytest
import results
from faults import KINDS, OF_BYTES
from drafts import cases_in
from ring_downs import text_of
from workplace import captured_beam, namelist

SEED = int(os.environ.get("BEAMWAVE_SEED", "20261122"))
FAULTS = os.environ.get("BEAMWAVE_FAULTS", "16")
SCENE = captured_beam(modes={"before": 6, "after": 6}, response={"duration": 0.2, "samples": 600}, spectrum={})
SPEEDS = {"parameter": "rotation%angular_velocity", "first": 0.0, "last": 100.0, "count": 6}
STARTS = {"parameter": "record%start", "values": [0.0, 0.1]}
RECORD = {"beam": {"length": 0.35, "density": 2700.0, "youngs_modulus": 70e9, "width": 0.03, "height": 0.006}, "spectrum": {}}
MODULUS = {"parameter": "beam%youngs_modulus", "first": 50e9, "last": 300e9, "with": "other.nml"}
ERRORS = {
    **{kind: [errno.EIO, errno.EMFILE] for kind in KINDS},
    **{kind: [errno.EIO, errno.ENOSPC] for kind in ("write", "pwrite", "close", "fsync", "fdatasync", "ftruncate", "link", "mkdir")},
    "fallocate": [errno.ENOSPC, errno.EOPNOTSUPP],
    "mmap": [errno.ENOMEM, errno.ENODEV],
    "flock": [errno.EIO, errno.ENOSYS, errno.ENOLCK],
    "fork": [errno.EAGAIN],
    "malloc": [errno.ENOMEM],
}
RUN, FIRST_PART, LAST_PART = ("run", "a.nml"), ("run", "a.nml", "--part", "1/2"), ("run", "a.nml", "--part", "2/2")
# name: command, what is written before it, the command before it, processes
SITUATIONS = {
    "a run": (RUN, "sweep", None, 1),
    "a run that is taken up": (RUN, "sweep", FIRST_PART, 1),
    "the last part": (LAST_PART, "sweep", FIRST_PART, 1),
    "a run of one case": (RUN, "case", None, 1),
    "a finished run": (RUN, "sweep", RUN, 1),
    "effects": (("effects", "a.nml"), "case", None, 1),
    "two processes": (RUN, "sweep", None, 2),
    "repeats of a record": (RUN, "repeats", None, 1),
    "a sweep over records": (RUN, "swept repeats", None, 1),
    "an identification": (RUN, "unknowns", None, 1),
}


def write(here, what):
    """The scene `a` and the records that it reads."""
    if what in ("sweep", "case"):
        here.scene("a", SCENE, *([SPEEDS] if what == "sweep" else []))
        return
    for number in (1, 2, 3):
        here.write(f"{number}.csv", text_of(number, samples=400))
    if what == "unknowns":
        here.write("other.nml", namelist({**RECORD, "record": {"file": "3.csv"}}))
        here.write("a.nml", namelist({**RECORD, "record": {"file": ["1.csv", "2.csv"]}, "identify": MODULUS}))
    else:
        files = ["1.csv", "2.csv", "3.csv"]
        here.scene("a", {"record": {"file": files}, "spectrum": {}}, *([STARTS] if what == "swept repeats" else []))


@pytest.fixture(scope="module")
def prepared(shared):
    """Directories as they are before the command, and what it gives: made once."""
    made = {}

    def prepare(name):
        if name not in made:
            command, what, before, _ = SITUATIONS[name]
            clean, place = shared("clean"), shared("place")
            for here in (clean, place):
                write(here, what)
            status = clean.beamwave(*(command if command != LAST_PART else RUN)).returncode
            assert status == (4 if what == "unknowns" else 0)  # lines that no modulus explains
            if before:
                assert place.beamwave(*before).returncode == 0
            made[name] = clean, place, status
        return made[name]

    return prepare


def ways_of(kind):
    """How a call of this kind can go wrong."""
    ways = [f"{sign}{number}" for number in ERRORS[kind] for sign in ("", "+")]
    if kind == "malloc":
        return ways
    ways += [str(errno.EINTR)] if kind in OF_BYTES | {"open", "fsync", "fdatasync", "fallocate", "ftruncate", "flock"} else []
    ways += ["short"] if kind in OF_BYTES else []
    return ways + ["kill"] + (["torn"] if kind in ("write", "pwrite") else [])


def faults_of(counts, dice, number, long):
    """All faults, or a sample of them, of what takes long a quarter of one: the kinds have equal shares of it, however many calls there are of each."""
    kinds = [kind for kind in KINDS if counts[kind] and not (kind == "malloc" and number > 1)]  # MPI hangs where it has none
    if FAULTS == "all":
        return [f"{kind}:{call}:{way}" for kind in kinds for way in ways_of(kind) for call in range(1, counts[kind] + 1)]
    drawn = [kinds[i % len(kinds)] for i in range(int(FAULTS) // (4 if number > 1 or long else 1))]
    return [f"{kind}:{dice.randint(1, counts[kind])}:{dice.choice(ways_of(kind))}" for kind in drawn]


@pytest.mark.parametrize("name", SITUATIONS)
def test_a_refused_call_costs_no_finished_case(processes, prepared, injector, name):
    command, _, _, number = SITUATIONS[name]
    clean, place, status = prepared(name)
    here = processes(number)
    expected = {file.relative_to(clean.directory): contents(file) for file in (clean.directory / "output").iterdir()}
    shutil.copytree(place.directory, here.directory, dirs_exist_ok=True)
    saved = cases_in(here.directory / "output/a.partial")
    _, counts = injector.run(here, *command)
    faults = faults_of(counts, random.Random(f"{SEED} {name}"), number, name == "effects")
    print(f"seed {SEED}: {len(faults)} faults in {counts}")
    for fault in faults:
        shutil.rmtree(here.directory)
        shutil.copytree(place.directory, here.directory)
        check(here, injector, (command, fault, status), expected, saved)


def contents(path):
    """Of a result, or the text of an identified scene."""
    return path.read_text() if path.suffix == ".nml" else results.read(path)


def check(here, injector, trial, expected, saved):
    """One fault, and the same command again."""
    command, fault, status = trial
    ended, _ = injector.run(here, *command, "--quiet", fault=fault)
    is_kill = fault.endswith(("kill", "torn"))
    assert ended.returncode in (status, 3) or (is_kill and ended.returncode not in (2, 4, 5, 70)), (fault, ended)
    assert ended.returncode != 3 or ended.stderr, fault
    made = [file for file in expected if (here.directory / file).exists()]
    assert_same(here, {file: expected[file] for file in made}, fault)
    told = status != 0 and "cannot be" in ended.stderr  # of a result that is not trusted the status is the higher one
    assert ended.returncode != status or len(made) == len(expected) or told, fault
    if not made:
        assert cases_in(here.directory / "output/a.partial") >= saved, fault
    again = here.beamwave(*command, "--quiet")
    assert again.returncode in (0, status), (fault, again)  # 0: nothing is left to do
    assert here.left() == sorted(file.name for file in expected), fault
    assert_same(here, expected, fault)


def assert_same(here, expected, fault):
    """The same bits, but for the seconds that a study measures, and its table of them."""
    for file, whole in expected.items():
        if file.suffix == ".nml":
            assert (here.directory / file).read_text() == whole, fault
            continue
        found = results.read(here.directory / file)
        seconds = {name for name in whole.variables if "seconds" in name or name == "cost"}
        if "study" in whole.attributes:
            seconds.add("report")
        assert set(results.differences(found, whole)) <= seconds, (fault, file)
