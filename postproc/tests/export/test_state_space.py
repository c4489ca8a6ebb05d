"""The state space of an exported model moves as the program does, by the independent integration of scipy.signal."""

import numpy as np
import pytest
from scipy.signal import StateSpace as Lti
from scipy.signal import lsim

from beamwave_postproc import modal_model, run, state_space

BEAM = {"length": 1.2, "diameter": 0.03, "density": 7800.0, "youngs_modulus": 2.0e11}
# linear between samples, as lsim takes inputs: a triangle whose corners are samples
SAMPLES, DURATION = 400, 0.02
FORCE = {"shape": "triangle", "amplitude": 50.0, "duration": 0.01, "position": 0.5}
BASE = {"shape": "triangle", "amplitude": -20.0, "start": 0.002, "duration": 0.004}
POINTS = {"points": [0.25, 0.5, 1.0]}
RESPONSE = {
    "duration": DURATION,
    "samples": SAMPLES,
    **POINTS,
    "velocity": True,
    "bending_moment": True,
    "shear_force": True,
}
MODES = {"before": 12, "modal_model": True}
TOLERANCE = 1e-11  # of the peak; 7e-14 was found, and an exponential of a matrix may lose more elsewhere
ALPHA = 1.8751040687119611664  # of the first mode of a clamped beam, and σ
SIGMA = (np.cos(ALPHA) + np.cosh(ALPHA)) / (np.sin(ALPHA) + np.sinh(ALPHA))

BEAMS = {
    "the beam alone": {},
    "damped by a ratio": {"damping": {"ratio": 0.02}},
    "damped by Rayleigh's constants": {"damping": {"mass_proportional": 30.0, "stiffness_proportional": 1e-6}},
    "overdamped": {"damping": {"ratio": 1.5}},
    "turning in its plane": {"rotation": {"angular_velocity": 40.0}},
    "growing": {"rotation": {"angular_velocity": 150.0}},
    "growing and damped": {"rotation": {"angular_velocity": 150.0}, "damping": {"ratio": 0.02}},
    "under tension": {"rotation": {"angular_velocity": 60.0}, "stiffening": {"hub_radius": 0.1}},
    "with shear": {"shear": {}},
    "of pieces, with a body and springs": {
        "beam": {**BEAM, "length": [0.5, 0.7], "diameter": [0.03, 0.02]},
        "body": {"position": 0.8, "mass": 1.5, "rotary_inertia": 0.01},
        "support": {"rotational_stiffness": 5e4},
    },
    "tapered": {"beam": {**BEAM, "taper": "linear", "diameter": [0.03, 0.015]}},
    "pinned at its tip": {"tip_support": {"rotational_stiffness": 0.0}},
    "on a free hub": {"hub": {"rotary_inertia": 0.3, "radius": 0.1}, "damping": {"ratio": 0.01}},
    "on a free hub that rotates, with a body": {
        "hub": {"rotary_inertia": 0.05},
        "rotation": {"angular_velocity": 60.0},
        "stiffening": {"hub_radius": 0.1},
        "body": {"position": 0.4, "mass": 1.5},
    },
}

pytestmark = [pytest.mark.usefixtures("beamwave"), pytest.mark.filterwarnings("ignore::beamwave_postproc.ProgramWarning")]


def triangle(time, load):
    start, length = load.get("start", 0.0), load["duration"]
    return load["amplitude"] * np.clip(1.0 - np.abs(time - start - length / 2) / (length / 2), 0.0, None)


def simulated(ds, loads, case=None):
    """Histories of the state space by their names, under loads by the names of inputs."""
    space = state_space(modal_model(ds, case))
    time = ds.time.values
    inputs = np.zeros((time.size, len(space.inputs)))
    for name, load in loads.items():
        inputs[:, space.inputs.index(name)] = triangle(time, load)
    _, outputs, _ = lsim(Lti(space.a, space.b, space.c, space.d), inputs, time, X0=space.initial_state)
    return dict(zip(space.outputs, outputs.T))


