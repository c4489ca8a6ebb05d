"""Commands with --part share a sweep without MPI: in any order, at once, on several hosts, killed or stopped, they end with the
bits of one run."""

import os
import random
import re
import shlex
import subprocess

import pytest
import results
from drafts import cases_in, drafts_in, wait_for_cases
from workplace import ENDLESS, RATIOS, SECONDS, captured_beam

SEED = int(os.environ.get("BEAMWAVE_SEED", "20261126"))
CASES = 23
SCENE = captured_beam(modes={"before": 10, "after": 10}, response={"duration": 0.5, "samples": 512})
SPEEDS = {"parameter": "rotation%angular_velocity", "first": 0.0, "last": 100.0, "count": CASES}
# the first of these speeds is above the critical one: its history overflows
GROWING = captured_beam(response={"duration": 10.0, "samples": 64})
FAST_FIRST = {"parameter": "rotation%angular_velocity", "values": [3000.0, 20.0, 10.0, 0.0]}


@pytest.fixture(scope="module")
def whole(shared):
    """What one run gives."""
    place = shared("whole")
    return place.simulate("a", SCENE, SPEEDS)


def part(here, number, of, *words):
    return here.beamwave("run", "a.nml", "--part", f"{number}/{of}", *words)


@pytest.mark.parametrize("parts", [1, 2, 5, CASES + 2])
def test_parts_in_any_order_give_the_same_bits(here, whole, parts):
    here.scene("a", SCENE, SPEEDS)
    order = random.Random(f"{SEED} {parts}").sample(range(1, parts + 1), parts)
    done = set()
    for number in order:
        own = set(range(number, CASES + 1, parts))
        ended = part(here, number, parts)
        assert ended.returncode == 0, ended.stderr
        done |= own
        if len(done) < CASES:
            assert f"part {number} of {parts} is done: {len(own)} of {CASES} cases" in ended.stdout
            missing = {
                int(p): int(n) for n, p in re.findall(r"missing +(\d+) of the \d+ cases of part (\d+)", ended.stdout)
            }
            left = {p: len(set(range(p, CASES + 1, parts)) - done) for p in range(1, parts + 1)}
            left = {p: n for p, n in left.items() if n}
            assert list(missing.items()) == list(left.items())[:10]
            further = re.search(r"cases of (\d+) further parts", ended.stdout)
            assert int(further[1] if further else 0) == max(0, len(left) - 10)
            assert cases_in(here.directory / "output/a.partial") == done
    assert results.differences(here.result("a"), whole) == []
    assert here.left() == ["a.nc"]
    assert "nothing to do" in part(here, order[0], parts).stdout


@pytest.mark.parametrize("locks", ["with locks", "without locks"])
def test_parts_at_once_give_the_same_bits(here, injector, whole, locks):
    from faults import NO_LOCKS

    here.scene("a", SCENE, SPEEDS)
    if locks == "without locks":
        here.environment = injector.environment(here, NO_LOCKS)
    for _ in range(3):
        running = [here.start("run", "a.nml", "--part", f"{number}/4") for number in range(1, 5)]
        said = [one.communicate(timeout=SECONDS) for one in running]
        assert [one.returncode for one in running] == [0] * 4, said
        assert sum("result     output/a.nc" in out for out, _ in said) == 1, said
        assert results.differences(here.result("a"), whole) == []
        assert here.left() == ["a.nc"]
        (here.directory / "output/a.nc").unlink()


def test_a_part_tells_of_its_own_failures_alone(here):
    here.scene("a", GROWING, FAST_FIRST)
    failed = part(here, 1, 2)
    assert failed.returncode == 4
    assert "1 of the 2 cases of part 1 hold numbers that cannot be trusted" in failed.stderr
    assert part(here, 2, 2).returncode == 0
    assert here.result("a")["case_status"].tolist() == [1, 0, 0, 0]
    again = here.beamwave("run", "a.nml")
    assert "nothing to do" in again.stdout and "1 of its cases cannot be trusted" in again.stdout


def test_a_part_that_is_stopped_goes_on(here):
    here.scene("a", ENDLESS, RATIOS)
    stopped = part(here, 2, 3, "--max-seconds", "0.5")
    assert stopped.returncode == 5
    saved = cases_in(here.directory / "output/a.partial")
    assert saved and {case % 3 for case in saved} == {2}
    assert f"stopped with {len(saved)} of 20000 cases saved" in stopped.stderr
    assert part(here, 2, 3, "--max-seconds", "0.5").returncode == 5
    assert cases_in(here.directory / "output/a.partial") > saved


