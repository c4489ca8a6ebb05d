"""beamwave itself, as a user calls it."""

from __future__ import annotations

from peers.beamwave import peers_of

SCENE = """\
&beam      length = {p.length!r}, diameter = {p.diameter!r}
           density = {p.density!r}, youngs_modulus = {p.youngs_modulus!r} /
&impact    mass = {p.mass!r} /
&contact   stiffness = {p.stiffness!r}, exponent = 1 /
&modes     tolerance = {tolerance!r} /
&response  duration = {p.duration!r}, samples = {p.samples}, points = {points} /
"""

STAGES, PROCESS = peers_of(SCENE, tuple({"tolerance": 10.0**-power} for power in range(2, 11)), ({"tolerance": 1e-3}, {"tolerance": 1e-6}))
