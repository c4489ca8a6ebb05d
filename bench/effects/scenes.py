"""The paper's scene, alone and with one effect more."""

from __future__ import annotations

from dataclasses import dataclass

BEAM = "&beam length = 1, diameter = 0.037, density = 7870, youngs_modulus = 2e11 /"
ROTATION = "&rotation angular_velocity = 50 /"
IMPACT = "&impact mass_ratio = 0.2 /"
CAPTURE = "&capture /"
RESPONSE = "&response duration = 1, samples = {samples} /"
PAPER = (BEAM, ROTATION, IMPACT, CAPTURE, RESPONSE)

SAMPLES, SMALL_SAMPLES = 4096, 64
MODES, SMALL_MODES = 40, 4


@dataclass(frozen=True)
class Variant:
    """A scene of the table: its words there, and its groups besides `&modes`."""

    words: str
    groups: tuple[str, ...]
    beside: str = "paper"  # what it is held against, by the words
    modes: int = 0  # how many; 0: as many as the others

    def scene(self, small: bool) -> str:
        """The scene's text."""
        modes = self.modes or (SMALL_MODES if small else MODES)
        counts = f"before = {modes}, after = {modes}" if CAPTURE[:8] in "".join(self.groups) else f"before = {modes}"
        samples = SMALL_SAMPLES if small else SAMPLES
        return "\n".join([*self.groups, f"&modes {counts} /"]).replace("{samples}", str(samples)) + "\n"


REBOUND = (  # the mass strikes six times; of more modes the contacts are too many to be counted
    BEAM,
    ROTATION,
    "&impact mass_ratio = 0.2, restitution = 0.9 /",
    "&response duration = 0.02, samples = {samples} /",
)

VARIANTS = (
    Variant("paper", PAPER),
    Variant("without rotation", (BEAM, IMPACT, CAPTURE, RESPONSE)),
    Variant("out of plane", (BEAM, "&rotation angular_velocity = 50, plane = 'out' /", IMPACT, CAPTURE, RESPONSE)),
    Variant("with stiffening", (*PAPER, "&stiffening /")),
    Variant("with shear", (*PAPER, "&shear /")),
    Variant("with damping", (*PAPER, "&damping ratio = 0.01 /")),
    Variant(
        "with the body's rotary inertia",
        (BEAM, ROTATION, IMPACT, "&capture rotary_inertia = 1e-3 /", RESPONSE),
    ),
    Variant(
        "captured at xi = 0.7",
        (BEAM, ROTATION, "&impact mass_ratio = 0.2, position = 0.7 /", CAPTURE, RESPONSE),
    ),
    Variant("with a soft root", (*PAPER, "&support rotational_stiffness = 1.84e5 /")),
    Variant("with a body at xi = 0.5", (*PAPER, "&body position = 0.5, mass_ratio = 0.01 /")),
    Variant("with release at half time", (*PAPER, "&release time = 0.5 /")),
    Variant("rebound of 5 modes", REBOUND, modes=5),
    Variant("with recontact", (*REBOUND, "&recontact /"), "rebound of 5 modes", modes=5),
)

SMALL_VARIANTS = (VARIANTS[0], VARIANTS[4])
