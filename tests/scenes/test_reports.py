"""What a person reads: warnings in `check` and `run`, reports again, many scenes in few lines, remarks that are no warnings."""

import math
import re

import numpy as np
import pytest
from workplace import SECONDS, captured_beam, unwrapped

BEAM = {"length": 1.0, "density": 7870.0, "youngs_modulus": 2e11, "diameter": 0.037}
STRUCK = {"beam": BEAM, "impact": {"mass_ratio": 0.2}, "capture": {}}
WATCHED = {"duration": 0.1, "samples": 1000}

DOUBTFUL = {
    "velocities that converge slowly": {**STRUCK, "response": {**WATCHED, "velocity": True}},
    "turns a minute": {**STRUCK, "rotation": {"angular_velocity": 500.0}, "response": WATCHED},
    "gigapascals": {**STRUCK, "beam": {**BEAM, "youngs_modulus": 200.0}, "response": WATCHED},
    "a thick beam": {**STRUCK, "beam": {**BEAM, "diameter": 0.2}},
    "samples far apart": {**STRUCK, "response": {"duration": 1.0, "samples": 100}},
    "few modes": {**STRUCK, "modes": {"before": 3}, "response": {**WATCHED, "bending_moment": True}},
    "rotation without effect": {**STRUCK, "rotation": {"angular_velocity": 50.0, "plane": "out"}},
}


def warnings_of(ended):
    return [line for line in ended.stderr.splitlines() if ": warning: " in line]


@pytest.mark.parametrize("scene", DOUBTFUL.values(), ids=DOUBTFUL.keys())
def test_check_warns_of_all_that_a_run_warns_of(here, scene):
    here.scene("a", scene)
    checked = here.beamwave("check", "a.nml", "--quiet")
    ended = here.beamwave("run", "a.nml", "--quiet")
    assert (checked.returncode, ended.returncode) == (0, 0)
    assert warnings_of(checked) == warnings_of(ended) != []


@pytest.mark.parametrize("command", ["check", "run"])
def test_a_log_of_both_streams_has_each_warning_once(here, command):
    here.scene("a", DOUBTFUL["few modes"])
    here.scene("b", DOUBTFUL["few modes"])
    apart = here.beamwave(command, "b.nml")
    assert warnings_of(apart)
    with (here.directory / "log").open("w+") as log:
        assert here.start(command, "a.nml", stdout=log, stderr=log).wait(SECONDS) == 0
        log.seek(0)
        together = unwrapped(log.read())
    for warning in warnings_of(apart):
        text = warning.removeprefix("b.nml: ")
        assert unwrapped(apart.stdout).count(text) == together.count(text) == 1


def test_check_foretells_what_it_has_not_the_time_to_run(here):
    many = {"before": 300_000, "after": 300_000}
    turning = {"rotation": {"angular_velocity": 500.0}, "response": {"duration": 0.5, "samples": 100}, "modes": many}
    here.scene("a", {**STRUCK, **turning, "release": {"time": 0.25}})
    kinds = [line.split(": ")[2] for line in warnings_of(here.beamwave("check", "a.nml", "--quiet"))]
    assert kinds == ["unstable", "outside linear theory", "large deflection"]


def test_a_body_that_acts_on_nothing_is_pointed_out(here):
    here.scene("a", {**STRUCK, "modes": {"before": 5}, "body": {"position": 0.9999999, "mass": 0.0}})
    ended = here.beamwave("run", "a.nml")
    assert "no effect: the body at xi = 0.9999999 has neither mass nor inertia" in ended.stderr
    assert "body without mass at xi = 0.9999999" in ended.stdout


def test_a_case_that_is_foretold_is_named_by_its_number(here):
    """A light mass leaves the beam where it is: of the sweep's cases it is not the first that deflects it."""
    masses = np.linspace(1e-4, 0.2, 1000).tolist()
    struck = {"mass_ratio": 0.0, "approach_velocity": 60.0}
    many = {"modes": {"before": 3000}, "response": {"duration": 0.1, "samples": 6_000_000}}
    here.scene("a", {**STRUCK, **many, "impact": struck}, {"parameter": "impact%mass_ratio", "values": masses})
    found = re.search(r"case (\d+)[^:]*: (large deflection: up to \S+ m)", here.beamwave("check", "a.nml").stderr)
    few = {"modes": {"before": 20}, "response": {"duration": 0.1, "samples": 1000}}
    here.scene("b", {**STRUCK, **few, "impact": {**struck, "mass_ratio": masses[int(found[1]) - 1]}})
    assert int(found[1]) > 1
    assert found[2] in here.beamwave("run", "b.nml").stderr