def agree(ds, histories, quantity, tolerance=TOLERANCE, less=0.0):
    expected = ds[quantity].transpose("point", "time").values - less
    found = np.array([histories[f"{quantity}_{number}"] for number in range(1, ds.sizes["point"] + 1)])
    assert np.abs(found - expected).max() <= tolerance * np.abs(expected).max(), quantity


def turns_as_the_hub(ds, histories):
    assert ("hub_angle" in ds) == ("hub_angle" in histories)
    if "hub_angle" in ds:
        assert np.abs(histories["hub_angle"] - ds.hub_angle.values).max() <= TOLERANCE * np.abs(ds.hub_angle.values).max()


@pytest.mark.parametrize("name", BEAMS)
def test_forces_and_the_base_move_it_as_they_move_the_beam(name):
    ds = run({"beam": BEAM, **BEAMS[name], "force": FORCE, "base": BASE, "response": RESPONSE, "modes": MODES})
    histories = simulated(ds, {"force_2": FORCE, "base_acceleration": BASE})
    for quantity in ("displacement", "bending_moment", "shear_force"):
        agree(ds, histories, quantity)
    turns_as_the_hub(ds, histories)
    # the program's velocity has R Ḟ besides, which no state space has
    model = modal_model(ds)
    later = slice(205, None)  # both loads are over, and with them Ḟ
    found = np.array([histories[f"velocity_{number}"] for number in (1, 2, 3)])
    assert np.abs(found - ds.velocity.values)[:, later].max() <= TOLERANCE * np.abs(ds.velocity.values).max()
    rate = np.abs(ds.velocity.values - found)[:, 20].max()
    residual, of_base = (np.abs(values["displacement"]).max() for values in (model.residual, model.base_residual))
    assert rate <= residual * 50.0 / 0.005 + of_base * 20.0 / 0.002


@pytest.mark.parametrize(
    "more", [{}, {"capture": {}}, {"capture": {"rotary_inertia": 0.01}, "damping": {"ratio": 0.01}}]
)
def test_a_blow_is_its_initial_state(more):
    modes = {"before": 15, "modal_model": True, **({"after": 14} if "capture" in more else {})}
    response = {key: value for key, value in RESPONSE.items() if key != "shear_force"}
    ds = run(
        {
            "beam": BEAM,
            "impact": {"mass_ratio": 0.3, "approach_velocity": 2.0},
            **more,
            "response": response,
            "modes": modes,
        }
    )
    histories = simulated(ds, {})
    for quantity in ("displacement", "velocity", "bending_moment"):
        agree(ds, histories, quantity)


@pytest.mark.parametrize(
    "begins",
    [
        {"initial": {"force": 100.0, "position": 0.7}, "damping": {"ratio": 0.01}},
        {"initial": {"force": 100.0}, "force": FORCE, "damping": {"ratio": 0.01}},
        {"initial": {"angular_velocity": 2.0}, "support": {"rotational_stiffness": 0.0}},
        {"initial": {"force": 100.0, "angular_velocity": 2.0}, "hub": {"rotary_inertia": 0.3}},
        {"body": {"position": 1.0, "mass": 1.0, "from": 0.0, "velocity": 1.0}},
    ],
)
def test_a_motion_that_begins_otherwise_begins_so_too(begins):
    response = {key: value for key, value in RESPONSE.items() if key != "shear_force"}
    ds = run({"beam": BEAM, **begins, "response": response, "modes": {"before": 12, "modal_model": True}})
    histories = simulated(ds, {"force_2": FORCE} if "force" in begins else {})
    for quantity in ("displacement",) if "force" in begins else ("displacement", "velocity", "bending_moment"):
        agree(ds, histories, quantity)
    turns_as_the_hub(ds, histories)


def test_a_case_of_a_sweep_is_itself():
    sweep = {"parameter": "rotation%angular_velocity", "values": [0.0, 30.0]}
    scene = {"beam": BEAM, "rotation": {"angular_velocity": 0.0}, "force": FORCE, "response": RESPONSE, "modes": MODES}
    swept = run({**scene, "sweep": sweep})
    agree(swept.isel(case=1), simulated(swept, {"force_2": FORCE}, case=2), "displacement")


