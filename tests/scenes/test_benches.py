"""The commands of bench/ run, and what the documents say of them is what was measured. No time is judged here."""

import importlib.util
import json
import subprocess
import sys
from pathlib import Path

import pytest

PROJECT = Path(__file__).parents[2]
BENCHES = ("peers", "contact", "growth", "effects", "price", "throughput", "sum", "records", "large_records")
sys.path.insert(0, str(PROJECT / "bench"))


@pytest.fixture(scope="module")
def small_run(program, tmp_path_factory):
    """Runs a bench in a small size, once: what it printed, its data, its directory."""
    known = {}

    def run(name):
        if name not in known:
            output = tmp_path_factory.mktemp(name)
            words = [sys.executable, "-m", "common", name, "--small", "--output", output, "--beamwave", program]
            ended = subprocess.run(words, cwd=PROJECT / "bench", capture_output=True, text=True, check=False)
            assert ended.returncode == 0, ended.stderr
            known[name] = ended.stdout, json.loads((output / f"{name}.json").read_text()), output
        return known[name]

    return run


def bench_of(name):
    return importlib.import_module(f"{name}.bench").BENCH


def written(mark):
    """The section of docs/numbers.md that begins with a mark."""
    return importlib.import_module("common.document").section(PROJECT / "docs/numbers.md", mark)


@pytest.mark.parametrize("name", BENCHES)
def test_a_small_size_runs_to_its_table_and_its_picture(small_run, name):
    _, measured, output = small_run(name)
    bench = bench_of(name)
    assert bench.text(measured) in (output / "numbers.md").read_text()
    if bench.draw:
        assert (output / bench.picture).read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize("name", BENCHES)
def test_the_document_holds_the_committed_numbers(name):
    bench = bench_of(name)
    measured = json.loads(bench.data().read_text(encoding="utf-8"))
    assert written(bench.first) == bench.text(measured), f"bench/{name}.sh --redraw writes it anew"


def test_the_document_opens_and_closes_with_what_the_committed_data_say():
    for mark, words in importlib.import_module("overview").sections().items():
        assert written(mark) == words.strip(), "python -m overview in bench/ writes it anew"


def test_the_flags_of_the_compiler_stand_once_in_the_document():
    flags = [line for line in (PROJECT / "docs/numbers.md").read_text(encoding="utf-8").splitlines() if "-march" in line]
    assert len(flags) == 1


def test_every_peer_is_measured_or_said_not_to_be(small_run):
    printed, measured, _ = small_run("peers")
    for peer in importlib.import_module("peers.bench").PEERS:
        rows = [row for row in measured["rows"] if row["peer"] == peer.name]
        if peer.missing():
            assert f"{peer.name}: not measured" in printed
        else:
            assert len(rows) == len(peer.sizes(small=True))


def test_beamwave_keeps_its_tolerance_against_the_independent_reference(small_run):
    _, measured, _ = small_run("peers")
    rows = [row for row in measured["rows"] if row["peer"] == "beamwave"]
    assert rows
    for row in rows:
        tolerance = float(row["setting"].removeprefix("tolerance "))  # over the tip's peak
        assert row["error"] <= 3 * tolerance  # over each point's own, the midpoint's is 0.4 of the tip's


def test_a_careful_sum_gains_digits_with_modes(small_run):
    _, measured, _ = small_run("peers")
    worse, better = (row["error"] for row in measured["rows"] if row["peer"] == "numpy, matrix products")
    assert better < worse / 5  # three times the modes; the tail falls with their square


def test_a_small_throughput_measures_every_part(small_run):
    _, measured, _ = small_run("throughput")
    parts = {row["part"] for row in measured["rows"]}
    assert parts | {"ranks"} == set(importlib.import_module("throughput.bench").PARTS)  # ranks: where there is MPI


def test_effects_are_counted_or_said_not_to_be(small_run):
    _, measured, output = small_run("effects")
    paper, shear = measured["rows"]
    assert (paper["method"], shear["method"]) == ("closed form", "pieces")
    if paper["instructions"] is None:  # no valgrind, or it does not know the instructions of this build
        assert "| – " in (output / "numbers.md").read_text()
    else:
        assert 0 < paper["instructions"] < shear["instructions"]


def test_both_sides_of_a_sum_keep_the_accuracy(small_run):
    _, measured, _ = small_run("sum")
    assert [row["tolerance"] for row in measured["rows"]] == [3e-11, 1e-12]
    for row in measured["rows"]:
        assert row["error"] <= row["tolerance"]
        if importlib.util.find_spec("finufft"):
            assert row["rival_error"] <= 10 * row["tolerance"]  # FINUFFT's bound is one of the mean square
        else:
            assert "rival_error" not in row
