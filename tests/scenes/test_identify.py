"""Records held against a beam: modes beside lines, unknown numbers of the beam, and the scene of what was identified.

The true frequencies are those of the closed forms of a cantilever with a mass at its tip, solved here.
"""

import re
import signal
import time

import numpy as np
import pytest
import results
from closed_form import roots
from drafts import files_in
from ring_downs import as_text
from scipy.optimize import brentq
from workplace import SECONDS, namelist

LENGTH, DENSITY, HEIGHT, WIDTH = 0.6, 2700.0, 0.006, 0.03  # an aluminium beam
MODULUS, MASS = 68.4e9, 0.047
RATE, SAMPLES, NOISE = 2000.0, 2048, 0.02
DECAYS = np.array([0.6, 2.0, 4.0, 8.0])  # 1/s
BEAM = {"length": LENGTH, "density": DENSITY, "width": WIDTH, "height": HEIGHT}
UNKNOWN = {"parameter": "beam%youngs_modulus", "first": 50e9, "last": 90e9}
MORE = {"parameter": "body%mass", "first": 0.01, "last": 0.3, "with": "alone.nml"}
WIDE = 2.0  # intervals of 95 %: four standard deviations, and the seeds are fixed


def frequencies(ratio=0.0, modulus=MODULUS):
    """Undamped angular frequencies, rad/s."""
    return np.sqrt(modulus * HEIGHT**2 / 12 / DENSITY) * (roots(4, ratio) / LENGTH) ** 2


def ring_down(seed, beta, foreign=None):
    """A record of the modes, with a tone that is none where one is asked for."""
    dice = np.random.default_rng(seed)
    time = np.arange(SAMPLES) / RATE
    damped = np.sqrt(beta**2 - DECAYS**2)
    values = (np.exp(-np.outer(DECAYS, time)) * np.cos(np.outer(damped, time) + dice.uniform(0, 6, (4, 1)))).sum(axis=0)
    if foreign:
        values += 0.5 * np.cos(2 * np.pi * foreign * time)
    return as_text(time, (values + NOISE * dice.standard_normal(SAMPLES))[None, :], "time [s],tip [m]")


def scene_of(record, unknowns=(), **groups):
    """A scene as text: f90nml's way for groups that repeat."""
    scene = {"beam": BEAM, **groups, "record": {"file": record}, "spectrum": {}}
    return namelist(scene) + "".join(namelist({"identify": unknown}) for unknown in unknowns)


RATIO = MASS / (DENSITY * WIDTH * HEIGHT * LENGTH)


@pytest.fixture(scope="module")
def together(shared):
    """The beam alone and the beam with a mass, fitted together."""
    here = shared("together")
    here.write("alone.csv", ring_down(1, frequencies()))
    here.write("loaded.csv", ring_down(2, frequencies(RATIO), foreign=333.0))
    here.write("alone.nml", scene_of("alone.csv", beam={**BEAM, "youngs_modulus": 70e9}))
    here.write("loaded.nml", scene_of("loaded.csv", [UNKNOWN, MORE], body={"mass": 0.1, "position": 1.0}))
    return here, here.run("loaded")


def test_unknowns_of_two_states_are_inside_their_intervals(together):
    _, result = together
    found, error = result["identified"], result["identified_error"]
    assert [str(name).strip() for name in result["identified_parameter"]] == ["beam%youngs_modulus", "body%mass"]
    assert [str(unit).strip() for unit in result["identified_unit"]] == ["Pa", "kg"]
    assert (abs(found - [MODULUS, MASS]) < WIDE * error).all()
    assert (error < np.array([1e-3, 1e-2]) * found).all()
    assert ((result["identified_low"] < found) & (found < result["identified_high"])).all()
    correlation = result["identified_correlation"]
    assert np.diag(correlation).tolist() == pytest.approx([1, 1])
    assert correlation[0, 1] == pytest.approx(correlation[1, 0])
    assert result["misfit_freedom"] == 6
    assert result["misfit_probability"] > 1e-3


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGKILL])
def test_a_result_has_its_name_only_with_what_was_identified(here, together, number):
    """Wherever the run is ended after its lines were written: the draft lies there while the fit is under way."""
    _, whole = together
    for name in ["alone", "loaded"]:
        for kind in ["csv", "nml"]:
            here.write(f"{name}.{kind}", (together[0].directory / f"{name}.{kind}").read_text(encoding="utf-8"))
    work, ended = here.directory / "output/loaded.partial", 0
    for delay in [0, 0.01, 0.02, 0.04]:
        running = here.start("run", "loaded.nml", "--overwrite")
        until = time.perf_counter() + SECONDS
        while not files_in(work, ".nc") and running.poll() is None and time.perf_counter() < until:
            time.sleep(0.0005)
        time.sleep(delay)
        running.send_signal(number)
        _, err = running.communicate(timeout=SECONDS)
        if "loaded.nc" in here.left():
            assert "identified" in here.result("loaded").variables
            (here.directory / "output/loaded.nc").unlink()
            continue
        ended += 1
        assert running.returncode == (-number if number == signal.SIGKILL else 5), err
    assert ended > 0
    assert results.differences(here.run("loaded"), whole) == []
    assert "loaded.partial" not in here.left()


