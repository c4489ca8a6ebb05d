"""The paper's beam from its equations: roots by bisection, modal integrals by quadrature, histories by plain sums."""

import numpy as np


def bisect(function, low, high):
    """The root of `function` between arrays `low` and `high`, to the last bit."""
    sign = np.sign(function(low))
    assert (sign != np.sign(function(high))).all()
    for _ in range(80):
        middle = (low + high) / 2
        left = np.sign(function(middle)) == sign
        low, high = np.where(left, middle, low), np.where(left, high, middle)
    return (low + high) / 2


def roots(count, mass_ratio):
    """α of the first modes, in the mass ratio's precision: Eq. 19, Eq. 8 for mass ratio 0, divided by cosh α."""

    def frequency_equation(alpha):
        shear = alpha * mass_ratio * (np.cos(alpha) * np.tanh(alpha) - np.sin(alpha))
        return 2 * np.exp(-alpha) / (1 + np.exp(-2 * alpha)) + np.cos(alpha) + shear

    k = np.arange(1, count + 1, dtype=np.result_type(mass_ratio, float))
    low = np.where(k == 1, 1e-3, (k - 0.75) * np.pi - 0.01)
    return bisect(frequency_equation, low, (k - 0.5) * np.pi + np.where(k == 1, 0.6, 0.02))


def shapes(alpha, position, order=0):
    """Eqs 7 and 18, (positions, modes), with e^(αξ) joined to the small factor before it; `order` 2 gives their second derivatives."""
    xi = np.asarray(position)[:, np.newaxis]
    scale = np.exp(-alpha)
    growing = (np.sin(alpha) - np.cos(alpha) - scale) / ((1 - scale**2) / 2 + np.sin(alpha) * scale)  # (1 − σ) e^α
    sigma = 1 - growing * scale
    turning = np.cos(alpha * xi) - sigma * np.sin(alpha * xi)
    hyperbolic = ((1 + sigma) * np.exp(-alpha * xi) + growing * np.exp(alpha * (xi - 1))) / 2
    return turning - hyperbolic if order == 0 else -(alpha**2) * (turning + hyperbolic)


class CapturedBeam:
    """Beam and captured mass, SI; V = 1 m/s, e = 0."""

    def __init__(
        self, mass_ratio, angular_velocity, before, after, diameter=0.037, youngs_modulus=2e11, density=7870.0
    ):
        self.h = diameter / 4 * np.sqrt(youngs_modulus / density)
        self.mass_ratio = mass_ratio
        self.angular_velocity = angular_velocity
        self.alpha_before = roots(before, 0.0)
        self.alpha = roots(after, mass_ratio)

    def frequency(self, alpha):
        """Eqs 9 and 30, rad/s."""
        return np.sqrt((self.h * alpha**2) ** 2 - self.angular_velocity**2)

    def phase_velocity(self, alpha):
        """Eq. 32, m/s."""
        return self.frequency(alpha) / alpha

    def group_velocity(self, alpha):
        """Eq. 33: dβ/dP of Eq. 2, m/s."""
        return 2 * self.h**2 * alpha**3 / self.frequency(alpha)

    def modal_velocity(self):
        """Eq. 26 with its integrals by Gauss and Legendre, m/s."""
        point, weight = np.polynomial.legendre.leggauss(400)
        point, weight = (point + 1) / 2, weight / 2
        free, loaded = shapes(self.alpha_before, point), shapes(self.alpha, point)
        free_tip, tip = shapes(self.alpha_before, [1.0])[0], shapes(self.alpha, [1.0])[0]
        impulse = 1 / (1 / self.mass_ratio + np.sum(free_tip**2))
        after_impact = free @ (free_tip * impulse), free_tip @ (free_tip * impulse)
        momentum = loaded.T @ (weight * after_impact[0]) + self.mass_ratio * tip * after_impact[1]
        return momentum / (weight @ loaded**2 + self.mass_ratio * tip**2)

    def displacement(self, position, time):
        """Eqs 13 and 29, m, (positions, times)."""
        beta = self.frequency(self.alpha)
        return shapes(self.alpha, position) * (self.modal_velocity() / beta) @ np.sin(np.outer(beta, time))
