"""A fault in the program ends with 70 and a request to report it, however it comes about."""

import resource
import subprocess

import pytest


@pytest.mark.parametrize("kind", ["run-time-error", "bad-allocation", "segfault", "error-stop", "stop"])
def test_a_fault_ends_with_70_and_says_so(request, tmp_path, kind):
    program = request.config.getoption("--faulty-program")
    ended = subprocess.run(
        [program, kind],
        capture_output=True,
        text=True,
        timeout=60,
        cwd=tmp_path,
        check=False,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_CORE, (0, 0)),
    )
    assert ended.returncode == 70, ended.stderr
    assert "a fault in the program" in ended.stderr
    assert "please report it" in ended.stderr
