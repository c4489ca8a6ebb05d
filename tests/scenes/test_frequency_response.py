"""Answers to a harmonic force in whole runs, against a closed form, sums of thousands of modes and finite elements."""

import numpy as np
import pytest
import results
from closed_form import roots
from scipy.linalg import eigh
from scipy.optimize import brentq, minimize_scalar
from workplace import PAPER_BEAM, namelist

MASS = PAPER_BEAM["density"] * np.pi / 4 * PAPER_BEAM["diameter"] ** 2  # kg/m
STIFFNESS = PAPER_BEAM["youngs_modulus"] * np.pi / 64 * PAPER_BEAM["diameter"] ** 4  # N m2; the beam is 1 m long
ASKED = {"first": 3.0, "last": 2000.0, "count": 400}


def scene(asked=None, **groups):
    return {"beam": dict(PAPER_BEAM), **groups, "frequency_response": {**ASKED, **(asked or {})}}


def answer(result):
    return result["frequency_response_real"] + 1j * result["frequency_response_imag"]


def tip_of_cantilever(frequency, loss=0.0, mass_proportional=0.0):
    """Receptance of the tip in closed form, at a complex wave number."""
    omega = 2 * np.pi * frequency
    stiffness = STIFFNESS * (1 + 1j * omega * loss)
    a = ((omega**2 - 1j * omega * mass_proportional) * MASS / stiffness) ** 0.25
    return (np.sin(a) - np.cos(a) * np.tanh(a)) / (a**3 * (1 / np.cosh(a) + np.cos(a))) / stiffness


def frequencies_of_cantilever(count):
    """β of its modes, rad/s."""
    return roots(count, 0.0) ** 2 * np.sqrt(STIFFNESS / MASS)


@pytest.mark.parametrize("quantity", ["displacement", "velocity", "acceleration"])
def test_a_cantilever_answers_as_its_closed_form_says(here, quantity):
    damping = {"mass_proportional": 2.0, "stiffness_proportional": 1e-6}
    result = here.simulate("a", scene({"quantity": quantity}, damping=damping))
    order = ["displacement", "velocity", "acceleration"].index(quantity)
    frequency = result["response_frequency"]
    np.testing.assert_allclose(frequency, np.geomspace(3.0, 2000.0, 400), rtol=1e-13)
    expected = (2j * np.pi * frequency) ** order * tip_of_cantilever(frequency, 1e-6, 2.0)
    np.testing.assert_allclose(answer(result)[0], expected, rtol=1e-10)
    unit = ["m N-1", "m s-1 N-1", "m s-2 N-1"][order]
    assert result.variables["frequency_response_real"].attributes["units"] == unit
    assert "frequency_response_error" not in result.variables


def test_an_undamped_answer_is_real(here):
    result = here.simulate("a", scene())
    np.testing.assert_allclose(answer(result)[0].real, tip_of_cantilever(result["response_frequency"]).real, rtol=1e-9)
    assert np.abs(answer(result).imag).max() <= 1e-12 * np.abs(answer(result)).max()


def test_a_ratio_of_damping_has_the_answer_of_thousands_of_modes(here):
    result = here.simulate("a", scene(damping={"ratio": 0.02}))
    omega = 2 * np.pi * result["response_frequency"][:, np.newaxis]
    beta = frequencies_of_cantilever(5000)
    expected = (4 / MASS / (beta**2 - omega**2 + 0.04j * beta * omega)).sum(axis=1)
    off = np.abs(answer(result)[0] - expected).max()
    error = result["frequency_response_error"][0]
    # modes beyond 5000 add less than 1e-11 of the largest value
    assert off <= error + 1e-11 * np.abs(expected).max()
    assert error <= 1e-6 * np.abs(expected).max()