def test_a_tone_that_is_no_mode_is_left_out(together):
    _, result = together
    mode = result["peak_mode"][: result["peak_count"]]
    assert sorted(mode) == [0, 1, 2, 3, 4]
    lone = result["measured_angular_frequency"][: len(mode)][mode == 0]
    assert lone / (2 * np.pi) == pytest.approx([333.0], abs=0.01)


def test_the_result_of_the_other_state_is_there_too(together):
    here, _ = together
    alone = here.result("alone")
    true = np.sqrt(frequencies(modulus=70e9) ** 2 - alone["measured_decay_rate"][:4] ** 2)
    assert alone["peak_count"] == 4
    assert "peak_mode" not in alone.variables
    assert (abs(alone["measured_angular_frequency"][:4] / true - np.sqrt(MODULUS / 70e9)) < 1e-4).all()


def test_the_other_state_is_compared_where_it_is_run_itself(together):
    here, _ = together
    before = here.result("alone")
    for _ in range(2):
        ended = here.beamwave("run", "alone.nml")
        assert ended.returncode == 0 and "Lines beside the modes" in ended.stdout
    assert "nothing to do" in ended.stdout
    alone = here.result("alone")
    assert alone["peak_mode"][:4].tolist() == [1, 2, 3, 4]
    assert alone["measured_angular_frequency"].tolist() == before["measured_angular_frequency"].tolist()
    assert "nothing to do" in here.beamwave("run", "loaded.nml").stdout


def test_the_identified_scene_runs(together):
    here, result = together
    for name in ["loaded.identified", "loaded.identified.alone"]:
        scene = (here.directory / "output" / f"{name}.nml").read_text(encoding="utf-8")
        assert "&record" not in scene and "&identify" not in scene
        assert "as the result loaded.nc identified it" in scene.splitlines()[0]
    assert here.beamwave("run", "output/loaded.identified.nml").returncode == 0
    again = here.result("loaded.identified")
    line = result["peak_mode"][: result["peak_count"]] > 0
    computed = result["modelled_angular_frequency"][: line.size][line]
    decay = result["measured_decay_rate"][: line.size][line]
    undamped = np.hypot(again["angular_frequency"], again["growth_rate"])[:4]  # it has the damping of the lines
    np.testing.assert_allclose(np.hypot(computed, decay), undamped, rtol=1e-12)


def test_the_identified_scene_has_the_damping_that_was_measured(here):
    """All modes have the ratio 0.005, to the accuracy that noise leaves."""
    beta, ratio = frequencies(), 0.005
    time = np.arange(SAMPLES) / RATE
    values = sum(np.exp(-ratio * b * time) * np.cos(np.sqrt(1 - ratio**2) * b * time + i) for i, b in enumerate(beta))
    noise = NOISE * np.random.default_rng(13).standard_normal(SAMPLES)
    here.write("ring.csv", as_text(time, (values + noise)[None, :], "time [s],tip [m]"))
    here.write("ring.nml", scene_of("ring.csv", [UNKNOWN]))
    assert here.beamwave("run", "ring.nml").returncode == 0
    scene = (here.directory / "output" / "ring.identified.nml").read_text(encoding="utf-8")
    assert "&modes" not in scene  # 20 modes are those of a scene of frequencies: a motion that is added takes its own
    said = re.search(r"! damping%ratio = (\S+): (\S+) to (\S+), from the decay of 4 lines", scene)
    assert float(said[2]) < ratio < float(said[3])
    assert float(said[3]) - float(said[2]) < 0.05 * ratio
    assert here.beamwave("run", "output/ring.identified.nml").returncode == 0
    assert here.result("ring.identified")["damping_ratio"] == pytest.approx(float(said[1]), rel=1e-5)
    here.write("damped.nml", scene_of("ring.csv", [UNKNOWN], damping={"ratio": 0.02}))  # the user's own number stays
    here.beamwave("run", "damped.nml")
    scene = (here.directory / "output" / "damped.identified.nml").read_text(encoding="utf-8")
    assert scene.count("&damping") == 1 and "ratio = 0.02" in scene


