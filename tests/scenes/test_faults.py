"""A fault in the program ends with 70 and a request to report it, however it comes about; memory that is refused, and a stack that is
exhausted, with 3."""

import resource
import subprocess

import pytest


def end_of(request, directory, kind):
    return subprocess.run(
        [request.config.getoption("--faulty-program"), kind],
        capture_output=True,
        text=True,
        timeout=60,
        cwd=directory,
        check=False,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_CORE, (0, 0)),
    )


def test_an_allocation_that_is_refused_ends_with_3_and_says_so(request, tmp_path):
    ended = end_of(request, tmp_path, "bad-allocation")
    assert ended.returncode == 3, ended.stderr
    assert "not enough memory" in ended.stderr


def test_a_stack_that_is_exhausted_ends_with_3_and_says_so(request, tmp_path):
    ended = end_of(request, tmp_path, "full-stack")
    assert ended.returncode == 3, ended.stderr
    assert "the stack is exhausted" in ended.stderr
    assert "fault" not in ended.stderr


@pytest.mark.parametrize("kind", ["run-time-error", "segfault", "error-stop", "stop"])
def test_a_fault_ends_with_70_and_says_so(request, tmp_path, kind):
    ended = end_of(request, tmp_path, kind)
    assert ended.returncode == 70, ended.stderr
    assert "a fault in the program" in ended.stderr
    assert "please report it" in ended.stderr