def elements(speed, hub_radius, count=80):
    """Inertia, elastic stiffness and that of the tension of a cantilever in cubic elements; its root is held."""
    h = 1.0 / count
    inertia, elastic, tension = np.zeros((3, 2 * count + 2, 2 * count + 2))
    bending = np.array([[12, 6 * h, -12, 6 * h], [6 * h, 4 * h**2, -6 * h, 2 * h**2]])
    bending = np.vstack([bending, -bending[0], [6 * h, 2 * h**2, -6 * h, 4 * h**2]]) * STIFFNESS / h**3
    weights = np.array([[156, 22 * h, 54, -13 * h], [22 * h, 4 * h**2, 13 * h, -3 * h**2], [54, 13 * h, 156, -22 * h]])
    weights = np.vstack([weights, [-13 * h, -3 * h**2, -22 * h, 4 * h**2]]) * MASS * h / 420
    nodes, gauss = np.polynomial.legendre.leggauss(6)
    for e in range(count):
        at = slice(2 * e, 2 * e + 4)
        inertia[at, at] += weights
        elastic[at, at] += bending
        for node, weight in zip((nodes + 1) / 2, gauss / 2):
            slope = np.array([6 * (node**2 - node) / h, 1 - 4 * node + 3 * node**2, 6 * (node - node**2) / h, 3 * node**2 - 2 * node])
            x = (e + node) * h
            pull = MASS * speed**2 * (hub_radius * (1 - x) + (1 - x**2) / 2)
            tension[at, at] += weight * h * pull * np.outer(slope, slope)
    return inertia[2:, 2:], elastic[2:, 2:], tension[2:, 2:]


@pytest.mark.parametrize("plane", ["in", "out"])
def test_tension_has_the_answer_of_finite_elements(here, plane):
    rotation = {"angular_velocity": 90.0, "plane": plane}
    groups = {"rotation": rotation, "stiffening": {"hub_radius": 0.2}, "damping": {"mass_proportional": 5.0}}
    result = here.simulate("a", scene({"points": [0.5, 1.0], "position": 0.75, "last": 1000.0}, **groups))
    inertia, elastic, tension = elements(90.0, 0.2)
    stiffness = elastic + tension - (90.0**2 * inertia if plane == "in" else 0)
    square, shapes = eigh(stiffness, inertia)  # damping of the mass leaves modes as they are
    omega = 2 * np.pi * result["response_frequency"]
    force, places = 2 * 60 - 2, [2 * 40 - 2, 2 * 80 - 2]
    terms = shapes[force] / (square - omega[:, np.newaxis] ** 2 + 5j * omega[:, np.newaxis])
    expected = (terms @ shapes[places].T).T
    largest = np.abs(expected).max(axis=1)
    off = np.abs(answer(result) - expected).max(axis=1)
    error = result["frequency_response_error"]
    assert (off <= error + 5e-5 * largest).all()  # (kh)^4/720 in the square of mode 5, times the height of its resonance
    assert (error <= 1e-4 * largest).all()


def test_the_captured_mass_is_on_the_beam(here):
    groups = {"impact": {"mass_ratio": 0.2}, "capture": {}, "damping": {"mass_proportional": 1.0}}
    here.scene("captured", scene(**groups))
    carried = {"body": {"position": 1.0, "mass_ratio": 0.2}, "damping": {"mass_proportional": 1.0}}
    np.testing.assert_allclose(answer(here.run("captured")), answer(here.simulate("carried", scene(**carried))), rtol=1e-9)


def test_histories_and_answers_have_the_same_points(here):
    response = {"duration": 0.1, "samples": 64, "points": [0.3, 0.8]}
    both = scene(impact={"mass_ratio": 0.2}, capture={}, modes={"after": 10}, response=response)
    result = here.simulate("a", both)
    np.testing.assert_array_equal(result["point_position"], [0.3, 0.8])
    assert answer(result).shape == (2, 400)
    # what it resolved to is a scene with the same answer
    here.write("again.nml", result.attributes["scene"])
    np.testing.assert_array_equal(answer(here.run("again")), answer(result))
    both["frequency_response"]["points"] = [0.3, 0.9]
    ended = here.beamwave("run", here.write("other.nml", namelist(both)), status=2)
    assert "frequency_response%points: are not those of &response" in ended.stderr


def pinned_frequencies(count):
    """Hz, of a beam that is clamped and pinned, as the tip is where it rests under a force: tan a = tanh a."""
    a = [brentq(lambda a: np.tan(a) - np.tanh(a), n * np.pi + 0.1, n * np.pi + 1.0, xtol=1e-14) for n in range(1, count + 1)]
    return np.array(a) ** 2 * np.sqrt(STIFFNESS / MASS) / 2 / np.pi