def test_where_no_line_is_a_mode_nothing_is_identified(here):
    """Times in ms under a header without a unit: all lines are a thousand times too low."""
    rows = ring_down(14, frequencies()).splitlines()[1:]
    rows = [row.split(",") for row in rows]
    here.write("ring.csv", "time,tip\n" + "".join(f"{float(t) * 1e3!r},{x}\n" for t, x in rows))
    here.write("ring.nml", scene_of("ring.csv", [UNKNOWN]).replace("&record", "&record\n time_scale = 1e-3"))
    assert here.beamwave("run", "ring.nml").returncode == 0
    stale = here.directory / "output" / "ring.identified.nml"
    assert stale.exists()
    here.write("ring.nml", scene_of("ring.csv", [UNKNOWN]))
    ended = here.beamwave("run", "ring.nml", "--overwrite", status=4)
    said = re.search(r"misfit: no line is a mode of the beam: .* if frequencies were (\S+) times as high, 4 of 4", ended.stderr)
    assert float(said[1]) == pytest.approx(1e3, rel=0.05)  # the modulus is not known to 30 %
    assert "record%time_scale = 1e-3" in ended.stderr
    assert "Frequencies are off by" not in ended.stdout and "Identified;" not in ended.stdout
    assert not stale.exists()
    result = here.result("ring")
    assert (result["peak_mode"][: result["peak_count"]] == 0).all()
    for name in ["identified", "identified_low", "identified_high", "identified_error", "model_scatter"]:
        assert results.is_fill(result[name]).all()
    meanings = result.variables["case_status"].attributes["flag_meanings"].split()
    assert meanings[int(result["case_status"])] == "misfit"


OWN, ALONE = "output/loaded.identified.nml", "output/loaded.identified.alone.nml"


def identified(here, together):
    """The two states in a workplace of their own, with the result that is there, and its identified scenes."""
    there, _ = together
    (here.directory / "output").mkdir()
    for name in ["alone.csv", "alone.nml", "loaded.csv", "loaded.nml", "output/loaded.nc", "output/alone.nc"]:
        (here.directory / name).write_bytes((there.directory / name).read_bytes())
    ended = here.beamwave("run", "loaded.nml")
    assert ended.returncode == 0 and "nothing to do" in ended.stdout
    return {path: (here.directory / path).read_bytes() for path in [OWN, ALONE]}


def test_an_identified_scene_is_made_again_where_its_result_is_there(here, together):
    texts = identified(here, together)
    assert texts == {path: (together[0].directory / path).read_bytes() for path in texts}
    for path in texts:
        (here.directory / path).unlink()
        before = (here.directory / "output/loaded.nc").stat().st_mtime_ns
        assert here.beamwave("run", "loaded.nml").returncode == 0
        assert (here.directory / path).read_bytes() == texts[path]
        assert (here.directory / "output/loaded.nc").stat().st_mtime_ns == before
        assert sorted(here.left()) == sorted(["alone.nc", "loaded.nc", *(name.split("/")[1] for name in texts)])


@pytest.mark.parametrize("path", [OWN, ALONE])
@pytest.mark.parametrize("there", ["another file", "link", "hard link", "directory"])
def test_what_is_not_this_result_s_is_kept_unless_it_may_be_replaced(here, together, path, there):
    texts = identified(here, together)
    mine, place = here.directory / "mine.txt", here.directory / path
    mine.write_text("nobody else's")
    place.unlink()
    if there == "directory":
        place.mkdir()
    elif there == "another file":
        place.write_text("nobody else's")
    else:
        (place.hardlink_to if there == "hard link" else place.symlink_to)(mine)
    ended = here.beamwave("run", "loaded.nml", status=3)
    assert "nothing to do" in ended.stdout, "the result itself is reported all the same"
    assert [line.split(":")[0] for line in ended.stderr.splitlines()] == [path]
    assert there == "directory" or "--overwrite replaces it" in ended.stderr and place.read_text() == "nobody else's"
    ended = here.beamwave("run", "loaded.nml", "--overwrite", status=3 if there == 'directory' else 0)
    assert there == "directory" or place.read_bytes() == texts[path] and not place.is_symlink()
    assert mine.read_text() == "nobody else's"
    assert not list((here.directory / "output").glob("*.partial"))


