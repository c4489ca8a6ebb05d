"""Print `lasting_contacts.txt`: contacts of a finite duration, by an integration of its own.

The modes of the paper's beam and a mass beside its tip are integrated with scipy's DOP853, to 1e-13, in steps that the fastest mode
bounds; begins and ends of contacts are events. Modes that are not summed have no part in it: their residual flexibility is 0.
Each row is a contact: its begin and end (s; of one that lasts that of the record), impulse (N s), largest force (N), and the
velocity (m/s) that it leaves the mass.
"""

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, minimize_scalar

LENGTH, DENSITY, MODULUS, DIAMETER = 1.0, 7870.0, 2.0e11, 0.037
AREA = np.pi * DIAMETER**2 / 4
H = DIAMETER / 4 * np.sqrt(MODULUS / DENSITY)
MASS = DENSITY * AREA * LENGTH
HERTZ = 4 / 3 * np.sqrt(0.025) * MODULUS / (2 * 0.91)


def modes(count, omega):
    """Angular frequencies squared of the clamped-free beam, less that of the rotation."""
    roots = [
        brentq(lambda a: 1 / np.cosh(a) + np.cos(a), (k - 1) * np.pi + 0.3, k * np.pi - 0.3 if k > 1 else 2.5, xtol=1e-15)
        for k in range(1, count + 1)
    ]
    return (H * np.array(roots) ** 2) ** 2 - omega**2


def contacts(count, omega, mass, stiffness, exponent, damping, ratio, duration):
    """All contacts of a scene, one row each."""
    square = modes(count, omega)
    shape = 2.0 * (-1.0) ** np.arange(count)
    rate = 2 * ratio * np.sqrt(square + omega**2)
    n = count

    def force(state):
        q, v, y, u = state[:n], state[n : 2 * n], state[2 * n], state[2 * n + 1]
        depth, speed = y - shape @ q, u - shape @ v
        return 0.0 if depth <= 0 else max(0.0, stiffness * depth**exponent * (1 + damping * speed))

    def slope(_, state, pressed):
        f = force(state) if pressed else 0.0
        q, v = state[:n], state[n : 2 * n]
        of_mass = [state[2 * n + 1], omega**2 * state[2 * n] - f / mass, f]
        return np.concatenate([v, -rate * v - square * q + shape * f / MASS, of_mass])

    def depth(_, state, *_args):
        return state[2 * n] - shape @ state[:n]

    def ends(t, state, *args):
        q, v, y, u = state[:n], state[n : 2 * n], state[2 * n], state[2 * n + 1]
        return min(y - shape @ q, (1 + damping * (u - shape @ v)) * DIAMETER) if damping else y - shape @ q

    state = np.zeros(2 * n + 3)
    state[2 * n + 1] = 1.0
    t, rows = 0.0, []
    step = 0.3 / np.sqrt(square[-1])
    small = 1e-12 * duration
    while t < duration:
        # a little way into the contact, so that its begin is not taken for its end
        start = solve_ivp(slope, (t, t + small), state, "DOP853", rtol=1e-13, atol=1e-20, args=(True,))
        before = state[2 * n + 2]
        ends.terminal, ends.direction = True, -1
        run = solve_ivp(slope, (t + small, duration), start.y[:, -1], "DOP853", rtol=1e-13, atol=1e-18, max_step=step,
                        events=ends, args=(True,), dense_output=True)
        end = run.t[-1]
        values = np.array([force(s) for s in run.y.T])
        i = int(values.argmax())
        low, high = run.t[max(0, i - 1)], run.t[min(len(run.t) - 1, i + 1)]
        top = minimize_scalar(lambda x: -force(run.sol(x)), bounds=(low, high), method="bounded", options={"xatol": 1e-13})
        state = run.y[:, -1]
        rows.append((t, end, state[2 * n + 2] - before, -top.fun, state[2 * n + 1]))
        if run.status != 1 or end >= duration or damping:
            break
        gap = lambda time, s, *args: -depth(time, s)
        gap.terminal, gap.direction = True, -1
        state[2 * n] -= 1e-18
        flight = solve_ivp(slope, (end, duration), state, "DOP853", rtol=1e-13, atol=1e-18, max_step=step, events=gap, args=(False,))
        if flight.status != 1:
            break
        t, state = flight.t[-1], flight.y[:, -1]
    return rows


SCENES = [  # modes, omega, mass, stiffness, exponent, damping, modal ratio, duration
    (30, 0.0, 0.51509, HERTZ, 1.5, 0.0, 0.0, 1e-3),
    (30, 0.0, 1.0, 1.0e6, 1.0, 0.0, 0.0, 2e-3),
    (30, 50.0, 1.7, 3.0e9, 1.5, 0.0, 0.02, 2e-3),
    (20, 50.0, 0.2, 1.0e10, 1.5, 0.5, 0.0, 1e-3),
    (20, 180.0, 4.0, 1.0e9, 2.2, 0.0, 0.0, 3e-3),
]

if __name__ == "__main__":
    print("# Contacts of a finite duration of the paper's beam, struck at its tip by a mass (kg) at 1 m/s: F = K d^p (1 + c d')")
    print("scene modes omega mass stiffness exponent damping ratio duration number start end impulse largest mass_velocity")
    for i, scene in enumerate(SCENES, 1):
        for number, row in enumerate(contacts(*scene), 1):
            print(i, *(repr(float(x)) for x in scene), number, *(repr(float(x)) for x in row))
