"""Writes heavy_modes.txt: modes without a closed form of a beam with a very heavy body at its tip, by power series.

The body's own mode has beta^2 + omega^2 (out of plane beta^2) near 3/gamma, or with tension near that of a pendulum; the others
are near those of a beam whose tip is held. Its shape is that of a load at the tip, theirs move the tip by 1/gamma.
"""

from functools import partial
from math import log10
from multiprocessing import Pool

from mpmath import findroot, mp, mpf, sqrt

from effects_beam import Case, at_tip, mean_square, series_determinant, shape
from table import write_table

MODES = 5
WITHOUT_TENSION = [
    Case(omega=omega, gamma=gamma, in_plane=in_plane, **effects)
    for gamma in (1e2, 1e4, 1e8, 1e12, 1e24, 1e60, 1e300)
    for omega, in_plane, effects in [
        (1.5, 1, {"inertia": 0.01}),
        (1.5, 0, {"inertia": 1.0}),
        (1.5, 1, {"compliance": 2.5e-3, "rotary": 8e-4}),
        (1.5, 0, {"compliance": 2.5e-3, "rotary": 8e-4, "inertia": 0.01}),
        (20.0, 0, {"compliance": 2.5e-3, "rotary": 8e-4}),
    ]
]
TURNING = [  # bodies that are hard to turn
    Case(omega=1.5, gamma=gamma, inertia=inertia, in_plane=in_plane, **effects)
    for gamma, inertia in [(0.2, 1e4), (0.2, 1e12), (1e12, 1e10), (1e12, 1e12), (1e4, 1e24), (1e60, 1e59)]
    for in_plane, effects in [(1, {}), (0, {}), (0, {"compliance": 2.5e-3, "rotary": 8e-4})]
]
WITH_TENSION = [
    Case(omega=omega, hub=hub, gamma=gamma, in_plane=in_plane, **effects)
    for omega, hub, gamma, effects in [
        (3.0, 0.0, 1e2, {}),
        (3.0, 0.5, 1e3, {}),
        (3.0, 0.0, 1e3, {"inertia": 0.01}),
        (3.0, 0.0, 1e3, {"compliance": 2.5e-3, "rotary": 8e-4}),
        (1.0, 0.0, 1e5, {}),
        (0.01, 0.0, 1e8, {}),
        (1e-4, 0.3, 1e12, {}),
    ]
    for in_plane in (1, 0)
]


def pull(case):
    return float(case.tension()[0])


def settings(case):
    """Terms of the series and digits: solutions grow as e^(alpha), with tension as e^(sqrt(T)); what is left at a tip that is
    held, 1/gamma, is their difference."""
    growth = pull(case) ** 0.5
    if case.compliance:
        growth /= (1 + case.compliance * pull(case)) ** 0.5
    mp.dps = 80 + int(growth + 2.2 * log10(max(case.gamma, 1)) + 2.2 * log10(max(case.inertia, 1)))
    return 120 + int(4.5 * growth) + mp.dps // 2


def places(case):
    """Values of beta^2 between which no two modes lie. Those of a heavy body are near 1/gamma and 1/J, from 0 or from
    -omega^2. With shear waves of either kind have modes of their own, which lie as near each other as they like."""
    spin = mpf(case.omega) ** 2 if case.in_plane else mpf(0)
    small = [0, *(-int(log10(load)) for load in (case.gamma, case.inertia) if load > 1)]
    thirds = sorted({third for power in small for third in range(3 * power - 9, 3 * power + 10)})
    decades = [mpf(10) ** (mpf(third) / 3) for third in thirds]
    near = sorted({*(-spin + decade for decade in decades), *decades, *(-decade for decade in decades)})
    most = mpf(1) if case.hub is None else spin + sum(case.tension()) / mpf(case.gamma)  # that of a pendulum
    step = mpf("0.1") if case.compliance else mpf("0.3") + mpf(pull(case)) ** mpf("0.25") / 30
    return sorted([square for square in near if -spin < square < most] + [(1 + i * step) ** 4 for i in range(1000)])


def squares_of(case, determinant):
    """beta^2 of the first modes."""
    found = []
    squares = places(case)
    before = determinant(squares[0])
    for low, high in zip(squares, squares[1:]):
        after = determinant(high)
        if (before < 0) != (after < 0):
            root = findroot(determinant, (low, high), solver="anderson", tol=mpf(10) ** -mp.dps, verify=False)
            if not low <= root <= high:
                raise ValueError(f"{case}: {root} is not between {low} and {high}")
            found.append(root)
            if len(found) == MODES:
                return found
        before = after
    raise ValueError(case)


def rows_of(case):
    terms = settings(case)
    rows = []
    for k, square in enumerate(squares_of(case, partial(series_determinant, case, terms)), 1):
        v, _ = shape(case, square, terms)
        tip = at_tip(v)
        middle = sum(c / mpf(2) ** i for i, c in enumerate(v))
        size = mean_square(v)
        rows.append((case.omega, int(case.hub is not None), case.hub or 0.0, case.gamma, case.compliance, case.rotary,
                     case.inertia, case.in_plane, k, square, middle**2 / size, abs(tip) / sqrt(size) * mpf(case.gamma)))
    print(case, flush=True)
    return rows


if __name__ == "__main__":
    with Pool(2) as pool:
        table = [row for rows in pool.map(rows_of, WITHOUT_TENSION + TURNING + WITH_TENSION, chunksize=1) for row in rows]
    write_table("heavy_modes.txt", """
Modes of a rotating beam with a heavy body at its tip: beta squared in (h/l^2)^2, the square of the displacement at the
midpoint over the mean square of the shape, and the displacement at the tip times the mass ratio over its root. Without
compliance there is no shear.
""", ["omega", "tension", "hub", "gamma", "compliance", "rotary", "inertia", "in_plane", "k", "beta_squared", "midpoint",
              "tip"], table)