def reported(here):
    """Rows of resonances, and antiresonances, of the scene's report."""
    table = here.beamwave("run", "a.nml").stdout.split("response to a harmonic force")[1].split("\n\n")[0]
    rows = [line.split() for line in table.splitlines()[3:]]
    return [row[1:] for row in rows if len(row) == 4], [float(row[1]) for row in rows if len(row) == 2]


def peak_of(size, near, width):
    """The largest value of a function next to a frequency, and where half of its square is left on both sides."""
    found = minimize_scalar(lambda f: -size(f), bounds=(near - width, near + width), method="bounded", options={"xatol": 1e-9 * near})
    half = size(found.x) / np.sqrt(2)
    return found.x, -found.fun, [brentq(lambda f: size(f) - half, *sorted((found.x, found.x + way * width))) for way in (-2, 2)]


@pytest.mark.parametrize("count", [2, 30, 5000])
@pytest.mark.parametrize("quantity", ["displacement", "velocity", "acceleration"])
def test_resonances_do_not_depend_on_the_frequencies_that_are_asked_for(here, quantity, count):
    loss, drag = 3e-6, 3.0
    order = ["displacement", "velocity", "acceleration"].index(quantity)
    damping = {"mass_proportional": drag, "stiffness_proportional": loss}
    here.scene("a", scene({"quantity": quantity, "count": count}, damping=damping))
    rows, quiet = reported(here)
    modes = frequencies_of_cantilever(5)
    assert len(rows) == 5
    for row, beta in zip(rows, modes):
        width = (drag + loss * beta**2) / 2 / np.pi
        at, size, half = peak_of(lambda f: abs((2 * np.pi * f) ** order * tip_of_cantilever(f, loss, drag)), beta / 2 / np.pi, width)
        assert float(row[0]) == pytest.approx(at, rel=5e-7)
        assert float(row[1]) == pytest.approx(size, rel=1e-4)
        assert float(row[2]) == pytest.approx((half[1] - half[0]) / at / 2, rel=2 * width / at + 1e-5)
        assert float(row[2]) == pytest.approx(np.pi * width / beta, rel=0.04)  # what the other modes add
    zeros = [brentq(lambda f: tip_of_cantilever(f, loss, drag).real, 0.95 * f, 1.05 * f) for f in pinned_frequencies(4)]
    np.testing.assert_allclose(quiet[:4], zeros, rtol=5e-7)


def test_undamped_resonances_are_the_modes_and_have_no_size(here):
    here.scene("a", scene({"count": 2}))
    rows, quiet = reported(here)
    np.testing.assert_allclose([float(row[0]) for row in rows], frequencies_of_cantilever(5) / 2 / np.pi, rtol=5e-7)
    assert all(row[1:] == ["-", "-"] for row in rows)
    np.testing.assert_allclose(quiet, pinned_frequencies(len(quiet)), rtol=5e-7)


@pytest.mark.parametrize(("quantity", "peak"), [("displacement", 1 / np.sqrt(1 - 2 * 0.3**2)), ("velocity", 1.0), ("acceleration", np.sqrt(1 - 2 * 0.3**2))])
def test_a_strongly_damped_mode_has_its_own_peak_of_each_quantity(here, quantity, peak):
    # a heavy mass at the tip leaves one mode in the band, a mass on a spring
    tip = {"position": 1.0, "mass": 1e4}
    here.scene("a", scene({"quantity": quantity, "first": 0.1, "last": 20.0}, body=tip, damping={"ratio": 0.3}))
    here.scene("b", scene({"quantity": quantity, "first": 0.1, "last": 20.0}, body=tip, modes={"before": 2}))
    beta = here.run("b")["angular_frequency"].ravel()[0] / 2 / np.pi
    rows, _ = reported(here)
    assert len(rows) == 1
    assert float(rows[0][0]) == pytest.approx(beta / peak, rel=1e-4)
    assert float(rows[0][2]) == pytest.approx(0.3, rel=1e-3)


