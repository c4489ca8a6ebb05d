"""Pictures of what a beamwave result holds, and the program itself, from Python."""

from . import _loading
from .compare import compare
from .draw.campbell import campbell, crossings
from .draw.contact_force import contact_force
from .draw.effect_table import changes
from .draw.frequency_response import frequency_response
from .draw.history import acceleration, bending_moment, displacement, hub_angle, shear_force, velocity
from .draw.identified import identified
from .draw.impulses import impulses
from .draw.jump import velocity_jump
from .draw.lines import lines
from .draw.measured import measured
from .draw.mode_shapes import mode_shapes
from .draw.outcome_map import outcome_map
from .draw.outcomes import outcomes
from .draw.prices import work_precision
from .draw.ranking import ranking
from .draw.record_dispersion import record_dispersion
from .draw.record_envelopes import record_envelopes
from .draw.record_fit import record_fit
from .draw.record_model import record_model
from .draw.record_repeats import record_repeats
from .draw.record_response import record_response
from .draw.record_shapes import record_shapes
from .draw.record_spectrum import record_spectrum
from .draw.record_windows import record_windows
from .draw.space_time import space_time, space_time_moment
from .draw.spectrogram import spectrogram
from .draw.spectrum import spectrum
from .draw.sweep_map import sweep_map
from .draw.transmission import transmission
from .draw.wavenumber import wavenumber_spectrum
from .draw.waves import dispersion, group_velocity, phase_velocity
from .export import ModalModel, StateSpace, modal_model, state_space
from .film.frames import save_film
from .film.motion import motion
from .kinds import KINDS, pictures
from .page.html import page_of
from .parts.outcome import rankings
from .result import NotAResult, NothingToDraw, open_result, swept_inputs, to_grid
from .run import ProgramWarning, RunFailed, Untrusted, run
from .run_many import run_many
from .stress import strain, stress

__all__ = [
    "KINDS",
    "ModalModel",
    "NotAResult",
    "NothingToDraw",
    "ProgramWarning",
    "RunFailed",
    "StateSpace",
    "Untrusted",
    "acceleration",
    "bending_moment",
    "campbell",
    "changes",
    "compare",
    "contact_force",
    "crossings",
    "dispersion",
    "displacement",
    "frequency_response",
    "group_velocity",
    "hub_angle",
    "identified",
    "impulses",
    "lines",
    "measured",
    "modal_model",
    "mode_shapes",
    "motion",
    "open_result",
    "outcome_map",
    "outcomes",
    "page_of",
    "phase_velocity",
    "pictures",
    "ranking",
    "rankings",
    "record_dispersion",
    "record_envelopes",
    "record_fit",
    "record_model",
    "record_repeats",
    "record_response",
    "record_shapes",
    "record_spectrum",
    "record_windows",
    "run",
    "run_many",
    "save_film",
    "shear_force",
    "space_time",
    "space_time_moment",
    "spectrogram",
    "spectrum",
    "state_space",
    "strain",
    "stress",
    "sweep_map",
    "swept_inputs",
    "to_grid",
    "transmission",
    "velocity",
    "velocity_jump",
    "wavenumber_spectrum",
    "work_precision",
]

_loading.done()
