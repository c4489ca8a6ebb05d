"""Writes damped_motion.txt: one damped mode from the matrix exponential of its two first-order equations."""

from mpmath import expm, matrix, mp, mpf

from table import write_table

STATE = (0.75, -2.0)
MODES = [  # beta squared, damping
    (100.0, 0.25), (1e8, 5.0), (4.0, 0.0), (25.0, 9.999999), (25.0, 10.0), (25.0, 10.000000001), (25.0, 10.5),
    (1.0, 50.0), (1e6, 1e5), (0.0, 1.0), (0.0, 0.0), (-9.0, 0.5), (-9.0, 0.0), (-1e-6, 2.0), (-1e-10, 1e-8),
]  # fmt: skip
TIMES = (0.0, 0.0009765625, 0.375, 2.5, 40.0)


def state_at(beta_squared, damping, time):
    rates = matrix([[0, 1], [-mpf(beta_squared), -mpf(damping)]])
    return expm(rates * mpf(time)) * matrix([mpf(value) for value in STATE])


mp.dps = 400  # e^(±4e6) times what cancels between them
rows = []
for beta_squared, damping in MODES:
    for time in TIMES:
        displacement, velocity = state_at(beta_squared, damping, time)
        if abs(displacement) > mpf(10) ** -290:
            energy = velocity**2 + beta_squared * displacement**2
            rows.append((beta_squared, damping, time, displacement, velocity, energy))
write_table("damped_motion.txt", f"""
Displacement and velocity of q'' + c q' + beta_squared q = 0 from q = {STATE[0]}, q' = {STATE[1]}, and q'^2 + beta_squared q^2;
rows that would be below the range of binary64 are left out
""", ["beta_squared", "c", "time", "displacement", "velocity", "energy"], rows)
