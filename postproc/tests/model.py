"""The closed-form model in numpy, written apart from the program: what the pictures are tested on.

Lengths in units of the beam's; modal masses in units of the beam's mass; integrals by Gauss quadrature.
"""

import numpy as np

NODES, WEIGHTS = np.polynomial.legendre.leggauss(400)  # exact to rounding for products of shapes up to about mode 60


def roots(count, gamma):
    """Return α_k = P_k l, k = 1 … count, of a beam with tip mass ratio gamma (Eq. 19; Eq. 8 for 0): by bisection."""
    k = np.arange(1, count + 1)
    low = np.where(k == 1, 1e-3, (k - 1) * np.pi + np.pi / 4 - 0.05)
    high = np.where(k == 1, 2.0, (k - 0.5) * np.pi + 0.05)

    def scaled(alpha):
        return 1 / np.cosh(alpha) + np.cos(alpha) + alpha * gamma * (np.cos(alpha) * np.tanh(alpha) - np.sin(alpha))

    below = scaled(low)
    for _ in range(80):
        middle = 0.5 * (low + high)
        same = np.sign(scaled(middle)) == np.sign(below)
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    return 0.5 * (low + high)


def shapes(alpha, xi):
    """Mode shapes (Eqs 7, 9), (mode, xi), in the form that does not overflow."""
    return _parts(alpha, xi, 1)


def curvatures(alpha, xi):
    """Second derivatives of the mode shapes by ξ, (mode, xi)."""
    return alpha[:, None] ** 2 * _parts(alpha, xi, -1)


def _parts(alpha, xi, sign):
    """The trigonometric part times `sign`, and the exponential part, which differentiating twice leaves as it is."""
    a, x = alpha[:, None], np.asarray(xi)[None, :]
    grown = 2 * (np.sin(a) - np.cos(a) - np.exp(-a)) / (1 + 2 * np.sin(a) * np.exp(-a) - np.exp(-2 * a))
    sigma = 1 - grown * np.exp(-a)
    waves = np.cos(a * x) - sigma * np.sin(a * x)
    return sign * waves - 0.5 * (1 + sigma) * np.exp(-a * x) - 0.5 * grown * np.exp(-a * (1 - x))


def bending_constant(beam):
    """Return h = √(EI/(ρA)) of a solid round beam."""
    return beam["diameter"] / 4 * np.sqrt(beam["youngs_modulus"] / beam["density"])


def modes(count, gamma, omega, beam):
    """α, P, β, growth rate, C_p and C_g of one set of modes; NaN where a quantity does not exist."""
    alpha, h = roots(count, gamma), bending_constant(beam)
    p = alpha / beam["length"]
    beta2 = (h * p**2) ** 2 - omega**2
    beta = np.sqrt(np.where(beta2 > 0, beta2, np.nan))
    return {
        "alpha": alpha,
        "wavenumber": p,
        "angular_frequency": beta,
        "growth_rate": np.sqrt(np.maximum(-beta2, 0.0)),
        "phase_velocity": beta / p,
        "group_velocity": 2 * h**2 * p**3 / beta,
    }


def impact(count, gamma, restitution, speed):
    """Jumps of the modal velocities (mode) when a mass at `speed` strikes the tip of `count` clamped-free modes."""
    tip = shapes(roots(count, 0.0), [1.0])[:, 0]
    impulse = (1 + restitution) * speed / (1 / gamma + (tip**2).sum())
    return tip * impulse


def capture(after, before_velocity, gamma):
    """Modal velocities and masses (in units of the beam's mass) after the mass is caught: Eq. 23 by quadrature."""
    xi, weight = np.append(0.5 * (NODES + 1), 1.0), np.append(0.5 * WEIGHTS, gamma)
    shape = shapes(after, xi)
    start = before_velocity @ shapes(roots(before_velocity.size, 0.0), xi)
    mass = (weight * shape**2).sum(axis=1)
    return (weight * shape * start).sum(axis=1) / mass, mass


def histories(alpha, beta2, velocity, points, time):
    """Displacement, velocity and curvature by ξ (point, time) of modes that start with modal velocities (Eq. 29)."""
    rate = np.sqrt(np.abs(beta2))[:, None]
    angle = rate * time
    moving = np.where(beta2[:, None] > 0, np.sin(angle), np.sinh(np.minimum(angle, 700.0))) / rate
    speed = np.where(beta2[:, None] > 0, np.cos(angle), np.cosh(np.minimum(angle, 700.0)))
    weights = (shapes(alpha, points) * velocity[:, None]).T
    return weights @ moving, weights @ speed, (curvatures(alpha, points) * velocity[:, None]).T @ moving