def test_two_results_share_no_identified_scene(here, together):
    """The same beam alone beside two others; and what it identifies itself is a third."""
    texts = identified(here, together)
    here.write("heavy.csv", ring_down(9, frequencies(2 * RATIO)))
    here.write("heavy.nml", scene_of("heavy.csv", [UNKNOWN, MORE], body={"mass": 0.1, "position": 1.0}))
    here.run("heavy")
    for path, text in texts.items():
        assert (here.directory / path).read_bytes() == text
        assert b"as the result heavy.nc identified it" in (here.directory / path.replace("loaded", "heavy")).read_bytes()


def test_a_further_scene_may_have_unknowns_of_its_own(here):
    """The beam alone was clamped at a length that is known to 1 cm only; with the mass its length is known."""
    here.write("alone.csv", ring_down(1, frequencies()))
    here.write("loaded.csv", ring_down(2, frequencies(RATIO)))
    own = {"parameter": "beam%length", "first": 0.59, "last": 0.61}
    here.write("alone.nml", scene_of("alone.csv", [own], beam={**BEAM, "length": 0.608, "youngs_modulus": 70e9}))
    here.write("loaded.nml", scene_of("loaded.csv", [UNKNOWN, MORE], body={"mass": 0.1, "position": 1.0}))
    result = here.run("loaded")
    found, error = result["identified"], result["identified_error"]
    names = [str(name).strip() for name in result["identified_parameter"]]
    assert names == ["beam%youngs_modulus", "body%mass", "beam%length (alone)"]
    assert (abs(found - [MODULUS, MASS, LENGTH]) < WIDE * error).all()
    assert error[2] < 1e-3
    assert result["misfit_freedom"] == 5
    assert result["identified_first"].tolist() == [50e9, 0.01, 0.59]
    scenes = [(here.directory / f"output/loaded.identified{name}.nml").read_text() for name in ["", ".alone"]]
    lengths = [line for scene in scenes for line in scene.splitlines() if "length" in line]
    assert float(lengths[0].split("=")[1]) == LENGTH
    assert float(lengths[-1].split("=")[1]) == found[2]


def test_check_reads_the_records_of_further_scenes_too(here, together):
    there, _ = together
    said = there.beamwave("check", "loaded.nml").stdout
    assert "with       ./alone.nml" in said and "alone.csv: 2048 samples" in said.split("with       ./alone.nml")[1]
    here.write("loaded.csv", ring_down(2, frequencies(RATIO)))
    here.write("loaded.nml", scene_of("loaded.csv", [UNKNOWN, MORE], body={"mass": 0.1, "position": 1.0}))
    here.write("alone.nml", scene_of("nowhere.csv", beam={**BEAM, "youngs_modulus": 70e9}))
    ended = here.beamwave("check", "loaded.nml")
    assert ended.returncode == 3 and "nowhere.csv: cannot be read" in ended.stderr


def test_a_second_run_has_nothing_to_do_until_a_further_record_is_another(together):
    here, _ = together
    again = here.beamwave("run", "loaded.nml")
    assert again.returncode == 0 and "nothing to do" in again.stdout and "Identified" in again.stdout
    here.write("alone.csv", ring_down(7, frequencies()))
    assert here.beamwave("run", "loaded.nml").returncode == 3
    assert here.beamwave("run", "loaded.nml", "--overwrite").returncode == 0
    assert here.result("loaded")["identified"][0] == pytest.approx(MODULUS, rel=1e-3)


def test_modes_stand_beside_lines_where_nothing_is_unknown(here):
    here.write("ring.csv", ring_down(3, frequencies()))
    here.write("ring.nml", scene_of("ring.csv", beam={**BEAM, "youngs_modulus": MODULUS}, damping={"ratio": 0.003}))
    result = here.run("ring")
    beta = frequencies()
    assert result["peak_mode"][:4].tolist() == [1, 2, 3, 4]
    assert results.is_fill(result["modelled_angular_frequency"][4:]).all()
    decay = result["measured_decay_rate"][:4]
    np.testing.assert_allclose(result["modelled_angular_frequency"][:4], np.sqrt(beta**2 - decay**2), rtol=1e-11)
    np.testing.assert_allclose(result["modelled_decay_rate"][:4], 0.003 * beta, rtol=1e-11)
    away = (result["measured_angular_frequency"] - result["modelled_angular_frequency"])[:4]
    np.testing.assert_allclose(result["frequency_misfit"][:4], away / result["measured_angular_frequency_error"][:4], rtol=1e-6)
    assert (abs(result["frequency_misfit"][:4]) < WIDE).all()
    away = decay - 0.003 * beta
    np.testing.assert_allclose(result["decay_misfit"][:4], away / result["measured_decay_rate_error"][:4], rtol=1e-6)
    assert result["misfit_probability"] > 1e-3