def test_few_modes_are_as_stiff_as_all_under_a_force_at_rest():
    """D is the rest of the static flexibility: −C A⁻¹ B + D is l³/(3EI) whatever the number of modes."""
    flexibility = 1.2**3 / (3 * 2.0e11 * np.pi * 0.03**4 / 64)
    for count in (1, 3, 40):
        ds = run({"beam": BEAM, "force": FORCE, "response": RESPONSE, "modes": {"before": count, "modal_model": True}})
        space = state_space(modal_model(ds))
        static = space.d - space.c @ np.linalg.solve(space.a, space.b)
        tip = static[space.outputs.index("displacement_3"), space.inputs.index("force_3")]
        assert tip == pytest.approx(flexibility, rel=1e-11)


def test_effective_masses_and_the_residual_mass_are_the_mass():
    """Of a clamped beam m_eff = m(2σ/α)²: what 2000 modes lack is 4m/(π²n), 2e-4 of it, which the residual mass is."""
    response = {"duration": 1e-3, "samples": 2, "points": [1.0]}
    model = modal_model(
        run({"beam": BEAM, "force": FORCE, "response": response, "modes": {"before": 2000, "modal_model": True}})
    )
    mass = 7800.0 * np.pi * 0.015**2 * 1.2
    assert model.moving_mass == pytest.approx(mass, rel=1e-14)
    assert model.effective_mass[0] == pytest.approx(mass * (2 * SIGMA / ALPHA) ** 2, rel=1e-12)
    assert model.residual_mass / mass == pytest.approx(4.0 / (np.pi**2 * 2000), rel=1e-6)
    assert model.effective_mass.sum() + model.residual_mass == pytest.approx(mass, rel=1e-15)


def test_modes_and_residual_belong_together_where_a_contact_has_more_modes_than_the_capture():
    """The contact goes on with 20 modes and the file has the 18 of the capture, which with their residual are l³/(3EI)."""
    ds = run(
        {
            "beam": BEAM,
            "impact": {"mass_ratio": 0.1},
            "contact": {"radius": 0.02},
            "capture": {},
            "response": {"duration": 2e-3, "samples": 16, "points": [1.0]},
            "modes": {"before": 20, "after": 18, "modal_model": True},
        }
    )
    model = modal_model(ds)
    static = (model.shape[:, 0] ** 2 / model.stiffness).sum() + model.residual["displacement"][0, 0]
    assert model.mass.size == 18
    assert static == pytest.approx(1.2**3 / (3 * 2.0e11 * np.pi * 0.03**4 / 64), rel=1e-10)


def test_displacements_by_a_moment_converge_with_the_square_of_the_number_of_modes_and_slopes_with_the_number(beamwave):
    """A moment of 1 N m at the tip of a clamped beam, at rest: v = l²/(2EI) there, v' = l/(EI). README has these numbers."""
    beam = {"length": 0.4, "width": 0.03, "height": 0.003, "density": 2700.0, "youngs_modulus": 7e10}
    points = {"points": [1.0], "first": 1.0, "last": 500.0}
    flexible = 0.4 / (7e10 * 0.03 * 0.003**3 / 12.0)
    short = []
    for count in (10, 20):
        scene = {"beam": beam, "frequency_response": points, "modes": {"before": count, "modal_model": True}}
        model = modal_model(run(scene, program=beamwave))
        drive = model.slope[:, 0] / model.stiffness
        short.append([1.0 - model.shape[:, 0] @ drive / (0.2 * flexible), 1.0 - model.slope[:, 0] @ drive / flexible])
    assert [100.0 * off[0] for off in short] == pytest.approx([0.13, 0.03], abs=0.005)
    assert short[0][0] / short[1][0] == pytest.approx(4.0, rel=0.05) and short[0][1] / short[1][1] == pytest.approx(2.0, rel=0.05)
