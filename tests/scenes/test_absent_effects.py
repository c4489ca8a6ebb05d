"""What a scene does not name is not entered: instructions counted by valgrind."""

import re
from pathlib import Path

import callgrind
import pytest
from workplace import captured_beam

SOURCE = Path(__file__).parents[2] / "src"

# Modules of each effect that the paper's scene lacks; shear and a body's inertia make its beam one of pieces. The modules of src/beam
# that are here in neither table fail.
ABSENT = {
    "stiffening": ["bw_varying_beam", "bw_tension_layers"],
    "damping": ["bw_damping", "bw_damped_modes"],
    "frequency response": ["bw_forced_beam"],
    "release": ["bw_release", "bw_projection"],
    "recontact": [
        *("bw_recontact", "bw_contact_motion", "bw_contact_segments", "bw_contact_modes"),
        *("bw_signal", "bw_oscillators", "bw_neighbours"),
    ],
    "contact": [
        *("bw_lasting_contact", "bw_contact_bodies", "bw_contact_law"),
        *("bw_contact_force", "bw_contact_steps", "bw_contact_changes"),
        *("bw_force_step", "bw_force_response", "bw_loaded_sum", "bw_static_shape"),
    ],
    "loads": ["bw_case_loads", "bw_load_courses", "bw_load_course", "bw_load_step", "bw_load_modes", "bw_load_sum"],
    "pieces": [
        *("bw_piece_beam", "bw_scene_pieces", "bw_piece_source", "bw_piece_set"),
        *("bw_mode_search", "bw_mode_probe"),
    ],
    "Galerkin": ["bw_strain_source", "bw_strain_set", "bw_strain_basis", "bw_strain_system", "bw_strain_modes"],
}
COMMON = ["bw_beam_units", "bw_rotation"]
HINT = "__bw_absent_effects_MOD_"  # the line of the report that names what was left out
EIGENSOLVER = re.compile(r"d((sy|sb|sp|st|pt|ge|gg|hs)\w*(ev|gv|eqr|edc|ebz|ein|emr|trd)\w*|gesdd|gesvd|bdsdc|bdsqr)_")


@pytest.fixture(scope="module")
def profile(shared):
    """A run of the paper's scene."""
    if callgrind.missing():
        pytest.skip(callgrind.missing())
    here = shared("counted")
    scene = captured_beam(modes={"before": 40, "after": 40}, response={"duration": 0.02, "samples": 256})
    here.scene("paper", scene)
    found = callgrind.entered(here, "run", "paper.nml")
    if found is None:
        pytest.skip("valgrind does not know an instruction of this build, which is tuned for its processor")
    return found


def modules_of(folder):
    return {path.stem for path in (SOURCE / folder).rglob("*.f90")}


def entered(profile, module):
    """The procedures of a module that are entered otherwise than for the hint."""
    reached, new = set(), {procedure for procedure in profile.procedures if not profile.callers.get(procedure)}
    while new:
        reached |= new
        new = {procedure for procedure, callers in profile.callers.items() if callers & new} - reached
        new = {procedure for procedure in new if not procedure.startswith(HINT)}
    return [procedure for procedure in reached if procedure.startswith(f"__{module}_MOD_")]


def test_the_modules_of_effects_are_all_known_here():
    known = {name for names in ABSENT.values() for name in names}
    assert modules_of("beam") <= known | set(COMMON)
    assert known <= modules_of("beam") | modules_of("modes") | modules_of("motion") | modules_of("response") | modules_of("case")


def test_a_run_is_seen_procedure_by_procedure(profile):
    for module in ("bw_closed_form", "bw_rotation", "bw_impact", "bw_hint"):
        assert any(procedure.startswith(f"__{module}_MOD_") for procedure in profile.procedures), module


@pytest.mark.parametrize("effect", ABSENT)
def test_an_absent_effect_is_not_entered(profile, effect):
    for module in ABSENT[effect]:
        assert not entered(profile, module), module


def test_no_eigensolver_and_no_svd_of_lapack_is_entered(profile):
    assert not [procedure for procedure in profile.procedures if EIGENSOLVER.fullmatch(procedure)]


def test_an_effect_that_is_there_is_seen(shared):
    # else the tests above could not fail
    if callgrind.missing():
        pytest.skip(callgrind.missing())
    here = shared("counted_shear")
    few = {"modes": {"before": 3, "after": 3}, "shear": {}}
    here.scene("shear", captured_beam(**few))
    here.scene("tension", captured_beam(**few, stiffening={}))
    pieces, tension = (callgrind.entered(here, "run", f"{name}.nml") for name in ("shear", "tension"))
    if pieces is None or tension is None:
        pytest.skip("valgrind does not know an instruction of this build, which is tuned for its processor")
    for module in ABSENT["pieces"]:
        assert entered(pieces, module), module
    for module in (*ABSENT["stiffening"], *ABSENT["Galerkin"]):
        assert entered(tension, module), module
    assert [procedure for procedure in tension.procedures if EIGENSOLVER.fullmatch(procedure)]