def test_check_says_what_the_machine_has_not_the_room_for(here):
    """Nothing is asked for that is not there: 16 TB of memory, and of disk some hundred times that."""
    vast = {"duration": 1.0, "samples": 1_000_000_000, "points": np.linspace(0.0, 1.0, 500).tolist()}
    here.scene("a", {**STRUCK, "response": vast}, {"parameter": "impact%mass_ratio", "first": 0.1, "last": 0.2, "count": 1000})
    here.scene("b", {**STRUCK, "response": WATCHED})
    ended = here.beamwave("check", "a.nml", status=0)
    assert re.search(r"memory: a run needs 80\d0 GB, but this machine has \d\S* .B free", ended.stderr)
    assert re.search(r"disk: a run needs 4000000 GB, but only \d\S* .B are free", ended.stderr)
    assert "tried      at most 20 modes and 1000 samples;" in ended.stdout
    assert warnings_of(here.beamwave("check", "b.nml")) == []


def test_check_speaks_of_no_samples_where_no_history_is_asked_for(here):
    long = {"first": 5.0, "last": 1000.0, "count": 20_000, "points": [0.2, 0.4, 1.0]}
    here.scene("a", {"beam": STRUCK["beam"], "damping": {"ratio": 0.01}, "frequency_response": long, "modes": {"before": 12}})
    said = here.beamwave("check", "a.nml").stdout
    assert "tried      at most 20 modes\n" in said, said


def test_a_scene_without_its_ending_is_pointed_out(here):
    here.scene("a", STRUCK)
    assert here.beamwave("run", "a").stderr == "a: cannot be read: No such file or directory; a.nml is there\n"
    assert "is there" not in here.beamwave("run", "b").stderr


@pytest.mark.parametrize("more", [{}, {"damping": {"ratio": 0.01}}, {"rotation": {"angular_velocity": 50.0}}])
def test_a_default_spectrum_is_no_reason_for_warnings(here, more):
    here.scene("a", {**STRUCK, **more, "response": WATCHED, "spectrum": {}})
    ended = here.beamwave("run", "a.nml")
    assert ended.returncode == 0 and "warning" not in ended.stderr  # the search may take so long that there is progress
    assert "grow or decay" not in ended.stdout
    notes = here.result("a").attributes["notes"].splitlines()
    assert all(note.startswith("remark: ") for note in notes)
    assert len({note.split(": ")[1] for note in notes}) == len(notes)


def test_a_finished_scene_shows_its_report_again(here):
    here.scene("a", DOUBTFUL["velocities that converge slowly"])
    first = here.beamwave("run", "a.nml").stdout.splitlines()
    again = here.beamwave("run", "a.nml").stdout.splitlines()
    timed = next(i for i, line in enumerate(first) if line.startswith("  time "))
    assert again[:timed] == first[:timed]
    assert again[timed] == "  output/a.nc: nothing to do, the result of this scene is there"
    assert again[timed + 1 :] == first[-1:] == ["  details    15 more lines with --verbose"]  # modes 6 to 20


def test_a_sweep_shows_first_last_and_extreme_cases_or_all_where_they_are_few_and_a_finished_one_shows_them_again(here):
    turning = {**STRUCK, "rotation": {"angular_velocity": 0.0}, "modes": {"before": 4}, "response": {"duration": 0.1, "samples": 50}}
    for count in (31, 4):
        name = here.scene(f"a{count}", turning, {"parameter": "rotation%angular_velocity", "first": 0.0, "last": 150.0, "count": count})
        first, again = (here.beamwave("run", name).stdout.splitlines() for _ in range(2))
        table, same = ([line for line in said if "rotation%angular_velocity = " in line] for said in (first, again))
        assert table == same
        reasons = [line.split("angular_velocity = ")[1] for line in table]
        if count == 4:
            assert reasons == ["0", "50", "100", "150"]
            continue
        assert reasons[0].startswith("0 (first, highest frequency") and reasons[-1] == "150 (last, largest displacement)"
        assert {"120 (lowest frequency)", "125 (first without frequency)"} <= set(reasons)
        assert "    31 cases in the file" in "\n".join(first)