@pytest.mark.parametrize(
    ("first", "second"),
    [(("--part", "1/2"), ("--part", "1/2")), (("--part", "1/2"), ()), ((), ("--part", "1/2"))],
    ids=["the same part", "a part and a run", "a run and a part"],
)
def test_what_another_is_at_work_on_is_refused(here, first, second):
    here.scene("a", ENDLESS, RATIOS)
    running = here.start("run", "a.nml", "--max-seconds", "20", *first)
    wait_for_cases(here)
    refused = here.beamwave("run", "a.nml", *second, status=3)
    assert "another run is at work" in refused.stderr
    assert running.poll() is None
    running.terminate()
    running.communicate(timeout=SECONDS)
    assert running.returncode == 5


def on_host(here, name, *words):
    """The program on a host of that name."""
    command = " ".join(shlex.quote(str(word)) for word in here.command(words))
    for unshare in [["unshare", "--uts"], ["unshare", "--user", "--map-root-user", "--uts"]]:
        words = [*unshare, "sh", "-c", f"hostname {name} && {command}"]
        probe = [*unshare, "hostname", name]
        if subprocess.run(probe, capture_output=True, check=False).returncode == 0:
            return subprocess.run(words, cwd=here.directory, capture_output=True, text=True, timeout=SECONDS, check=False)
    pytest.skip("no name can be given to a host here: needs root, or namespaces for users")


def test_each_further_host_has_a_draft_of_its_own(here, whole):
    here.scene("a", SCENE, SPEEDS)
    for number, host in [(3, "first"), (1, "second"), (4, "second")]:
        ended = on_host(here, host, "run", "a.nml", "--part", f"{number}/4")
        assert ended.returncode == 0, ended.stderr
    partial = here.directory / "output/a.partial"
    assert [path.name for path in drafts_in(partial)] == ["draft.nc", "draft.second.nc"]
    ended = on_host(here, "third", "run", "a.nml", "--part", "2/4")
    assert ended.returncode == 0, ended.stderr
    assert results.differences(here.result("a"), whole) == []
    assert here.left() == ["a.nc"]


def test_a_scene_of_one_case_is_part_1(here):
    here.scene("a", SCENE)
    second = part(here, 2, 3)
    assert second.returncode == 0
    assert "part 2 of 3 has nothing to do: the scene has one case, which is part 1" in second.stdout
    assert not (here.directory / "output").exists()
    assert part(here, 1, 3).returncode == 0
    assert here.left() == ["a.nc"]


def test_parts_take_up_what_a_run_left_and_a_run_what_parts_left(here, whole):
    here.scene("a", SCENE, SPEEDS)
    for number in (1, 3):
        assert part(here, number, 3).returncode == 0
    saved = cases_in(here.directory / "output/a.partial")
    ended = here.beamwave("run", "a.nml")
    assert f"{len(saved)} cases were taken over from an earlier run" in ended.stdout
    assert results.differences(here.result("a"), whole) == []


def test_a_part_leaves_the_work_of_another_scene_to_its_owner(here, whole):
    here.scene("a", SCENE, SPEEDS)
    assert part(here, 1, 2).returncode == 0
    here.scene("a", SCENE, {**SPEEDS, "count": SPEEDS["count"] + 1} if "count" in SPEEDS else {**SPEEDS, "values": SPEEDS["values"][:-1]})
    for number in (1, 2):
        refused = part(here, number, 2)
        assert refused.returncode == 3
        assert "output/a.partial: contains unfinished work of another scene, table or version" in refused.stderr
    here.scene("a", SCENE, SPEEDS)
    assert part(here, 2, 2).returncode == 0
    assert results.differences(here.result("a"), whole) == []


@pytest.mark.parametrize("value", ["0/3", "4/3", "3", "1/2/3", "-1/2", "a/b", "1/", "/2", "1.5/2", "99999999999/99999999999"])
def test_what_is_no_part_is_refused(here, value):
    here.scene("a", SCENE)
    ended = here.beamwave("run", "a.nml", f"--part={value}", status=2)
    assert f"--part: '{value}' is not a part; accepted: I/N" in ended.stderr


@pytest.mark.parametrize("value", ["1/1", "1/2"])
def test_a_part_does_not_overwrite(here, value):
    here.scene("a", SCENE)
    ended = here.beamwave("run", "a.nml", "--part", value, "--overwrite", status=2)
    assert "--part and --overwrite: one part would remove the work of the others" in ended.stderr


def test_processes_share_a_part(processes, whole):
    here = processes(2)
    here.scene("a", SCENE, SPEEDS)
    for number in (2, 1):
        assert part(here, number, 2).returncode == 0
    assert results.differences(here.result("a"), whole) == []
    assert here.left() == ["a.nc"]
