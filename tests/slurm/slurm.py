"""What tests ask of Slurm: that it runs, and what becomes of jobs."""

import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import pytest

TESTS = Path(__file__).parent
PROJECT = TESTS.parents[1]
SECONDS = 90  # far above any job here: what takes longer hangs
RESTART_DELAY = 2  # s; a job that starts again within the second it was stopped in is refused its credential


class Slurm:
    """Slurm on the loopback, for as long as it is the context; it ends with this process however that ends."""

    def __enter__(self):
        # Not under pytest's directories: paths of sockets are short.
        self.directory = Path(tempfile.mkdtemp(prefix="bw-slurm-"))
        self.configuration = self.directory / "slurm.conf"
        command = [sys.executable, str(TESTS / "slurm_on_loopback.py"), str(self.directory)]
        self.keeper = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        if self.keeper.stdout.readline() != "ready\n":
            reason = self.keeper.stdout.read()
            self.__exit__()
            raise AssertionError(f"Slurm does not come up: {reason}")
        return self

    def __exit__(self, *_):
        self.keeper.stdin.close()
        self.keeper.stdout.read()  # ends when all has been stopped
        self.keeper.wait()


class Jobs:
    """Submits job scripts and watches them."""

    def __init__(self, environment):
        self.environment = environment

    def call(self, *words, **options):
        """Run a command of Slurm; return what it says."""
        options = {"env": self.environment, "capture_output": True, "text": True, "timeout": SECONDS, **options}
        done = subprocess.run([str(word) for word in words], check=False, stdin=subprocess.DEVNULL, **options)
        assert done.returncode == 0, f"{words}: {done.stderr}"
        return done.stdout

    def submit(self, place, *words, **variables):
        """Submit `[OPTION …] SCRIPT [ARGUMENT …]` in the directory of `place`; return the job's number."""
        environment = {**self.environment, **variables}
        return self.call("sbatch", "--parsable", *words, cwd=place.directory, env=environment).strip()

    def tasks(self, job):
        """What Slurm knows of a job, or of each task of an array: dicts."""
        lines = self.call("scontrol", "--oneliner", "show", "job", job).splitlines()
        return [dict(re.findall(r"(\w+)=(\S*)", line)) for line in lines if line]

    def states(self, job):
        """(state, exit status) of a job or of each task of an array, in the order of the tasks."""
        tasks = sorted(self.tasks(job), key=lambda task: int(re.match(r"\d+", task.get("ArrayTaskId", "0"))[0]))
        return [(task["JobState"], int(task["ExitCode"].split(":")[0])) for task in tasks]

    def wait(self, job, *states):
        """Wait until all of a job is in one of `states`, by default at an end of whichever kind."""
        until = time.monotonic() + SECONDS
        waiting = {"PENDING", "RUNNING", "COMPLETING", "CONFIGURING", "REQUEUED"}
        while True:
            now = {state for state, _ in self.states(job)}
            if now <= set(states) if states else not now & waiting:
                return
            assert time.monotonic() < until, f"job {job}: {self.states(job)}"
            self.start_again(job)
            time.sleep(0.1)

    def start_again(self, job):
        """Let a job that queued itself again start soon: Slurm would hold it for two minutes."""
        for task in self.tasks(job):
            if task["Reason"] == "BeginTime" and task["EligibleTime"] > soon(2 * RESTART_DELAY):
                self.call("scontrol", "update", f"JobId={task['JobId']}", f"StartTime={soon(RESTART_DELAY)}")

    def ended(self, place, *words, **variables):
        """Submit a job and wait for its end; return its number and (state, exit status)."""
        job = self.submit(place, *words, **variables)
        self.wait(job)
        return job, self.states(job)[0]


def needs_mpi(jobs):
    """Skip a test where beamwave-mpi was not built; where Slurm has to be there, that has to be as well."""
    missing = [name for name in ["mpirun", "beamwave-mpi"] if not shutil.which(name, path=jobs.environment["PATH"])]
    if missing:
        assert not os.environ.get("BEAMWAVE_REQUIRE_SLURM"), f"no {' and no '.join(missing)}"
        pytest.skip(f"no {' and no '.join(missing)}")


def soon(seconds):
    """The time so many seconds from now, as Slurm writes it."""
    return time.strftime("%Y-%m-%dT%H:%M:%S", time.localtime(time.time() + seconds))
