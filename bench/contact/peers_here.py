"""Who is compared."""

from . import beamwave, exudyn_stop, opensees

PEERS = (beamwave.STAGES, beamwave.PROCESS, opensees.PEER, exudyn_stop.NEWMARK, exudyn_stop.DOPRI)
