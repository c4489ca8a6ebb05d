"""Every numeric name that sets no axis of the result can be swept; its cases are the scenes with those values."""

import re

import pytest
from workplace import PAPER_BEAM, captured_beam, example, namelist

SETS_AXES = {"response", "spectrum", "sweep"}  # groups, and names beside them
AXES = {"impact%profile_points", *(f"frequency_response%{name}" for name in ("points", "first", "last", "count"))}
SETS_AXES |= {"record", "identify"}
OF_RECORDS = {"record%start", "record%end", "spectrum%confidence", "spectrum%false_alarm"}  # swept all the same: test_record_runs
RESPONSE = {"duration": 0.02, "samples": 16, "points": [1.0]}
SQUARE = {**{name: value for name, value in PAPER_BEAM.items() if name != "diameter"}, "area": 1e-3, "second_moment": 1e-7}
BAR = {**{name: value for name, value in PAPER_BEAM.items() if name != "diameter"}, "width": 0.03, "height": 0.02}
LUMPED = {"length": 1.0, "mass_per_length": 3.0, "bending_stiffness": 500.0}
REBOUND = captured_beam(capture=None, modes={"before": 8, "after": 8}, response=RESPONSE)
STRUCK = captured_beam(capture=None, modes={"before": 8, "after": 8}, response=RESPONSE)
CAPTURE = captured_beam(modes={"before": 8, "after": 8}, response=RESPONSE)
RECOIL = captured_beam(rotation=None, hub={"rotary_inertia": 2.0}, modes={"before": 8, "after": 8}, response=RESPONSE)
SPRING = {"position": 0.8, "mass": 0.1, "stiffness": 1e3, "rotational_stiffness": 1e2}
AT_REST = {"beam": dict(PAPER_BEAM), "modes": {"before": 8}, "response": RESPONSE}
PULSE = {"amplitude": 10.0, "duration": 0.004}
LOADS = {
    "amplitude": (PULSE, [0.0, 5.0]),
    "start": (PULSE, [0.0, 0.003]),
    "duration": (PULSE, [0.001, 0.005]),
    "frequency": ({**PULSE, "shape": "sine", "frequency": 100.0}, [100.0, 200.0]),
    "scale": ({"shape": "file", "file": "pulse.csv", "scale": 1.0}, [1.0, 2.0]),
    "time_scale": ({"shape": "file", "file": "pulse.csv", "time_scale": 1.0}, [1.0, 0.5]),
    "sample_rate": ({"shape": "file", "file": "pulse.csv", "sample_rate": 1e3}, [1e3, 2e3]),
}
COMES = {**CAPTURE, "body": {"position": 0.8, "mass": 0.1, "from": 0.01, "velocity": 1.0}}
TURNS = {**CAPTURE, "support": {"rotational_stiffness": 1e5}, "initial": {"angular_velocity": 0.1}}
SCENES = {  # a scene in which the name means something, and two values; of a name that is not here a scene of input/ and its value
    "beam%length": (CAPTURE, [0.9, 1.1]),
    "beam%density": (CAPTURE, [7000.0, 8000.0]),
    "beam%youngs_modulus": (CAPTURE, [1e11, 2e11]),
    "beam%diameter": (CAPTURE, [0.02, 0.03]),
    "beam%width": ({**CAPTURE, "beam": BAR}, [0.02, 0.03]),
    "beam%height": ({**CAPTURE, "beam": BAR}, [0.02, 0.03]),
    "beam%area": ({**CAPTURE, "beam": SQUARE}, [1e-3, 2e-3]),
    "beam%second_moment": ({**CAPTURE, "beam": SQUARE}, [1e-7, 2e-7]),
    "beam%mass_per_length": ({**CAPTURE, "beam": LUMPED}, [3.0, 4.0]),
    "beam%bending_stiffness": ({**CAPTURE, "beam": LUMPED}, [500.0, 600.0]),
    "beam%extreme_fibre": ({**CAPTURE, "beam": SQUARE}, [0.01, 0.02]),
    "rotation%angular_velocity": (CAPTURE, [0.0, 30.0]),
    "stiffening%hub_radius": ({**CAPTURE, "stiffening": {}}, [0.0, 0.5]),
    "shear%poisson_ratio": ({**CAPTURE, "shear": {}}, [0.25, 0.35]),
    "shear%shear_coefficient": ({**CAPTURE, "shear": {}}, [0.8, 0.9]),
    "damping%ratio": ({**CAPTURE, "damping": {"ratio": 0.1}}, [0.0, 0.02]),
    "damping%mass_proportional": ({**CAPTURE, "damping": {"mass_proportional": 1.0}}, [0.0, 2.0]),
    "damping%stiffness_proportional": ({**CAPTURE, "damping": {"mass_proportional": 1.0}}, [0.0, 1e-6]),
    "impact%mass": ({**CAPTURE, "impact": {"mass": 1.0}}, [1.0, 2.0]),
    "impact%mass_ratio": (CAPTURE, [0.1, 0.3]),
    "impact%approach_velocity": (CAPTURE, [0.5, 2.0]),
    "impact%restitution": (REBOUND, [0.0, 1.0]),
    "capture%rotary_inertia": (CAPTURE, [0.0, 1e-3]),
    "release%time": ({**CAPTURE, "release": {"time": 0.01}}, [0.005, 0.015]),
    "recontact%max_contacts": ({**REBOUND, "recontact": {}}, [1, 3]),
    "contact%stiffness": ({**STRUCK, "contact": {"stiffness": 1e10}}, [1e9, 1e10]),
    "contact%exponent": ({**STRUCK, "contact": {"stiffness": 1e8}}, [1.0, 1.5]),
    "contact%radius": ({**STRUCK, "contact": {"radius": 0.02}}, [0.01, 0.02]),
    "contact%youngs_modulus": ({**STRUCK, "contact": {"radius": 0.02}}, [7e10, 2e11]),
    "contact%poisson_ratio": ({**STRUCK, "contact": {"radius": 0.02}}, [0.2, 0.3]),
    "contact%beam_poisson_ratio": ({**STRUCK, "contact": {"radius": 0.02}}, [0.2, 0.3]),
    "contact%surface_radius": ({**STRUCK, "contact": {"radius": 0.02}}, [0.0, 0.05]),
    "contact%damping": ({**STRUCK, "contact": {"radius": 0.02}}, [0.0, 0.3]),
    "contact%max_contacts": ({**STRUCK, "contact": {"radius": 0.02}}, [500, 600]),
    "modes%before": (CAPTURE, [4, 9]),
    "modes%after": (CAPTURE, [5, 7]),
    "modes%tolerance": ({**CAPTURE, "modes": {}}, [1e-2, 1e-4]),
    "support%stiffness": ({**CAPTURE, "support": {"stiffness": 1e6}}, [1e5, 1e7]),
    "support%rotational_stiffness": ({**CAPTURE, "support": {"rotational_stiffness": 1e4}}, [1e3, 1e5]),
    "tip_support%stiffness": ({**CAPTURE, "tip_support": {"stiffness": 1e6}}, [1e4, 1e6]),
    "tip_support%rotational_stiffness": ({**CAPTURE, "tip_support": {"stiffness": 1e4}}, [1e3, 1e5]),
    "hub%rotary_inertia": (RECOIL, [1.0, 2.0]),
    "hub%radius": (RECOIL, [0.0, 0.2]),
    "body%position": ({**CAPTURE, "body": SPRING}, [0.4, 1.0]),
    "body%mass": ({**CAPTURE, "body": SPRING}, [0.0, 0.2]),
    "body%mass_ratio": ({**CAPTURE, "body": {"position": 0.8, "mass_ratio": 0.1}}, [0.0, 0.2]),
    "body%rotary_inertia": ({**CAPTURE, "body": SPRING}, [0.0, 1e-3]),
    "body%stiffness": ({**CAPTURE, "body": SPRING}, [0.0, 2e3]),
    "body%rotational_stiffness": ({**CAPTURE, "body": SPRING}, [0.0, 2e2]),
    "body%from": (COMES, [0.003, 0.008]),
    "body%until": ({**CAPTURE, "body": {"position": 0.8, "mass": 0.1, "until": 0.01}}, [0.003, 0.008]),
    "body%velocity": (COMES, [-1.0, 2.0]),
    "initial%force": ({**CAPTURE, "initial": {"force": 10.0}}, [0.0, 20.0]),
    "initial%position": ({**CAPTURE, "initial": {"force": 10.0}}, [0.5, 1.0]),
    "initial%angular_velocity": (TURNS, [0.0, 0.3]),
    "impact%position": (CAPTURE, [0.7, 1.0]),
    **{f"{group}%{name}": ({**AT_REST, group: values}, swept) for group in ("force", "base") for name, (values, swept) in LOADS.items()},
    "force%position": ({**AT_REST, "force": PULSE}, [0.5, 1.0]),
    "frequency_response%position": ({**CAPTURE, "frequency_response": {"first": 10.0, "last": 99.0, "count": 5}}, [0.7, 1.0]),
}


