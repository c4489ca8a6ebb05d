"""Writes energies.txt: beam and body before and after a captured body leaves, energies from the Lagrangian.

The fields v and psi of beam and body are power series, moved on in their modes; each energy is the integral of the fields
that the Lagrangian of a rotating frame names, none of them a sum over modes:

- kinetic, of deflection and turning: rho A v'^2/2 and rho I psi'^2/2 along the beam, m and J at its end;
- elastic, of curvature and shear strain;
- what the rotation keeps beside the kinetic energy in the frame. In plane -m omega^2 v^2/2 of all that moves; a section or body
  that turns in plane has (omega + psi')^2, which leaves nothing. Out of plane a section that turns comes nearer the axis
  of rotation, -rho I omega^2 psi^2/2; an isotropic body does not. The end of a beam that deflects is drawn inwards, against
  the centrifugal force of all that lies beyond: T v'^2/2 along the beam.
"""

from functools import partial

from mpmath import mp, mpf

from beam import cosine_like, sine_like
from effects_beam import Case, at_tip, roots, series_determinant, shape
from table import write_table

BEFORE, AFTER = 6, 5
SHEAR = {"compliance": 2.5e-3, "rotary": 8e-4}
LEAVES = [0.3, 2.0]
CASES = [
    Case(omega=omega, gamma=0.2, in_plane=in_plane, **effects)
    for omega, effects in [
        (2.0, {}),
        (2.0, {"hub": 0.3}),
        (2.0, {**SHEAR}),
        (2.0, {"inertia": 0.05}),
        (3.0, {"hub": 0.0, "inertia": 0.12}),
        (3.0, {"hub": 0.3, "inertia": 0.05, **SHEAR}),
    ]
    for in_plane in (1, 0)
] + [Case(omega=8.0, gamma=0.2), Case(omega=8.0, gamma=0.2, inertia=0.05), Case(omega=8.0, gamma=0.2, **SHEAR)]
TERMS = 170
GROWN = 9.0  # when modes that grow have e^140 of their energy at the start


def inner(f, g):
    """∫₀¹ fg dξ of two series."""
    total = mpf(0)
    for i, x in enumerate(f):
        if x:
            total += x * sum(y / (i + j + 1) for j, y in enumerate(g) if y)
    return total


def slope_of(f):
    return [k * f[k] for k in range(1, len(f))]


def times(f, g):
    product = [mpf(0)] * (len(f) + len(g) - 1)
    for i, x in enumerate(f):
        for j, y in enumerate(g):
            product[i + j] += x * y
    return product


def added(fields, amounts):
    """Series of a sum of shapes, deflection and turning."""
    return [[sum(a * field[part][k] for a, field in zip(amounts, fields)) for k in range(len(fields[0][part]))]
            for part in (0, 1)]


def beam_product(case, one, other):
    """What of the kinetic energy is along the beam: twice that of the fields `one` and `other` together."""
    return inner(one[0], other[0]) + mpf(case.rotary) * inner(one[1], other[1])


def body_product(case, one, other):
    return (mpf(case.gamma) * at_tip(one[0]) * at_tip(other[0])
            + mpf(case.inertia) * at_tip(one[1]) * at_tip(other[1]))


def beam_potential(case, field):
    """Of the beam's own energy what deflection and turning have; the tension is that of `case`."""
    v, psi = field
    bend, slope, spin = slope_of(psi), slope_of(v), mpf(case.omega) ** 2
    energy = inner(bend, bend) + inner(times(case.tension(), slope), slope)
    if case.compliance:
        strain = [a - b for a, b in zip(slope, psi)]
        energy += inner(strain, strain) / mpf(case.compliance)
    if case.in_plane:
        return (energy - spin * inner(v, v)) / 2
    return (energy - spin * mpf(case.rotary) * inner(psi, psi)) / 2


def body_potential(case, field):
    """Of a body that moves by itself: in plane the centrifugal force acts on its deflection."""
    return -mpf(case.gamma) * mpf(case.omega) ** 2 * at_tip(field[0]) ** 2 / 2 if case.in_plane else mpf(0)


def modes_of(case, count):
    """beta^2 and (v, psi) of the first modes."""
    low = -3.2 if case.in_plane and case.hub is None else 0.3
    for square in roots(partial(series_determinant, case, TERMS), low, 0.45, count):
        v, psi = shape(case, square, TERMS)
        tip = at_tip(v)
        yield square, ([c / tip for c in v], [c / tip for c in psi])


def rows_of(case):
    alone = Case(**{**vars(case), "gamma": 0.0, "inertia": 0.0})
    free, loaded = list(modes_of(alone, BEFORE)), list(modes_of(case, AFTER))
    masses = [beam_product(alone, field, field) for _, field in free]
    blow = 1 / (1 / mpf(case.gamma) + sum(1 / mass for mass in masses))  # tips of all shapes are 1
    struck = added([field for _, field in free], [blow / mass for mass in masses])
    point = Case(**{**vars(case), "inertia": 0.0})  # the body arrives without spin
    speeds = [(beam_product(case, field, struck) + body_product(point, field, struck))
              / (beam_product(case, field, field) + body_product(case, field, field)) for _, field in loaded]
    shapes = [field for _, field in loaded]
    for time in LEAVES + ([GROWN] if loaded[0][0] < 0 else []):
        place = added(shapes, [q * sine_like(square, mpf(time)) for q, (square, _) in zip(speeds, loaded)])
        rate = added(shapes, [q * cosine_like(square, mpf(time)) for q, (square, _) in zip(speeds, loaded)])
        motion = (beam_product(case, rate, rate) + body_product(case, rate, rate)) / 2
        before = motion + beam_potential(case, place) + body_potential(case, place)
        inwards = beam_potential(case, place) - beam_potential(alone, place)  # work against the body's own tension
        kinetic = body_product(case, rate, rate) / 2
        leaving = kinetic + body_potential(case, place) + inwards
        kept = [added([field for _, field in free], [beam_product(alone, field, state) / mass
                                                     for mass, (_, field) in zip(masses, free)])
                for state in (place, rate)]
        after = leaving + beam_product(alone, kept[1], kept[1]) / 2 + beam_potential(alone, kept[0])
        yield (case.omega, int(case.hub is not None), case.hub or 0.0, case.gamma, case.compliance, case.rotary,
               case.inertia, case.in_plane, BEFORE, AFTER, time, before, after, leaving, kinetic)
    print(case, flush=True)


if __name__ == "__main__":
    mp.dps = 130
    write_table("energies.txt", """
A body strikes the tip of a beam at rest with speed 1 and restitution 0, is captured and leaves again at `time` (l^2/h):
energies of beam and body before and after it leaves, what it takes with it and what of that is motion, in the beam's mass
times the square of that speed; modes before and after the capture as named
""", ["omega", "tension", "hub", "gamma", "compliance", "rotary", "inertia", "in_plane", "before", "after", "time",
              "energy_before", "energy_after", "energy_leaving", "kinetic_leaving"],
                [row for case in CASES for row in rows_of(case)])