def test_two_modes_within_one_width_have_one_resonance(here):
    # two halves of a beam, clamped at both ends and all but clamped between: pairs of modes 1e-4 apart; the curve itself tells its peak
    halves = {
        "tip_support": {"stiffness": 1e14, "rotational_stiffness": 1e12},
        "body": {"position": 0.5, "mass": 0.01, "stiffness": 1e11, "rotational_stiffness": 1e8},
        "damping": {"mass_proportional": 30.0},
    }
    clamped = float(4.730040744862704**2 / 0.5**2 * np.sqrt(STIFFNESS / MASS) / 2 / np.pi)
    asked = {"first": 0.99 * clamped, "last": 1.01 * clamped, "count": 4001, "position": 0.2, "points": [0.2, 0.3]}
    here.scene("a", scene(asked, **halves))
    rows, _ = reported(here)
    frequency, size = here.result("a")["response_frequency"], np.abs(answer(here.result("a")))
    assert len(rows) == 2
    for row, curve in zip(rows, size):
        assert float(row[0]) == pytest.approx(frequency[np.argmax(curve)], rel=1e-5)
        assert float(row[1]) == pytest.approx(curve.max(), rel=1e-4)


def test_a_node_has_no_resonance(here):
    # mode 2 of a cantilever rests at 0.7834417 of its length, the root of its shape
    here.scene("a", scene({"points": [0.783441692264, 1.0], "first": 100.0, "last": 250.0}, damping={"ratio": 0.01}))
    rows, _ = reported(here)
    assert len(rows) == 1


def on_a_hub(frequency, position, points, inertia, radius):
    """Deflections from the line of a hub that a force turns with the beam: waves on both sides of the force, and the hub's balance of moments."""
    omega, a = 2 * np.pi * frequency, position
    k = (omega**2 * MASS / STIFFNESS) ** 0.25

    def derivatives(x):
        c, s, ch, sh = np.cos(k * x), np.sin(k * x), np.cosh(k * x), np.sinh(k * x)
        return np.array([[c, s, ch, sh], k * np.array([-s, c, sh, ch]), k**2 * np.array([-c, -s, ch, sh]), k**3 * np.array([s, -c, sh, ch])])

    equations, right = np.zeros((8, 8)), np.zeros(8)
    root, forced, tip = derivatives(0.0), derivatives(a), derivatives(1.0)
    equations[0, :4] = root[0] - radius * root[1]
    equations[1, :4] = -inertia * omega**2 * root[1] + STIFFNESS * (radius * root[3] - root[2])
    equations[2:6, :4], equations[2:6, 4:] = forced, -forced
    equations[6:, 4:] = tip[2:]
    right[5] = -1.0 / STIFFNESS
    scale = np.abs(equations).max(axis=1)
    waves = np.linalg.solve(equations / scale[:, None], right / scale)
    turn = root[1] @ waves[:4]
    return [derivatives(x)[0] @ (waves[:4] if x <= a else waves[4:]) - turn * (radius + x) for x in points]


def test_a_force_turns_a_free_hub_too(here):
    asked = {"first": 2.0, "last": 300.0, "count": 40, "position": 0.7, "points": [0.4, 1.0]}
    result = here.simulate("a", scene(asked, hub={"rotary_inertia": 0.5, "radius": 0.1}))
    expected = np.array([on_a_hub(f, 0.7, asked["points"], 0.5, 0.1) for f in result["response_frequency"]]).T
    error = result["frequency_response_error"]
    assert (error <= 1e-12 * np.abs(expected).max(axis=1)).all()  # all modes that are not summed answer, too
    assert (np.abs(answer(result) - expected) <= error[:, None] + 1e-10 * np.abs(expected)).all()


@pytest.mark.parametrize(
    ("asked", "message"),
    [
        ({"last": 2.0}, "frequency_response%last: is not above first = 3 Hz; accepted: a higher frequency"),
        ({"points": [0.5, 0.5]}, "frequency_response%points: 0.5 is given twice; accepted: each point once"),
        ({"first": 0.0}, "frequency_response%first"),
        ({"quantity": "strain"}, "frequency_response%quantity"),
    ],
)
def test_what_cannot_be_asked_is_refused(here, asked, message):
    ended = here.beamwave("run", here.scene("a", scene(asked)), status=2)
    assert message in ended.stderr