def test_a_sweep_of_a_free_hub_shows_the_lowest_mode_that_bends_the_beam(here):
    """Mode 1 is the turn; what is the same in all cases is the lowest and the highest of none."""
    sweep = {"parameter": "hub%rotary_inertia", "first": 0.1, "last": 1.0, "count": 3}
    here.scene("a", {"beam": BEAM, "hub": {"rotary_inertia": 0.1}, "modes": {"before": 5}}, sweep)
    ds, said = here.run("a"), here.beamwave("run", "a.nml").stdout
    assert "mode 2: frequency" in said and " 0 Hz" not in said
    assert [float(line.split()[2]) for line in said.splitlines() if "hub%rotary_inertia = " in line] == pytest.approx(
        ds["angular_frequency"][:, 1].tolist(), rel=1e-6)
    here.scene("b", {"beam": BEAM, "impact": {"mass_ratio": 0.2}, "modes": {"before": 5}},
               {"parameter": "impact%mass_ratio", "first": 0.1, "last": 1.0, "count": 30})
    said = here.beamwave("run", "b.nml").stdout
    assert "(first)" in said and "(last)" in said and "lowest frequency" not in said


def test_a_sweep_of_contacts_shows_what_comes_of_them_and_no_mode_that_stays(here):
    """Of a mass that moves along the beam; one that stays on it changes the modes."""
    sweep = {"parameter": "impact%position", "values": [0.6, 0.8, 1.0]}
    groups = {"beam": BEAM, "impact": {"mass_ratio": 0.2}, "contact": {"radius": 0.025}, "modes": {"before": 20}}
    groups["response"] = {"duration": 0.002, "samples": 50, "bending_moment": True}
    ds, said = here.simulate("a", groups, sweep), here.beamwave("run", "a.nml").stdout
    assert "Each case; mode 1 has 26.09398 Hz in all" in said and "phase velocity" not in said
    head = next(line for line in said.splitlines() if line.split()[:1] == ["case"])
    assert re.split("  +", head.strip()) == ["case", "modes", "displacement", "stress", "contact force", "restitution", "mass leaves at", "swept"]
    rows = [line.split() for line in said.splitlines() if line.endswith(("= 0.6", "= 0.8", "= 1"))]
    told = np.array([[float(cell) for cell in row[2:7]] for row in rows])
    stress, displacement = (ds[name].max(axis=1) for name in ("largest_stress", "largest_displacement"))
    mass = 0.2 * BEAM["density"] * BEAM["length"] * math.pi * BEAM["diameter"] ** 2 / 4
    leaves = 1.0 - np.where(ds["event_kind"] > 0, ds["event_impulse"], 0.0).sum(axis=1) / mass
    assert np.allclose(told.T, [displacement, stress, ds["largest_contact_force"], ds["restitution"], leaves], rtol=1e-4)
    here.scene("b", {**groups, "capture": {}}, sweep)
    assert "mode 1: frequency" in here.beamwave("run", "b.nml").stdout


def test_a_report_says_how_mass_and_hub_go_on_after_contacts(here):
    groups = {"beam": BEAM, "hub": {"rotary_inertia": 0.5, "radius": 0.1}, "impact": {"mass": 1.0}, "contact": {"radius": 0.025}}
    here.scene("a", {**groups, "modes": {"before": 20}, "response": {"duration": 0.01, "samples": 50}})
    ds, said = here.run("a"), here.beamwave("run", "a.nml").stdout
    impulse, force = (ds[name][ds["event_kind"] > 0] for name in ("event_impulse", "event_force"))
    assert len(impulse) > 1
    moves = float(re.search(r"After the last contact the mass moves at (\S+) m/s", said)[1])
    assert moves == pytest.approx(1.0 - impulse.sum(), rel=1e-4)
    assert ds["final_mass_velocity"].item() == pytest.approx(moves, rel=1e-4)
    hardest = re.search(r"The largest force, (\S+) N, occurs in contact (\d+), at (\S+) s", said)
    at = int(hardest[2]) - 1
    assert float(hardest[1]) == pytest.approx(float(ds["largest_contact_force"]), rel=1e-5) and at == np.argmax(force)
    assert float(hardest[3]) == pytest.approx(ds["event_force_time"][at], rel=1e-5)
    leaves = re.search(r"m/s, (\S+) of its approach velocity", said)
    assert float(leaves[1]) == pytest.approx(moves, abs=2e-3)  # it came with 1 m/s
    rows = [line.split() for line in said.splitlines() if line.startswith("  contact ")]
    assert "largest force" in said and np.allclose([float(row[5]) for row in rows], force[: len(rows)], rtol=1e-6)
    assert "hub faster by" in said
    assert np.allclose([float(row[-1]) for row in rows], ds["hub_rate_change"][: len(rows)], rtol=1e-5)


