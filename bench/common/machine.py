"""Where something was measured: processor, operating system, compiler with its flags, packages."""

from __future__ import annotations

import platform
import re
import subprocess
import time
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path


def processor() -> str:
    """The processor's name."""
    try:
        names = re.findall(r"^model name\s*: (.*)$", Path("/proc/cpuinfo").read_text(), re.MULTILINE)
    except OSError:
        names = []
    return names[0] if names else platform.machine()


def built_with(program: Path) -> dict[str, str]:
    """What `beamwave --version` says of itself, and the flags that its build wrote down."""
    said = subprocess.run([program, "--version"], capture_output=True, text=True, check=True).stdout.splitlines()
    about = {"program": "; ".join(" ".join(line.split()) for line in said if line.strip())}
    noted = program.parents[1] / "bench/compiler.txt"
    if noted.is_file():
        compiler, flags = noted.read_text().splitlines()[:2]
        about.update(compiler=compiler, flags=f"`{flags}`")
    return about


def packages(names: tuple[str, ...]) -> str:
    """Versions of those that are installed."""
    found = []
    for name in names:
        try:
            found.append(f"{name} {version(name)}")
        except PackageNotFoundError:
            continue
    return ", ".join(found)


def describe(program: Path, names: tuple[str, ...]) -> dict[str, str]:
    """All of it, in the order of the table."""
    python = {"Python": f"{platform.python_version()}, {packages(names)}"} if names else {}
    machine = f"{processor()}, {platform.system()}, one thread"
    return {"machine": machine, **built_with(program), **python, "date": time.strftime("%Y-%m-%d")}
