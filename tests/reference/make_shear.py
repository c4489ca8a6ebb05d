"""Writes shear_modes.txt: modes of beams with shear and without tension, by the exponential of a matrix."""

from functools import partial

from mpmath import mp, mpf

from effects_beam import Case, exponential_determinant, exponential_state, roots
from table import write_table

SLENDER = [(0.125, 0.886), (0.00925, 0.886)]  # r, shear coefficient


def beams():
    for r, coefficient in SLENDER:
        rotary = r * r
        compliance = 2.6 / coefficient * rotary
        for omega, in_plane in [(0.0, 1), (1.5, 1), (1.5, 0)]:
            for gamma, inertia in [(0.0, 0.0), (0.2, 0.0), (0.2, 0.01), (1.0, 1.0)]:
                yield Case(omega=omega, gamma=gamma, compliance=compliance, rotary=rotary, inertia=inertia,
                           in_plane=in_plane)


def midpoint(case, beta_squared):
    """Displacement at the midpoint over that at the tip."""
    whole, half = exponential_state(case, beta_squared, mpf(1)), exponential_state(case, beta_squared, mpf(1) / 2)
    load, _ = case.loads(beta_squared)
    lacking = [whole[3, j] - mpf(case.gamma) * load * whole[0, j] for j in (2, 3)]
    tip = lacking[1] * whole[0, 2] - lacking[0] * whole[0, 3]
    return (lacking[1] * half[0, 2] - lacking[0] * half[0, 3]) / tip


def rows():
    mp.dps = 65
    for case in beams():
        step = 0.09 if case.rotary > 1e-3 else 0.45
        for k, beta_squared in enumerate(
            roots(partial(exponential_determinant, case), -1.3 if case.in_plane and case.omega else 0.2, step, 6), 1
        ):
            yield (case.omega, case.gamma, case.compliance, case.rotary, case.inertia, case.in_plane, k, beta_squared,
                   midpoint(case, beta_squared))
        print(case, flush=True)


write_table("shear_modes.txt", """
Modes of a rotating beam with shear and rotary inertia by the exponential of a matrix: beta squared in (h/l^2)^2, and
the midpoint's displacement over the tip's
""", ["omega", "gamma", "compliance", "rotary", "inertia", "in_plane", "k", "beta_squared", "midpoint"], list(rows()))
