"""File systems of a test's own."""

import shlex
import subprocess

import pytest
from workplace import SECONDS


def in_own_mounts(here, script):
    """Run a shell script that may mount, with `beamwave`; the mounts are gone when it ends."""
    for unshare in [["unshare", "--mount"], ["unshare", "--user", "--map-root-user", "--mount"]]:
        probe = [*unshare, "sh", "-c", "mkdir -p probe && mount -t tmpfs none probe"]
        if subprocess.run(probe, cwd=here.directory, capture_output=True, check=False).returncode == 0:
            words = " ".join(shlex.quote(str(word)) for word in here.command([]))
            script = f"beamwave() {{ {words} \"$@\"; }}\n{script}"
            return subprocess.run(
                [*unshare, "sh", "-c", script],
                cwd=here.directory,
                env=here.environment,
                capture_output=True,
                text=True,
                timeout=SECONDS,
                check=False,
            )
    pytest.skip("nothing can be mounted here: needs root, or namespaces for users")