@pytest.mark.parametrize("more", [{}, {"extreme_fibre": 0.01}])
def test_moments_without_stresses_say_what_is_missing(here, more):
    beam = {"length": 1.0, "density": 7870.0, "youngs_modulus": 2e11, "area": 1e-3, "second_moment": 1e-7, **more}
    here.scene("a", {"beam": beam, **{g: STRUCK[g] for g in ("impact", "capture")}, "response": {**WATCHED, "bending_moment": True}})
    assert ("(no stress without &beam extreme_fibre)" in here.beamwave("check", "a.nml").stdout) is not bool(more)


def test_many_scenes_have_one_line_each_and_are_counted(here):
    for i in range(12):
        here.scene(f"set/a{i:02}", STRUCK)
    here.scene("set/b", DOUBTFUL["turns a minute"])
    here.write("set/c.nml", "&beam length=0,5 /")
    ended = here.beamwave("run", "set")
    lines = ended.stdout.splitlines()
    assert ended.returncode == 2
    assert lines[:12] == [f"output/a{i:02}.nc: done" for i in range(12)]
    assert lines[12] == "output/b.nc: done; warnings: unstable, outside linear theory, large deflection"
    assert lines[13:] == ["14 scenes: 13 done (1 with warnings), 1 wrong"]
    assert here.beamwave("run", "set").stdout.endswith("14 scenes: 13 done (13 there already, 1 with warnings), 1 wrong\n")
    assert here.beamwave("check", "set").stdout.endswith("14 scenes: 13 good (1 with warnings), 1 wrong\n")


def test_a_default_that_cannot_be_met_is_called_the_default(here):
    short = {**STRUCK, "response": {"duration": 1e-8, "samples": 100, "points": 0.01}}
    here.scene("a", short)
    assert "of its peak; the default 1e-6 is out of reach" in here.run("a").attributes["notes"]
    here.scene("b", {**short, "modes": {"tolerance": 1e-6}})
    assert "modes%tolerance: 1e-6 cannot be reached" in here.beamwave("run", "b.nml").stderr


def test_a_bending_moment_is_there_if_asked_for(here):
    here.scene("a", {**STRUCK, "response": {**WATCHED, "points": [0.0, 0.4, 1.0]}})
    assert "bending_moment" not in here.run("a")
    result = here.simulate("b", {**STRUCK, "response": {**WATCHED, "points": [0.0, 0.4, 1.0], "bending_moment": True}})
    assert result["bending_moment"].shape == (3, 1000)
    assert result["bending_moment_error"].shape == (3,)
    assert not result["bending_moment"][2].any()
    # at the root of a cantilever that bends as under its tip load, M = 3 EI v/l², within what higher modes add
    stiffness = 2e11 * np.pi / 64 * 0.037**4
    root, tip = np.abs(result["bending_moment"][0]).max(), np.abs(result["displacement"][2]).max()
    assert 1.0 < root / (3 * stiffness * tip) < 5.0


@pytest.mark.parametrize("modes", [{"before": 40, "after": 40}, {"tolerance": 1e-3}, {"tolerance": 1e-6}])
def test_the_bound_of_an_error_is_printed_to_two_digits_that_are_not_below_it(here, modes):
    response = {"duration": 0.1, "samples": 200, "points": [0.3, 0.5, 1.0]}
    here.scene("a", {**captured_beam(response=response), "modes": modes})
    lines = here.beamwave("run", "a.nml").stdout.split("proved bound\n")[1].splitlines()[1:4]
    bounds = here.result("a")["displacement_bound"]
    shown = np.array([float(line.split()[-1]) for line in lines])
    assert (shown >= bounds).all() and (shown < 1.1 * bounds).all()
