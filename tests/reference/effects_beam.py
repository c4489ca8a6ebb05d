"""A rotating beam with tension, shear and a body at its tip: references for modes without a closed form.

Lengths in l, times in l^2/h, masses in the beam's mass. Two routes to the same boundary value problem: power series
in xi (any effect), and the exponential of a matrix (no tension).
"""

from dataclasses import dataclass

from mpmath import expm, findroot, matrix, mp, mpf


@dataclass(frozen=True)
class Case:
    omega: float = 0.0
    hub: float | None = None  # None: no tension
    gamma: float = 0.0
    compliance: float = 0.0  # s^2; 0 without shear
    rotary: float = 0.0  # r^2
    inertia: float = 0.0  # J of the body
    in_plane: int = 1

    def tension(self):
        """T = t0 + t1 xi + t2 xi^2."""
        if self.hub is None:
            return [mpf(0)] * 3
        square, hub = mpf(self.omega) ** 2, mpf(self.hub)
        return [square * (mpf(1) / 2 + hub + mpf(self.gamma) * (1 + hub)), -square * hub, -square / 2]

    def loads(self, beta_squared):
        """Factors of v and of psi in the equations of motion."""
        spin = mpf(self.omega) ** 2
        deflection = beta_squared + (spin if self.in_plane else 0)
        turning = mpf(self.rotary) * (beta_squared + (0 if self.in_plane else spin))
        return deflection, turning


def series(case, beta_squared, slope, curvature, terms):
    """Coefficients of v and psi; both vanish at xi = 0. Without shear: v'(0) = 0, v''(0) and v'''(0) as given; with
    shear: v'(0) and psi'(0)."""
    t = case.tension()
    load, turning = case.loads(beta_squared)
    v = [mpf(0)] * (terms + 4)
    psi = [mpf(0)] * (terms + 4)
    if case.compliance == 0:
        v[2], v[3] = curvature / 2, slope / 6
        for k in range(terms):
            # v'''' = (T v')' + ... with the sign of (T v')' - v'''' + load v = 0
            right = load * v[k]
            for m in range(3):
                if k - m + 2 >= 1:
                    right += t[m] * (k + 1) * (k - m + 2) * v[k - m + 2]
            v[k + 4] = right / ((k + 1) * (k + 2) * (k + 3) * (k + 4))
        return v, [(k + 1) * v[k + 1] for k in range(terms + 3)] + [mpf(0)]
    stiff = 1 / mpf(case.compliance)
    v[1], psi[1] = slope, curvature
    for k in range(terms):
        right = stiff * (k + 1) * psi[k + 1] - load * v[k]
        for m in (1, 2):
            if k - m + 2 >= 1:
                right -= t[m] * (k + 1) * (k - m + 2) * v[k - m + 2]
        v[k + 2] = right / ((stiff + t[0]) * (k + 1) * (k + 2))
        psi[k + 2] = (stiff * psi[k] - turning * psi[k] - stiff * (k + 1) * v[k + 1]) / ((k + 1) * (k + 2))
    return v, psi


def at_tip(c, derivative=0):
    total = mpf(0)
    for k in range(derivative, len(c)):
        factor = 1
        for j in range(derivative):
            factor *= k - j
        total += factor * c[k]
    return total


def end_conditions(case, beta_squared, v, psi):
    """Force and moment that the tip lacks."""
    load, _ = case.loads(beta_squared)
    tension = sum(case.tension())
    slope = at_tip(v, 1)
    shear = -at_tip(v, 3) if case.compliance == 0 else (slope - at_tip(psi)) / mpf(case.compliance)
    force = shear + tension * slope - mpf(case.gamma) * load * at_tip(v)
    moment = at_tip(psi, 1) - mpf(case.inertia) * beta_squared * at_tip(psi)
    return force, moment


def series_determinant(case, terms, beta_squared):
    first = end_conditions(case, beta_squared, *series(case, beta_squared, mpf(1), mpf(0), terms))
    second = end_conditions(case, beta_squared, *series(case, beta_squared, mpf(0), mpf(1), terms))
    return first[0] * second[1] - first[1] * second[0]


def shape(case, beta_squared, terms):
    """Coefficients of v of a mode."""
    one = series(case, beta_squared, mpf(1), mpf(0), terms)
    two = series(case, beta_squared, mpf(0), mpf(1), terms)
    a, b = end_conditions(case, beta_squared, *one), end_conditions(case, beta_squared, *two)
    pick = 0 if abs(a[0]) + abs(b[0]) > abs(a[1]) + abs(b[1]) else 1
    mix = [b[pick] * x - a[pick] * y for x, y in zip(one[0], two[0])]
    turn = [b[pick] * x - a[pick] * y for x, y in zip(one[1], two[1])]
    return mix, turn


def mean_square(c):
    total = mpf(0)
    for i, x in enumerate(c):
        if x:
            total += x * sum(y / (i + j + 1) for j, y in enumerate(c) if y)
    return total


def exponential_state(case, beta_squared, xi):
    """Fundamental solution of (v, psi, moment, shear force) up to xi; without tension, with shear."""
    load, turning = case.loads(beta_squared)
    rates = matrix([[0, 1, 0, mpf(case.compliance)], [0, 0, 1, 0], [0, -turning, 0, -1], [-load, 0, 0, 0]])
    return expm(rates * xi)


def exponential_determinant(case, beta_squared):
    y = exponential_state(case, beta_squared, mpf(1))
    load, _ = case.loads(beta_squared)
    rows = [[y[3, j] - mpf(case.gamma) * load * y[0, j], y[2, j] - mpf(case.inertia) * beta_squared * y[1, j]]
            for j in (2, 3)]
    return rows[0][0] * rows[1][1] - rows[0][1] * rows[1][0]


def roots(determinant, low, step, count):
    """The first values of beta^2 at which a determinant vanishes, from its sign where beta^(1/2) = low + i step."""
    def at(i):
        x = mpf(low) + i * mpf(step)
        return x**3 * abs(x)

    found = []
    i = 0
    before = determinant(at(0))
    while len(found) < count:
        after = determinant(at(i + 1))
        if (before < 0) != (after < 0):
            found.append(findroot(determinant, (at(i), at(i + 1)), solver="anderson", tol=mpf(10) ** (20 - mp.dps),
                                  verify=False))
        before = after
        i += 1
    return found