def test_what_is_held_rests(here):
    ended = here.beamwave("run", here.scene("a", scene({"position": 0.0, "points": [0.5, 1.0]})))
    assert ended.returncode == 0 and "NaN" not in ended.stdout
    assert "neither a resonance nor an antiresonance" in ended.stdout
    assert not np.abs(answer(here.result("a"))).any()


def test_what_is_less_than_its_error_is_missing(here):
    ended = here.beamwave("run", here.scene("a", scene({"last": 1e6, "count": 30}, damping={"ratio": 1e30})), status=4)
    assert "neither a resonance nor an antiresonance" in ended.stdout
    assert results.is_fill(here.result("a")["frequency_response_real"]).all()


def test_a_tolerance_that_cannot_be_had_takes_no_answer_away(here):
    response = {"duration": 1e-9, "samples": 4, "points": [0.01]}
    struck = scene({"points": [0.01]}, impact={}, capture={}, response=response)
    name = here.scene("a", struck, {"parameter": "impact%mass_ratio", "values": [0.1, 0.2]})
    assert here.beamwave("run", name).returncode == 4
    assert np.isfinite(answer(here.result("a"))).all()


def test_no_number_is_infinite_at_a_resonance(here):
    # to the last digit or not: what is no number is fill
    beta = float(frequencies_of_cantilever(1)[0] / 2 / np.pi)
    values = here.simulate("a", scene({"first": beta, "last": 2 * beta, "count": 2}))["frequency_response_real"]
    assert (np.isfinite(values) | results.is_fill(values)).all()


def share_at_a_mass(mass, frequency):
    """Share of a wave's power that a mass on an infinite beam transmits: ((4 + μ)/|4 + μ(1 + i)|)², μ = mP/ρA."""
    mu = mass * np.sqrt(2 * np.pi * frequency * np.sqrt(MASS / STIFFNESS)) / MASS
    return (4 + mu) ** 2 / np.abs(4 + mu * (1 + 1j)) ** 2


def test_bodies_within_the_beam_transmit_and_reflect_waves(here):
    bodies = {"body": {"position": 0.4, "mass": 3.0}, "impact": {"mass_ratio": 0.2, "position": 0.7}, "capture": {}}
    here.scene("a", scene(damping={"mass_proportional": 1.0}, **bodies))
    ended = here.beamwave("run", "a.nml")
    result = here.result("a")
    np.testing.assert_allclose(result["junction_position"], [0.4, 0.7], rtol=1e-15)
    shares = [share_at_a_mass(mass, result["response_frequency"]) for mass in (3.0, 0.2 * MASS)]
    np.testing.assert_allclose(result["transmitted_power"], shares, rtol=1e-12)
    np.testing.assert_allclose(result["transmitted_power"] + result["reflected_power"], 1.0, rtol=1e-12)
    rows = ended.stdout.split("that bodies and steps transmit")[1].splitlines()[3:5]
    for row, share in zip(rows, shares):
        np.testing.assert_allclose(np.array(row.split()[1:], float)[[0, 2]], 100 * share[[-1, 0]], rtol=1e-3)


def test_a_swept_body_may_leave_the_inside_of_the_beam(here):
    name = here.scene("a", scene(body={"mass": 3.0, "position": 0.5}), {"parameter": "body(1)%position", "values": [0.25, 1.0]})
    assert here.beamwave("run", name).returncode == 0
    result = here.result("a")
    assert results.is_fill(result["transmitted_power"][1]).all() and results.is_fill(result["junction_position"][1]).all()
    np.testing.assert_allclose(result["transmitted_power"][0, 0], share_at_a_mass(3.0, result["response_frequency"]), rtol=1e-12)


@pytest.mark.parametrize("group", [{"rotation": {"angular_velocity": 50.0}, "stiffening": {}}, {}])
def test_waves_have_no_junction_where_none_is_or_tension_bends_them(here, group):
    body = {"body": {"position": 0.4, "mass": 3.0}} if group else {}
    here.scene("a", scene(**body, **group))
    assert "transmitted_power" not in here.run("a").variables
