"""Pictures of what a beamwave result holds: functions from xarray datasets to matplotlib figures."""

from .effect_table import changes
from .film import save_film
from .history import displacement, velocity
from .jump import velocity_jump
from .kinds import KINDS, pictures
from .measured import measured
from .motion import motion
from .prices import work_precision
from .result import NotAResult, NothingToDraw, open_result, swept_inputs, to_grid
from .spectrum import spectrum
from .sweep_map import sweep_map
from .waves import dispersion, group_velocity, phase_velocity

__all__ = [
    "KINDS",
    "NotAResult",
    "NothingToDraw",
    "changes",
    "dispersion",
    "displacement",
    "group_velocity",
    "measured",
    "motion",
    "open_result",
    "phase_velocity",
    "pictures",
    "save_film",
    "spectrum",
    "sweep_map",
    "swept_inputs",
    "to_grid",
    "velocity",
    "velocity_jump",
    "work_precision",
]
