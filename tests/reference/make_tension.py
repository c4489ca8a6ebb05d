"""Writes tension_modes.txt: modes of beams with tension, by power series."""

from functools import partial
from multiprocessing import Pool

from mpmath import mp

from effects_beam import Case, at_tip, mean_square, roots, series_determinant, shape
from table import write_table

CASES = [
    Case(omega=omega, hub=hub, gamma=gamma, in_plane=in_plane)
    for omega, hub, gamma in [(0.0, 0.0, 0.0), (3.0, 0.0, 0.0), (12.0, 0.0, 0.0), (12.0, 0.5, 0.2), (40.0, 0.0, 0.2),
                              (40.0, 1.0, 1.0), (3.0, 1.0, 100.0)]
    for in_plane in (0, 1)
] + [
    Case(omega=10.0, hub=0.1, gamma=0.2, inertia=0.01, in_plane=in_plane) for in_plane in (0, 1)
] + [
    Case(omega=omega, hub=0.0, gamma=gamma, compliance=2.5e-3, rotary=8e-4, inertia=inertia, in_plane=in_plane)
    for omega, gamma, inertia in [(3.0, 0.0, 0.0), (3.0, 0.2, 0.0), (3.0, 0.2, 0.01)] for in_plane in (0, 1)
]


def rows_of(case):
    terms = 130 + int(5 * case.omega)
    mp.dps = 58 + int(1.2 * case.omega)
    rows = []
    for k, beta_squared in enumerate(roots(partial(series_determinant, case, terms), 0.3, 0.5, 4), 1):
        v, _ = shape(case, beta_squared, terms)
        tip = at_tip(v)
        middle = sum(c / mp.mpf(2) ** i for i, c in enumerate(v))
        rows.append((case.omega, case.hub, case.gamma, case.compliance, case.rotary, case.inertia, case.in_plane, k,
                     beta_squared, middle / tip, mean_square(v) / tip**2))
    print(case, flush=True)
    return rows


mp.dps = 58
with Pool(4) as pool:
    table = [row for rows in pool.map(rows_of, CASES, chunksize=1) for row in rows]
write_table("tension_modes.txt", """
Modes of a rotating beam with tension by power series: beta squared in (h/l^2)^2, the midpoint's displacement over the
tip's, and the mean square of the shape over the tip's square. Without compliance there is no shear.
""", ["omega", "hub", "gamma", "compliance", "rotary", "inertia", "in_plane", "k", "beta_squared", "midpoint", "mean_square"],
            table)