@pytest.fixture(scope="module")
def described(shared):
    """Every name of the program with its type."""
    here = shared("described")
    found = {}
    for part in here.beamwave("describe").stdout.split("\n## &")[1:]:
        group = re.match(r"\w+", part)[0]
        for name, kind in re.findall(r"^\| `(\w+)`\s*\| (.*?)\s*\|", part, re.MULTILINE):
            found[f"{group}%{name}"] = kind
    return found


def is_swept(name, kind):
    return kind in {"real", "real or list", "whole number"} and name.split("%")[0] not in SETS_AXES and name not in AXES


def with_value(scene, name, value):
    group, key = name.split("%")
    return {**scene, group: {**scene.get(group, {}), key: value}}


def coordinate_of(name):
    """The variable with a swept name's values, one for each case: of a body or a load it has its number."""
    return name.replace("%", "_") + ("_1" if name.startswith(("body%", "force%", "base%")) else "")


def scene_of(name):
    group, key = name.split("%")
    if name in SCENES:
        return SCENES[name]
    scene = example(group)
    assert scene and key in scene[group], f"{name} is in no scene, neither here nor in input/"
    return scene, [scene[group][key], 1.25 * scene[group][key]]


def test_a_sweep_over_any_name_is_its_cases(described, shared):
    here = shared("names")
    scenes = {name: scene_of(name) for name, kind in described.items() if is_swept(name, kind)}
    here.write("all/pulse.csv", "time,load\n0,0\n0.001,5\n0.002,0\n")
    for number, (name, (scene, values)) in enumerate(scenes.items()):
        here.write(f"all/n{number}.nml", namelist(scene, {"parameter": name, "values": values}))
        for case, value in enumerate(values):
            here.write(f"all/n{number}_{case}.nml", namelist(with_value(scene, name, value)))
    here.beamwave("run", "all", status=4)
    for number, (name, (_, values)) in enumerate(scenes.items()):
        swept = here.result(f"n{number}")
        assert swept[coordinate_of(name)].tolist() == values
        assert (swept["case_status"] == (2 if name == "recontact%max_contacts" else 0)).all(), name
        for case in range(len(values)):
            alone = here.result(f"n{number}_{case}")
            for variable, (_, numbers, _) in alone.variables.items():
                there = swept[variable]
                if "case" in swept.variables[variable].dimensions:
                    there = there[case]
                if there.shape == numbers.shape and variable != "stage_seconds":
                    assert there.tobytes() == numbers.tobytes(), (name, variable)


def test_other_names_are_refused_with_the_reason(described, here):
    refused = {name for name, kind in described.items() if not is_swept(name, kind) and name[:6] != "sweep%"} - OF_RECORDS
    assert len(refused) > 5
    for name in refused:
        group = name.split("%")[0]
        extra = {} if group in {"response", *CAPTURE} else {group: {}}
        here.write(f"all/{name.replace('%', '_')}.nml",
                   namelist({**CAPTURE, **extra}, {"parameter": name, "values": [1, 2]}))
    ended = here.beamwave("run", "all", status=2)
    for name in refused:
        said = [line for line in ended.stderr.splitlines() if line.startswith(f"all/{name.replace('%', '_')}.nml:")]
        assert any("sweep%parameter" in line and "accepted" in line for line in said), (name, said)
    assert not (here.directory / "output").exists()
