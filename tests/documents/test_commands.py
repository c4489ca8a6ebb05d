"""The commands that the documents print run as they stand, from a fresh copy of the tree.

Each document starts from `~/beamwave` as `./run.sh` leaves it. Its shell blocks run in order in one shell, then its Python blocks.
A block is run whole, or not at all: NOT_HERE names the commands whose blocks are left out, and the tests list them. Here the copy gets the
programs of this build and the Python of this test. With BEAMWAVE_DOCUMENTS=all `./run.sh` builds in a clone, and blocks that build and
install are run too (20 minutes, and the network).
"""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from documents import PROJECT, all_documents, blocks, text_of, tokens
from workplace import MPI_ON_FEW_CORES

ALL = os.environ.get("BEAMWAVE_DOCUMENTS") == "all"
SECONDS = 1800 if ALL else 240  # far above what a document takes: what takes longer hangs
NOT_HERE = {
    "./run.sh": "every document starts from what it leaves",
    "./test.sh": "runs this test",
    "sbatch": "queues; tests/slurm carries out docs/cluster.md",
    "scontrol": "asks Slurm; tests/slurm carries out docs/cluster.md",
    "make_*.py": "takes an hour; tests/reference/README.md says so",
}
BY_HAND = {"cmake": "builds", "pip": "installs"}
PYTHON_ELSEWHERE = {
    "docs/cluster.md": "Slurm's jobs leave what it reads: tests/slurm runs it",
    "postproc/README.md": "postproc/tests/test_idioms.py runs its Python",
}
BEAM = "&beam length = 1, density = 7870, youngs_modulus = 2e11, diameter = 0.037 /\n"  # of a scene that shows none
SLOW = {"postproc/README.md": "draws for a minute"}  # by hand


def reason_to_leave_out(block):
    """Why a block is not run, None if it is: by the commands that it names outside comments."""
    code = re.sub(r"(^|\s)#.*", "", block)
    reasons = NOT_HERE if ALL else {**NOT_HERE, **BY_HAND}
    for name, reason in reasons.items():
        if re.search(rf"(?<![\w.-]){re.escape(name)}(?![\w.-])", code):
            return f"{name} {reason}"
    return None


@pytest.fixture(scope="session")
def clone(tmp_path_factory):
    """A home with a clone in which `./run.sh` has built."""
    home = tmp_path_factory.mktemp("home")
    subprocess.run(["git", "clone", "--quiet", "--no-hardlinks", PROJECT, home / "beamwave"], check=True)
    run(home, "./run.sh")
    return home


@pytest.fixture
def home(request):
    """A home whose folder `beamwave` is the tree as `./run.sh` leaves it."""
    return request.getfixturevalue("emptied_clone" if ALL else "copy")


@pytest.fixture
def emptied_clone(clone):
    """The clone, without what another document has left."""
    for result in (clone / "beamwave/output").iterdir():
        if result.name != "paper":
            shutil.rmtree(result) if result.is_dir() else result.unlink()
    return clone


@pytest.fixture
def copy(tmp_path, program, twin):
    """A copy of the tree with programs and a Python that are there already."""
    tree = tmp_path / "beamwave"
    left_out = {".git", "build", ".venv", "output"}
    shutil.copytree(PROJECT, tree, ignore=lambda folder, names: left_out & set(names) if Path(folder) == PROJECT else set())
    (tree / "build/bin").mkdir(parents=True)
    for built in filter(None, [program, twin]):
        (tree / "build/bin" / built.name).symlink_to(built)
    (tree / ".venv").symlink_to(sys.prefix)
    run(tmp_path, "build/bin/beamwave", "run", "input/paper", "--output", "output/paper", "--quiet")
    return tmp_path


def run(home, *command):
    """Run a command in the tree as a user would who has called `./run.sh`; return what it says."""
    own = {"VIRTUAL_ENV", "BEAMWAVE", "PYTHONPATH"}
    kept = {name: value for name, value in os.environ.items() if name not in own}
    bins = {str(Path(sys.prefix) / "bin")} - {"/usr/bin", "/usr/local/bin"}  # a virtual environment that ctest was called in
    path = [folder for folder in kept["PATH"].split(os.pathsep) if folder not in bins]
    cache = os.environ.get("XDG_CACHE_HOME", str(Path.home() / ".cache"))  # of fonts, which takes matplotlib seconds to make
    environment = {**kept, **MPI_ON_FEW_CORES, "HOME": str(home), "PATH": os.pathsep.join(path), "XDG_CACHE_HOME": cache}
    options = {"cwd": home / "beamwave", "env": environment, "stdin": subprocess.DEVNULL, "timeout": SECONDS}
    done = subprocess.run(command, capture_output=True, text=True, check=False, **options)
    assert done.returncode == 0, f"{done.stdout}\n{done.stderr}"
    return done.stdout


def with_blocks():
    """The documents that print commands or scenes."""
    return [name for name in all_documents() if any(blocks(text_of(name), language) for language in ("sh", "python", "fortran"))]


@pytest.mark.parametrize("document", with_blocks())
def test_its_commands_run_as_printed(document, home, twin):
    if document in SLOW and not ALL:
        pytest.skip(f"{SLOW[document]}; BEAMWAVE_DOCUMENTS=all runs it")
    text = text_of(document)
    script = []
    for block in blocks(text, "sh"):
        reason = reason_to_leave_out(block)
        if not reason and "beamwave-mpi" in block and twin is None:
            reason = "beamwave-mpi is not built here"
        print(f"{document}: not run: {reason}:\n{block}" if reason else f"{document}: run:\n{block}")
        script += [] if reason else [block]
    for scene in blocks(text, "fortran"):
        whole = scene if "&beam" in scene else BEAM + scene
        (home / "beamwave/scene.nml").write_text(whole, encoding="utf-8")  # as README.md asks for
        run(home, "build/bin/beamwave", "check", "scene.nml")
    run(home, "bash", "-euxc", "\n".join(script))
    if document in PYTHON_ELSEWHERE:
        print(f"{document}: its Python is not run: {PYTHON_ELSEWHERE[document]}")
    else:
        run(home, ".venv/bin/python", "-c", "\n".join(blocks(text, "python")))


@pytest.mark.parametrize("document", all_documents())
def test_every_block_says_its_language(document):
    """A command in a block without a language, or in an indented one, would not be run."""
    for token in tokens(text_of(document)):
        assert token.type != "code_block", token.content
        assert token.type != "fence" or token.info, token.content


def test_what_is_left_out_is_known_by_a_name_that_is_used():
    """A name in the lists that no document prints any more is taken off them."""
    printed = "\n".join(block for document in all_documents() for block in blocks(text_of(document), "sh"))
    for name in [*NOT_HERE, *BY_HAND]:
        assert name in printed, name


def test_the_reports_in_the_readme_are_what_the_program_prints(home):
    """Line by line; the table of `effects`, whose times differ, has a test of its own."""
    text = text_of("README.md")
    (home / "beamwave/scene.nml").write_text(blocks(text, "fortran")[0], encoding="utf-8")
    report = run(home, "build/bin/beamwave", "run", "scene.nml")
    shown = [line for block in blocks(text, "text") if "verdict" not in block for line in block.splitlines()]
    assert len(shown) > 5
    for line in shown:
        assert line in report.splitlines(), f"README.md shows, and the program does not print:\n{line}"
