"""The power is cut at any moment: what a journalled file system then holds is the result, or work that the same command
takes up again. By hand, as root, on Linux with loop devices, mkfs.xfs and mkfs.ext4:

    python3 tests/faults/power_cuts.py [--moments 30] [--beamwave build/bin/beamwave]

The program writes to an ext4 in a file that lies on an XFS. XFS copies a file at once (`cp --reflink`), so a copy is what
the disk held at one moment; it is mounted, which plays ext4's journal back, and the program is run on it again. Half of the
moments fall into runs, the others into the 30 s after runs that ended with 0, and after those that were stopped with 5."""

import argparse
import contextlib
import random
import re
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

SCENES = Path(__file__).parents[1] / "scenes"
sys.path.insert(0, str(SCENES))

import results  # noqa: E402
from drafts import cases_in  # noqa: E402
from workplace import captured_beam, namelist  # noqa: E402

CASES = 1500
SCENE = captured_beam(modes={"before": 20, "after": 20}, response={"duration": 1.0, "samples": 4096})
SWEEP = {"parameter": "rotation%angular_velocity", "first": 0.0, "last": 100.0, "count": CASES}
SAVED = re.compile(rf"stopped with (\d+) of {CASES} cases saved")


def do(*words, **options):
    return subprocess.run([str(word) for word in words], check=True, capture_output=True, text=True, **options)


@contextlib.contextmanager
def mounted(image, place):
    place.mkdir(exist_ok=True)
    do("mount", "-o", "loop", image, place)
    try:
        yield place
    finally:
        for _ in range(50):
            if subprocess.run(["umount", str(place)], capture_output=True).returncode == 0:
                break
            time.sleep(0.1)


class Disk:
    """An ext4 that can be copied at once while it is used."""

    def __init__(self, work, outer):
        self.work = work
        self.image = outer / "disk.img"
        self.copies = 0

    def new(self):
        with self.image.open("wb") as file:
            file.truncate(400 * 2**20)
        do("mkfs.ext4", "-q", "-F", self.image)
        return mounted(self.image, self.work / "disk")

    def copy(self):
        """As the power would leave it now."""
        self.copies += 1
        path = self.image.with_name(f"copy{self.copies}.img")
        do("cp", "--reflink=always", self.image, path)
        return path


def command(program, place, *words):
    return [str(program), "run", str(place / "a.nml"), "--output", str(place / "output"), "--quiet", *words]


def start(program, place):
    (place / "a.nml").write_text(namelist(SCENE, SWEEP))
    do("sync", "-f", place / "a.nml")
    return subprocess.Popen(command(program, place), stderr=subprocess.PIPE, text=True)


def judge(program, disk, image, expected, at_least):
    """What is there after the cut, and after the same command has been run again."""
    with mounted(image, disk.work / "after") as place:
        found = "result" if (place / "output/a.nc").exists() else "work"
        if found == "result":
            assert results.differences(results.read(place / "output/a.nc"), expected) == [], "the result is another"
        cases = len(cases_in(place / "output/a.partial"))
        assert found == "result" or cases >= at_least, f"{at_least} cases were said to be saved, {cases} are there"
        ended = subprocess.run(command(program, place), capture_output=True, text=True)
        assert ended.returncode == 0, ended.stderr
        assert results.differences(results.read(place / "output/a.nc"), expected) == [], "the taken up result is another"
        left = sorted(path.name for path in (place / "output").iterdir())
        assert left == ["a.nc"], left
    image.unlink()
    return found, cases


def main():
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("--moments", type=int, default=30)
    words.add_argument("--seed", type=int, default=20261122)
    words.add_argument("--beamwave", type=Path, default=Path(__file__).parents[2] / "build/bin/beamwave")
    given = words.parse_args()
    program, dice = given.beamwave.resolve(), random.Random(given.seed)
    work = Path(tempfile.mkdtemp(prefix="power_cuts."))
    try:
        outer = work / "outer.img"
        with outer.open("wb") as file:
            file.truncate(3 * 2**30)
        do("mkfs.xfs", "-q", "-m", "reflink=1", outer)
        with mounted(outer, work / "outer") as place:
            disk = Disk(work, place)
            cut_power(program, disk, dice, given.moments)
    finally:
        shutil.rmtree(work, ignore_errors=True)


def cut_power(program, disk, dice, moments):
    with disk.new() as place:
        began = time.monotonic()
        running = start(program, place)
        assert running.wait() == 0, running.stderr.read()
        seconds = time.monotonic() - began
        expected = results.read(place / "output/a.nc")
    print(f"a run takes {seconds:.2f} s")
    for moment in range(moments):
        kind = ["in the run", "after 0", "in the run", "after 0", "after 5", "after 0"][moment % 6]
        said = 0
        with disk.new() as place:
            running = start(program, place)
            if kind == "in the run":
                time.sleep(dice.uniform(0.0, 1.2 * seconds))
            elif kind == "after 5":
                time.sleep(0.5 * seconds)
                running.terminate()
            if kind != "in the run":
                _, err = running.communicate()
                assert running.returncode in (0, 5), err
                stopped = SAVED.search(err)
                said = int(stopped[1]) if stopped else CASES
                time.sleep(dice.choice([0.0, 0.0, dice.uniform(0, 6), dice.uniform(0, 30)]))
            image = disk.copy()
            if kind == "in the run":
                running.kill()
                running.communicate()
        found, cases = judge(program, disk, image, expected, said)
        assert kind != "after 0" or found == "result", "the result was said to be there"
        print(f"{moment + 1}: {kind}: {found}, {cases} cases saved; taken up: the same bits", flush=True)


if __name__ == "__main__":
    main()
