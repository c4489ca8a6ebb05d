"""Writes turning_speeds.txt: angular velocities at which the sections of a beam with shear turn over out of the plane of rotation.

There beta^2 = 0 solves the whole boundary value problem, by power series, with and without tension; that no lower speed does is
seen from the determinant's sign on the way.
"""

from mpmath import findroot, mp, mpf, pi, sqrt

from effects_beam import Case, series_determinant
from table import write_table

COEFFICIENT = 2.6 / 0.886  # s^2/r^2 of Poisson's ratio 0.3
CASES = [  # tension, hub, gamma, r^2, terms
    (0, 0.0, 0.0, 8e-4, 300),
    (0, 0.0, 0.2, 8e-4, 300),
    (1, 0.0, 0.2, 0.01, 400),
    (1, 0.0, 0.2, 8e-4, 900),
    (1, 0.5, 1.0, 8e-4, 700),
    (1, 1.0, 0.05, 2e-4, 3500),
    (1, 0.0, 0.0, 0.02, 6000),
    (1, 2.0, 1e6, 8e-4, 500),
]


def speed(tension, hub, gamma, rotary, terms):
    compliance = COEFFICIENT * rotary

    def determinant(omega):
        case = Case(omega=omega, hub=hub if tension else None, gamma=gamma, compliance=compliance, rotary=rotary, in_plane=0)
        return series_determinant(case, terms, mpf(0))

    unheld = pi / 2 / sqrt(mpf(rotary))
    if not tension:
        assert abs(determinant(unheld)) < mpf(10) ** -40
        return unheld
    top = sqrt((pi**2 / 4 + 1 / mpf(compliance)) / mpf(rotary))  # shear alone
    samples = [unheld / 2 + (top - unheld / 2) * i / 60 for i in range(62)]
    signs = [determinant(omega) > 0 for omega in samples]
    change = next(i for i in range(61) if signs[i] != signs[i + 1])
    return findroot(determinant, (samples[change], samples[change + 1]), solver="anderson", tol=mpf(10) ** (20 - mp.dps),
                    verify=False)


def rows():
    for tension, hub, gamma, rotary, terms in CASES:
        mp.dps = 60 + int(1.3 / (COEFFICIENT * rotary) ** 0.5)
        yield tension, hub, gamma, COEFFICIENT * rotary, rotary, speed(tension, hub, gamma, rotary, terms)
        print(tension, hub, gamma, rotary, flush=True)


write_table("turning_speeds.txt", """
Lowest angular velocity (h/l^2) at which a mode of a beam with shear grows out of the plane of rotation, with tension where
`tension` is 1
""", ["tension", "hub", "gamma", "compliance", "rotary", "omega"], rows())
