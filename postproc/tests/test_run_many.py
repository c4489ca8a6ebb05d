"""`run_many(scenes)`: results in their order, failures that stop no other, and an order to stop that reaches all."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from beamwave_postproc import RunFailed, Untrusted, run, run_many

BEAM = {"length": 1.0, "diameter": 0.037, "density": 7870.0, "youngs_modulus": 2.0e11}


def scene(length=1.0, modes=3):
    return {"beam": {**BEAM, "length": length}, "modes": {"before": modes}}


def test_results_are_those_of_single_runs_in_the_order_of_the_scenes(beamwave):
    lengths = [1.0 + 0.1 * i for i in range(7)]
    found = run_many([scene(length) for length in lengths], 3)
    for length, ds in zip(lengths, found):
        assert ds.beam_length == length
        assert ds.angular_frequency.equals(run(scene(length)).angular_frequency)


def test_the_first_failure_is_raised_when_all_others_are_done(beamwave, tmp_path):
    told = []
    scenes = [scene(), scene(-1.0), scene(1.2), scene(-2.0)]
    with pytest.raises(RunFailed, match=r"'-1\.0' is out of range") as failure:
        run_many(scenes, 2, tmp_path, progress=lambda done, total: told.append((done, total)))
    assert failure.value.status == 2
    assert sorted(path.name for path in tmp_path.glob("*.nc")) == ["scene_1.nc", "scene_3.nc"]
    assert told == [(1, 4), (2, 4), (3, 4), (4, 4)]


def test_failures_can_be_values(beamwave):
    good, bad, missing = run_many([scene(), scene(-1.0), Path("none.nml")], 2, errors="return")
    assert good.beam_length == 1.0
    assert isinstance(bad, RunFailed) and isinstance(missing, FileNotFoundError)


def test_no_more_run_at_once_than_were_asked_for(tmp_path, stand_in):
    log = tmp_path / "log"
    program = stand_in(tmp_path, f'echo + >> "{log}"; sleep 0.3; echo - >> "{log}"; exit 3')
    run_many([scene()] * 6, 2, program=program, errors="return")
    running, most = 0, 0
    for line in log.read_text().split():
        running += 1 if line == "+" else -1
        most = max(most, running)
    assert most == 2


def test_what_is_there_is_not_run_again(beamwave, tmp_path):
    scenes = [scene(), scene(1.5)]
    run_many(scenes, 2, tmp_path)
    before = {path: path.stat().st_mtime_ns for path in tmp_path.glob("*.nc")}
    again = run_many([*scenes, scene(2.0)], 2, tmp_path)
    assert [float(ds.beam_length) for ds in again] == [1.0, 1.5, 2.0]
    assert before == {path: path.stat().st_mtime_ns for path in before}


def test_warnings_come_in_the_order_of_the_scenes(tmp_path, beamwave):
    growing = {
        "beam": BEAM, "rotation": {"angular_velocity": 3000.0}, "impact": {"mass_ratio": 0.2}, "capture": {},
        "modes": {"before": 5}, "response": {"duration": 10.0, "samples": 8},
    }  # fmt: skip
    with pytest.warns(Untrusted, match="overflow"):
        run_many([scene(), growing], 2)


@pytest.mark.parametrize("wrong", [{"processes": 0}, {"errors": "ignore"}, {"output": ""}])
def test_wrong_arguments_are_refused_before_anything_runs(wrong, tmp_path, stand_in):
    program = stand_in(tmp_path, f'touch "{tmp_path}/ran"')
    with pytest.raises(ValueError):
        run_many([scene()], program=program, **wrong)
    assert not (tmp_path / "ran").exists()


@pytest.mark.parametrize(
    ("scenes", "said"),
    [
        ([None], "scene 1 is a NoneType; accepted: a path"),
        ([scene(), 3.0], "scene 2 is a float; accepted: a path"),
        ("a.nml", "scenes is a str; accepted: a list of scenes"),
        (scene(), "scenes is a dict; accepted: a list of scenes"),
        (None, "scenes is a NoneType; accepted: a list of scenes"),
    ],
)
def test_what_is_no_list_of_scenes_is_refused_before_anything_runs(scenes, said, tmp_path, stand_in):
    program = stand_in(tmp_path, f'touch "{tmp_path}/ran"')
    with pytest.raises(ValueError, match=said):
        run_many(scenes, program=program, errors="return")
    assert not (tmp_path / "ran").exists()


def test_scenes_of_one_name_are_refused_where_they_would_write_one_file(tmp_path, stand_in):
    program = stand_in(tmp_path, f'touch "{tmp_path}/ran"')
    with pytest.raises(ValueError, match=r"a$"):
        run_many([Path("x/a.nml"), Path("y/a.nml")], output=tmp_path, program=program)
    assert not (tmp_path / "ran").exists()


def test_no_scenes_have_no_results(beamwave):
    assert run_many([]) == []


def test_an_exception_of_progress_stops_all_in_order(tmp_path, stand_in):
    program = stand_in(tmp_path, 'trap "exit 5" TERM; case $3 in *) sleep 0.1 & wait; esac; exit 3')

    def give_up(done, total):
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        run_many([scene()] * 50, 2, program=program, progress=give_up)


@pytest.mark.parametrize(("sent", "told"), [(signal.SIGINT, "KeyboardInterrupt"), (signal.SIGTERM, "")])
def test_a_signal_stops_all_in_order_and_the_same_call_goes_on(beamwave, tmp_path, sent, told):
    """Two long sweeps in a Python of their own: after the signal finished cases are saved, and no process is left."""
    script = tmp_path / "many.py"
    script.write_text(
        "from beamwave_postproc import run_many\n"
        f"base = {{'beam': {BEAM!r}, 'impact': {{'mass_ratio': 0.2}}, 'capture': {{}},\n"
        "        'modes': {'tolerance': 1e-10}, 'response': {'duration': 1.0, 'samples': 64}}\n"
        "sweep = {'parameter': 'impact%mass_ratio', 'first': 0.1, 'last': 1.0, 'count': 20000}\n"
        "print('begins', flush=True)\n"
        f"run_many([{{**base, 'sweep': sweep}}] * 2, 2, {str(tmp_path / 'output')!r})\n"
    )
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[1]), "BEAMWAVE": str(beamwave)}
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    with subprocess.Popen([sys.executable, script], env=environment, start_new_session=True, **pipes) as python:
        assert python.stdout.readline() == "begins\n"
        drafts = [tmp_path / f"output/scene_{number}.partial/draft.nc" for number in (1, 2)]
        deadline = time.monotonic() + 60
        while not all(draft.exists() for draft in drafts) and time.monotonic() < deadline:
            time.sleep(0.1)
        time.sleep(2.5)  # of which some cases are saved
        python.send_signal(sent)
        said = python.communicate(timeout=60)[1]
    assert told in said and python.returncode == (128 + sent if sent == signal.SIGTERM else -sent)
    assert all(draft.exists() for draft in drafts)
    running = subprocess.run(["pgrep", "-f", str(tmp_path / "output")], capture_output=True, text=True, check=False)
    assert running.stdout == ""


def test_sigterm_ends_the_program_of_a_single_run(tmp_path, stand_in):
    program = stand_in(tmp_path, 'trap "exit 5" TERM; echo + > "$0.begun"; while true; do sleep 0.1; done')
    script = tmp_path / "one.py"
    script.write_text(
        "from beamwave_postproc import run\n"
        f"run({{'beam': {BEAM!r}}}, program={str(program)!r})\n"
    )
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[1])}
    with subprocess.Popen([sys.executable, script], env=environment, start_new_session=True) as python:
        deadline = time.monotonic() + 30
        while not Path(f"{program}.begun").exists() and time.monotonic() < deadline:
            time.sleep(0.1)
        python.terminate()
        assert python.wait(30) == 128 + signal.SIGTERM
    running = subprocess.run(["pgrep", "-f", str(program)], capture_output=True, text=True, check=False)
    assert running.stdout == ""


def test_a_handler_of_the_caller_is_left_to_it(beamwave):
    heard = []
    before = signal.signal(signal.SIGTERM, lambda *_: heard.append(True))
    try:
        told = run_many([scene()] * 3, 1, progress=lambda done, total: done == 1 and signal.raise_signal(signal.SIGTERM))
    finally:
        signal.signal(signal.SIGTERM, before)
    assert heard == [True] and len(told) == 3
