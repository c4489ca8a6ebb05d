"""The modal model of a result for other programs: as arrays, as a state space, and in their files."""

from .model import ModalModel, modal_model
from .state_space import StateSpace, state_space

__all__ = ["ModalModel", "StateSpace", "modal_model", "state_space"]
