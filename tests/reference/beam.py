"""The beam and its impact from plain definitions, in hundreds of digits.

Nothing here is written to survive in few digits: cosh is cosh, differences are taken as they stand, and the
working precision pays for it. Lengths in units of the beam's length, masses in units of the beam's mass, speeds
in units of the approach velocity. An input given as a Python float stands for that binary64 number, exactly.
"""

from functools import cache

from mpmath import atan, cos, cosh, exp, log, mp, mpc, mpf, pi, sin, sinh, sqrt, tanh

MASS_RATIOS = [0.0, 1e-300, 1e-12, 1e-6, 0.2, 1.0, 10.0, 1e6, 1e12, 1e300]


def use_digits(digits):
    """Working precision of all that follows. A mass ratio of 1e±300 takes 900 in the least favourable integral."""
    mp.dps = digits
    root.cache_clear()


def frequency_function(alpha, gamma):
    """Eq. 19; Eq. 8 for gamma = 0."""
    s, c, sh, ch = sin(alpha), cos(alpha), sinh(alpha), cosh(alpha)
    return 1 + c * ch + alpha * gamma * (c * sh - s * ch)


def frequency_derivative(alpha, gamma):
    s, c, sh, ch = sin(alpha), cos(alpha), sinh(alpha), cosh(alpha)
    return (1 + gamma) * (c * sh - s * ch) - 2 * alpha * gamma * s * sh


def bracket(k, gamma):
    """An interval that holds root k and no other."""
    if k == 1:
        heavy = (3 / gamma) ** (mpf(1) / 4) if gamma > 1 else mpf(2)  # α₁⁴ → 3/γ from below
        return heavy / 2, heavy
    return (k - 1) * pi + pi / 4 - mpf(1) / 100, (k - mpf(1) / 2) * pi + mpf(1) / 100