def test_a_wrong_model_is_told_so_with_what_would_mend_it(here):
    """A mass at the tip that nobody told of; a root that turns has the same frequencies."""
    here.write("ring.csv", ring_down(4, frequencies(RATIO)))
    here.write("ring.nml", scene_of("ring.csv", [UNKNOWN]))
    ended = here.beamwave("run", "ring.nml", status=4)
    assert "misfit: the model does not explain the lines" in ended.stderr
    advice = ended.stdout.split("Fitted again with an effect that the model leaves out")[1].splitlines()[1:]
    assert all("explains the lines" in line for line in advice[:2])
    assert {"a mass at the tip", "a root that turns"} == {line.split("%   ")[1].split(" (")[0] for line in advice[:2]}
    mass = next(line for line in advice if "a mass at the tip" in line).split("body%mass = ")[1].split(" kg")[0]
    assert float(mass) == pytest.approx(MASS, rel=0.01)
    assert here.result("ring")["misfit_probability"] < 1e-3
    here.write("again.csv", ring_down(11, frequencies(RATIO)))
    here.write("given.nml", scene_of(["ring.csv", "again.csv"], beam={**BEAM, "youngs_modulus": MODULUS}))
    corrections = here.beamwave("run", "given.nml", "--verbose").stdout.split("Fitted again with an effect that the model leaves out")[1:]
    assert len(corrections) == 2  # one for each repeat
    assert all("a mass at the tip (body%mass = 0.0" in text and "explains the lines" in text for text in corrections)


def test_two_effects_at_once_are_found_where_neither_explains_the_lines(here):
    """A root that turns and a mass at the tip: of a shape a (cos − cosh) + b sin + c sinh, which the root ties to its slope."""
    turning, stiffness = 2e3, MODULUS * WIDTH * HEIGHT**3 / 12

    def equation(alpha):
        a, c, s, ch, sh = turning * LENGTH / stiffness / (2 * alpha), np.cos(alpha), np.sin(alpha), np.cosh(alpha), np.sinh(alpha)
        moment = np.array([a * (c + ch) - s, a * (c + ch) + sh])
        shear = np.array([-a * (s - sh) - c, -a * (s - sh) + ch]) / alpha
        moved = np.array([-a * (c - ch) + s, -a * (c - ch) + sh])
        tip = shear + RATIO * moved
        return moment[0] * tip[1] - moment[1] * tip[0]

    grid = np.linspace(0.5, 12, 4000)
    signs = np.sign([equation(alpha) for alpha in grid])
    roots = [brentq(equation, grid[i], grid[i + 1]) for i in np.flatnonzero(np.diff(signs))[:4]]
    here.write("ring.csv", ring_down(21, np.sqrt(MODULUS * HEIGHT**2 / 12 / DENSITY) * (np.array(roots) / LENGTH) ** 2))
    here.write("ring.nml", scene_of("ring.csv", beam={**BEAM, "youngs_modulus": MODULUS}))
    advice = here.beamwave("run", "ring.nml").stdout.split("Fitted again with an effect that the model leaves out")[1].splitlines()[1:]
    both = next(line for line in advice if "a root that turns" in line and "a mass at the tip" in line)
    assert both.endswith("explains the lines")
    assert float(re.search(r"body%mass = (\S+) kg", both)[1]) == pytest.approx(MASS, rel=0.01)
    assert float(re.search(r"rotational_stiffness = (\S+) N", both)[1]) == pytest.approx(turning, rel=0.01)
    alone = [line for line in advice if line.split("%   ")[-1].startswith(("a root that turns (", "a mass at the tip ("))]
    assert len(alone) == 2
    assert not any("explains the lines" in line for line in alone)


