"""Cases per second of sweeps over the angular velocity and the mass ratio, beside what else one could write."""