@cache
def root(k, gamma):
    """Root k = 1, 2, … of the frequency equation for the binary64 mass ratio gamma."""
    gamma = mpf(gamma)
    low, high = bracket(k, gamma)
    sign = frequency_function(low, gamma) > 0
    assert sign != (frequency_function(high, gamma) > 0)
    for _ in range(40):
        middle = (low + high) / 2
        if (frequency_function(middle, gamma) > 0) == sign:
            low = middle
        else:
            high = middle
    alpha = newton((low + high) / 2, gamma)
    margin = alpha * mpf(10) ** -(mp.dps // 3)
    assert low <= alpha <= high, (k, gamma)
    assert (frequency_function(alpha - margin, gamma) > 0) != (frequency_function(alpha + margin, gamma) > 0), (k, gamma)
    return alpha


def newton(alpha, gamma):
    for _ in range(9):  # 12 digits, doubled each time: more than any use_digits asks for
        alpha -= frequency_function(alpha, gamma) / frequency_derivative(alpha, gamma)
    return alpha


class Shape:
    """Eqs 7 and 18: cos αξ − cosh αξ − σ (sin αξ − sinh αξ)."""

    def __init__(self, k, gamma):
        self.gamma = mpf(gamma)
        a = self.alpha = root(k, gamma)
        self.sigma = (cos(a) + cosh(a)) / (sin(a) + sinh(a))
        # 1 − σ put over one denominator: with cosh and sinh apart it would take 0.87 α digits
        self.one_minus_sigma = (sin(a) - cos(a) - exp(-a)) / (sin(a) + sinh(a))
        self.terms = self.exponentials()
        self.tip = self.value(mpf(1))
        self.tip_slope = self.slope(mpf(1))

    def modal_mass(self):
        """M̄ of Eq. 28 over the beam's mass."""
        return product_integral(self, self) + self.gamma * self.tip**2

    def one_minus_sigma_scaled(self):
        return self.one_minus_sigma * exp(self.alpha)

    def exponentials(self):
        """The shape as a sum of c exp(λ ξ): triples (c, λ, exp λ)."""
        a, s = self.alpha, self.sigma
        pairs = [(mpc(1, s) / 2, mpc(0, a)), (mpc(1, -s) / 2, mpc(0, -a)),
                 (-self.one_minus_sigma / 2, a), (-(1 + s) / 2, -a)]
        return [(c, rate, exp(rate)) for c, rate in pairs]

    def value(self, xi):
        if xi == 0:
            return mpf(0)
        return sum((c * exp(rate * xi) for c, rate, _ in self.terms), mpf(0)).real

    def slope(self, xi):
        return sum((c * rate * exp(rate * xi) for c, rate, _ in self.terms), mpf(0)).real

    def plain_value(self, xi):
        """The definition, with the digits that cosh αξ − σ sinh αξ takes."""
        with mp.workdps(mp.dps + int(self.alpha / log(10))):
            a = newton(self.alpha, self.gamma)
            sigma = (cos(a) + cosh(a)) / (sin(a) + sinh(a))
            return cos(a * xi) - cosh(a * xi) - sigma * (sin(a * xi) - sinh(a * xi))


def product_integral(one, other):
    """∫₀¹ of the product of two shapes, each exponential integrated by itself."""
    total = mpf(0)
    for c, a, end in one.terms:
        for d, b, other_end in other.terms:
            rate = a + b
            total += c * d * ((end * other_end - 1) / rate if rate != 0 else 1)
    return total.real


class Jump:
    """Eqs 11 and 12: a mass strikes the tip of a beam at rest that has its first `count` modes only."""

    def __init__(self, gamma, count, restitution):
        gamma, restitution = mpf(gamma), mpf(restitution)
        mobility = 4 * count  # Σ φ_i(1)²/M_i, each 2² over the beam's mass
        self.impulse = (1 + restitution) / (1 / gamma + mobility)
        self.tip_velocity = mobility * self.impulse
        self.mass_velocity = 1 - self.impulse / gamma
        assert abs(self.tip_velocity - self.mass_velocity - restitution) < mpf(10) ** -(mp.dps // 2)


def velocity_terms(shape, free_shapes, restitution=0):
    """The terms of Eq. 26, one for each mode that the impact sets in motion.

    The beam moves as the sum of its modes, Δq̇_i = φ_i(1) H; the mass moves with the tip."""
    impulse = Jump(shape.gamma, len(free_shapes), restitution).impulse
    scale = impulse / shape.modal_mass()
    return [free.tip * scale * (product_integral(shape, free) + shape.gamma * shape.tip * free.tip)
            for free in free_shapes]


def modal_velocity(shape, free_shapes, restitution=0):
    """Eq. 26: the velocity of one mode after the capture, from the field that the impact leaves."""
    return sum(velocity_terms(shape, free_shapes, restitution), mpf(0))


def clamped_pinned_root(k):
    """Root k of tan α = tanh α: the tip held in place by an endless mass."""
    middle = k * pi + pi / 4
    for _ in range(mp.dps):  # gains 3 digits a step for k = 1, more beyond
        middle = k * pi + atan(tanh(middle))
    return middle


class PaperBeam:
    """The steel rod of the paper, length 1 m: its frequencies from the binary64 data."""

    def __init__(self, diameter=0.037, youngs_modulus=2e11, density=7870.0):
        # h = sqrt(E I/(ρ A)), and I/A = (D/4)² for a solid circle
        self.h = mpf(diameter) / 4 * sqrt(mpf(youngs_modulus) / mpf(density))

    def beta_squared(self, alpha, omega):
        """Eqs 9 and 30, rad²/s²."""
        return self.h**2 * alpha**4 - mpf(omega) ** 2

    def critical_speed(self, gamma, k=1):
        """The angular velocity at which mode k has no frequency, rad/s."""
        return self.h * root(k, gamma) ** 2


def sine_like(beta_squared, time):
    """S: sin βt/β, or sinh |β|t/|β| where β² is negative."""
    beta = sqrt(abs(beta_squared))
    return (sin(beta * time) if beta_squared > 0 else sinh(beta * time)) / beta


def cosine_like(beta_squared, time):
    """C: cos βt, or cosh |β|t where β² is negative."""
    beta = sqrt(abs(beta_squared))
    return cos(beta * time) if beta_squared > 0 else cosh(beta * time)