def test_as_many_unknowns_as_lines_do_not_hide_a_misfit(here):
    """No uniform beam has these lines, whatever its root, its tip and its material."""
    here.write("ring.csv", ring_down(9, frequencies() * [1, 1.3, 1, 0.8]))
    unknowns = [UNKNOWN, {"parameter": "support%rotational_stiffness", "first": 10, "last": 1e6}]
    unknowns += [{"parameter": "body%mass", "first": 0.001, "last": 1}, {"parameter": "beam%height", "first": 0.004, "last": 0.008}]
    here.write("ring.nml", scene_of("ring.csv", unknowns, support={}, body={"position": 1.0}))
    ended = here.beamwave("run", "ring.nml", status=4)
    assert "misfit: the model does not explain the lines: chi squared is" in ended.stderr
    result = here.result("ring")
    assert result["misfit_probability"] < 1e-12
    meanings = result.variables["case_status"].attributes["flag_meanings"].split()
    assert meanings[int(result["case_status"])] == "misfit"
    assert result["model_scatter"] > 0.05
    assert (result["identified_error"] > 0.05 * result["identified"]).all()  # they hold what the model is off by


def test_an_unknown_at_the_end_of_its_range_has_no_interval_there(here):
    """The modulus is below the range: the frequencies are those of its end, 1.2 % off, and it fits no line."""
    here.write("ring.csv", ring_down(10, frequencies()))
    here.write("ring.nml", scene_of("ring.csv", [{**UNKNOWN, "first": 70e9}]))
    ended = here.beamwave("run", "ring.nml", status=4)
    assert "beam%youngs_modulus is at the end of its range" in ended.stderr
    result = here.result("ring")
    assert result["identified"][0] == pytest.approx(70e9, rel=1e-12)
    assert results.is_fill(result["identified_low"]).all() and results.is_fill(result["identified_error"]).all()
    assert 70e9 < result["identified_high"][0] < 75e9
    assert result["misfit_freedom"] == 4
    assert result["model_scatter"] == pytest.approx(1 - np.sqrt(MODULUS / 70e9), rel=0.1)


def test_lines_that_are_taken_for_no_modes_count_against_the_model(here):
    """Between the lines of the beam there are others that decay like them: some may be no modes of it, not as many."""
    beta = frequencies()
    for name, others in [("few", [180.0]), ("many", [180.0, 300.0, 420.0, 700.0, 1000.0])]:
        time = np.arange(SAMPLES) / RATE
        values = sum(np.exp(-2 * time) * np.cos(b * time + i) for i, b in enumerate([*beta, *others]))
        noise = NOISE * np.random.default_rng(12).standard_normal(SAMPLES)
        here.write(f"{name}.csv", as_text(time, (values + noise)[None, :], "time [s],tip [m]"))
        here.write(f"{name}.nml", scene_of(f"{name}.csv", beam={**BEAM, "youngs_modulus": MODULUS}))
        assert here.beamwave("run", f"{name}.nml").returncode == 0  # nothing was identified
        result = here.result(name)
        aside = (result["peak_mode"][: result["peak_count"]] == 0).sum()
        assert aside == len(others)
        assert 4 < result["misfit_freedom"] <= 4 + aside  # what hardly is a mode does not count
        assert (result["misfit_probability"] > 1e-3) == (name == "few")


def test_repeats_are_fitted_together(here):
    for seed in [5, 6]:
        here.write(f"ring_{seed}.csv", ring_down(seed, frequencies()))
    here.write("both.nml", scene_of(["ring_5.csv", "ring_6.csv"], [UNKNOWN]))
    here.write("one.nml", scene_of("ring_5.csv", [UNKNOWN]))
    both, one = here.run("both"), here.run("one")
    assert both["peak_mode"].shape[0] == 2
    assert both["identified"].shape == (1,)
    assert abs(both["identified"][0] - MODULUS) < WIDE * both["identified_error"][0]
    assert both["identified_error"][0] < 0.9 * one["identified_error"][0]
    assert both["misfit_freedom"] == 7


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        ("missing.nml", None, "missing.nml"),
        ("plain.nml", "&beam length=1 density=1 youngs_modulus=1e9 diameter=0.1 /", "has no &record"),
        ("more.nml", scene_of("ring.csv", [{**UNKNOWN, "with": "x.nml"}]), "more.nml names further scenes itself"),
    ],
)
def test_a_further_scene_that_is_none_of_a_record_is_refused(here, name, text, said):
    here.write("ring.csv", ring_down(8, frequencies()))
    if text:
        here.write(name, text)
    here.write("ring.nml", scene_of("ring.csv", [{**UNKNOWN, "with": name}]))
    ended = here.beamwave("run", "ring.nml", status=2 if text else 3)
    assert said in ended.stderr
    assert not (here.directory / "output" / "ring.nc").exists()
