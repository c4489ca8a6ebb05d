"""Scenes written as namelists, and the program run on them in one directory."""

import ast
import re
import subprocess
import time
from pathlib import Path

import results

PAPER_BEAM = {"length": 1.0, "diameter": 0.037, "density": 7870.0, "youngs_modulus": 2e11}
SECONDS = 120  # far above any run here: what takes longer hangs

# what Open MPI has to be told, and others do not mind: more processes than cores, and root, as in a container
MPI_ON_FEW_CORES = {
    "OMPI_MCA_rmaps_base_oversubscribe": "1",
    "PRTE_MCA_rmaps_default_mapping_policy": ":oversubscribe",
    "OMPI_ALLOW_RUN_AS_ROOT": "1",
    "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
}


def wait_until(is_so):
    """Until a call says that it is so."""
    until = time.perf_counter() + SECONDS
    while not is_so():
        assert time.perf_counter() < until
        time.sleep(0.002)


def unwrapped(text):
    """A report whose notes are a line each."""
    return re.sub(r"\n {4}(?=\S)", " ", text)


def captured_beam(**groups):
    """The paper's capture with few modes; `groups` (dicts) are merged in, one given as None is left out."""
    scene = {
        "beam": dict(PAPER_BEAM),
        "rotation": {"angular_velocity": 50.0},
        "impact": {"mass_ratio": 0.2},
        "capture": {},
        "modes": {"before": 12, "after": 10},
    }
    for name, values in groups.items():
        if values is None:
            scene.pop(name, None)
        else:
            scene[name] = {**scene.get(name, {}), **values}
    return scene


# small cases with much to sum, and so many that any build is under way when they are stopped
ENDLESS = {**captured_beam(response={"duration": 1.0, "samples": 64}), "modes": {"tolerance": 1e-10}}
RATIOS = {"parameter": "impact%mass_ratio", "first": 0.1, "last": 1.0, "count": 20_000}


def namelist(scene, *sweeps):
    """The scene as a namelist, with its `&sweep` groups (dicts) in their order."""
    groups = [*scene.items(), *(("sweep", sweep) for sweep in sweeps)]
    return "".join(group_text(name, values) for name, values in groups)


def group_text(name, values):
    lines = "".join(f"  {key} = {value_text(value)}\n" for key, value in values.items())
    return f"&{name}\n{lines}/\n"


def value_text(value):
    if isinstance(value, bool):
        return ".true." if value else ".false."
    if isinstance(value, str):
        return "'" + value.replace("'", "''") + "'"
    if isinstance(value, (list, tuple)):
        return ", ".join(value_text(item) for item in value)
    return repr(value)


def example(group):
    """A scene of `input/` that has a group, which effects that are in no list of a test are tested by; None where there is none."""
    for path in sorted((Path(__file__).parents[2] / "input").rglob("*.nml"), key=lambda path: ("effects" not in path.parts, path)):
        text = re.sub(r"!.*", "", path.read_text(encoding="utf-8"))
        scene = {name: inputs_of(words) for name, words in re.findall(r"&(\w+)([^/]*)/", text)}
        if group in scene:
            return scene
    return None


def inputs_of(words):
    """The names of a group with their values."""
    named = re.findall(r"(\w+)\s*=\s*([^=]*?)[\s,]*(?=\w+\s*=|$)", words)
    return {name: ast.literal_eval(re.sub(r"\.(true|false)\.", lambda word: word[1].title(), value)) for name, value in named}


class Workplace:
    """A directory in which the program runs; paths are relative to it, results go to `output/`."""

    def __init__(self, program, directory, launcher=(), environment=None):
        self.program = program
        self.directory = directory
        self.launcher = launcher  # words before the program: mpirun and its options
        self.environment = environment

    def write(self, name, text):
        """Write a file; return its name."""
        path = self.directory / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
        return name

    def scene(self, name, scene, *sweeps):
        """Write `<name>.nml`; return that name."""
        return self.write(f"{name}.nml", namelist(scene, *sweeps))

    def beamwave(self, *words, status=None, **options):
        """Run the program to its end, with this exit status if one is given; the answer has `returncode`, `stdout`, `stderr`."""
        options = {"capture_output": True, "timeout": SECONDS, "text": True, "cwd": self.directory, **options}
        if "stdout" in options:
            options["capture_output"] = False
            options.setdefault("stderr", subprocess.PIPE)
        ended = subprocess.run(self.command(words), stdin=subprocess.DEVNULL, env=self.environment, check=False, **options)
        assert status in (None, ended.returncode), ended.stderr
        return ended

    def start(self, *words, **options):
        """Start the program and leave it running."""
        options = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True, **options}
        options = {"cwd": self.directory, "env": self.environment, **options}
        return subprocess.Popen(self.command(words), stdin=subprocess.DEVNULL, **options)

    def command(self, words):
        return [*self.launcher, self.program, *map(str, words)]

    def run(self, name, *options, status=0):
        """Run scene `name` and return its result."""
        self.beamwave("run", f"{name}.nml", *options, status=status)
        return self.result(name)

    def simulate(self, name, scene, *sweeps, options=(), status=0):
        """Write a scene, run it, and return its result."""
        self.scene(name, scene, *sweeps)
        return self.run(name, *options, status=status)

    def dataset(self, name):
        """What xarray reads of a result, that of a scene or of a study of it (`a.effects`)."""
        import xarray  # takes most of a second, which few tests need

        with xarray.open_dataset(self.directory / f"output/{name}.nc") as ds:
            return ds.load()

    def study(self, command, name, scene):
        """Write a scene, study it by a command, and return what xarray reads of the result."""
        self.beamwave(command, self.scene(name, scene), "--quiet", status=0)
        return self.dataset(f"{name}.{command}")

    def result(self, name, directory="output"):
        """Read the result of scene `name`."""
        return results.read(self.directory / directory / f"{name}.nc")

    def left(self, directory="output"):
        """Names of all that lies in a directory of results, sorted."""
        path = self.directory / directory
        return sorted(str(item.relative_to(path)) for item in path.rglob("*"))
