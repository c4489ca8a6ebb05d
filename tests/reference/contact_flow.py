"""Motion of uncoupled parts u'' + c u' + s u = 0, sums of it, and the times at which a sum falls to zero, in a hundred digits.

Zeros are found by dense sampling, in binary64 where the sum is wide and in full precision near its start and where it nearly
vanishes, and then by Newton's method.
"""

import numpy as np
from mpmath import cosh, exp, mp, mpf, sinh, sqrt

BLOCK = 2048  # samples looked at together
WIDE = 1e-8  # of what the parts of a sum amount to: binary64 sees its sign


class Flow:
    """Parts u'' + c u' + s u = 0 from a state, and sums of them."""

    def __init__(self, squares, damping, place, rate):
        self.squares, self.damping, self.place, self.rate = squares, damping, list(place), list(rate)
        self.turning = [s - c * c / 4 for s, c in zip(squares, damping)]
        self.roots = [sqrt(abs(t)) for t in self.turning]

    def at(self, time):
        """Displacements and velocities."""
        places, rates = [], []
        for s, c, turning, root, u, v in zip(self.squares, self.damping, self.turning, self.roots, self.place, self.rate):
            if turning > 0:
                co, si = mp.cos_sin(root * time)
                si = si / root
            elif turning < 0:
                co, si = cosh(root * time), sinh(root * time) / root
            else:
                co, si = mpf(1), time
            w = v + c * u / 2
            place, rate = u * co + w * si, w * co - turning * u * si
            if c:
                decay = exp(-c * time / 2)
                place, rate = decay * place, decay * rate - c * decay * place / 2
            places.append(place)
            rates.append(rate)
        return places, rates

    def accelerations(self, places, rates):
        return [-c * v - s * u for s, c, u, v in zip(self.squares, self.damping, places, rates)]


class Signal:
    """A weighted sum of displacements and velocities of a flow."""

    def __init__(self, flow, by_place, by_rate=None):
        self.flow, self.by_place = flow, by_place
        self.by_rate = by_rate or [mpf(0)] * len(by_place)

    def value_slope_size(self, time):
        """The sum, its rate, and what its parts amount to."""
        places, rates = self.flow.at(time)
        bends = self.flow.accelerations(places, rates)
        parts = [a * u + b * v for a, b, u, v in zip(self.by_place, self.by_rate, places, rates)]
        slope = sum(a * v + b * w for a, b, v, w in zip(self.by_place, self.by_rate, rates, bends))
        return sum(parts), slope, sum(abs(part) for part in parts)

    def value(self, time):
        return self.value_slope_size(time)[0]

    def start_values(self):
        """For binary64: squares, damping, displacement and velocity of every part of the sum."""
        flow = self.flow
        bends = flow.accelerations(flow.place, flow.rate)
        place = [a * u + b * v for a, b, u, v in zip(self.by_place, self.by_rate, flow.place, flow.rate)]
        rate = [a * v + b * w for a, b, v, w in zip(self.by_place, self.by_rate, flow.rate, bends)]
        return [np.array([float(x) for x in values]) for values in (flow.turning, flow.damping, place, rate)]

    def samples(self, times):
        """Sums and sizes of their parts in binary64."""
        turning, damping, place, rate = self.start_values()
        root = np.sqrt(np.abs(turning))[:, None]
        phase = root * times
        with np.errstate(over="ignore", invalid="ignore"):
            co = np.where(turning[:, None] > 0, np.cos(phase), np.cosh(phase))
            si = np.where(turning[:, None] > 0, np.sin(phase), np.sinh(phase)) / np.where(root > 0, root, 1)
        si = np.where(root > 0, si, times)
        parts = (place[:, None] * co + (rate + damping * place / 2)[:, None] * si) * np.exp(-damping[:, None] / 2 * times)
        return parts.sum(axis=0), np.abs(parts).sum(axis=0)

    def polish(self, low, high):
        """The zero between two times, positive before and negative after."""
        time = (low + high) / 2
        for _ in range(400):
            value, slope, size = self.value_slope_size(time)
            low, high = (time, high) if value > 0 else (low, time)
            step = -value / slope if slope < 0 else mpf(0)
            closer = time + step
            if slope >= 0 or not low <= closer <= high:
                step, closer = None, (low + high) / 2
            if step is not None and abs(step) < (time + size / -slope) * mpf(10) ** (4 - mp.dps):
                return closer
            if high - low < time * mpf(10) ** (6 - mp.dps):
                return closer
            time = closer
        raise ArithmeticError("no zero found")

    def lowest(self, low, high):
        """The least value between two times, by golden section and parabolas: the time."""
        for _ in range(60 + 3 * mp.dps):
            a, b = low + (high - low) * mpf("0.382"), low + (high - low) * mpf("0.618")
            fa, fb = self.value(a), self.value(b)
            if min(fa, fb) < 0:
                return a if fa < fb else b
            low, high = (low, b) if fa < fb else (a, high)
            if high - low < high * mpf(10) ** (-mp.dps // 2):
                break
        return (low + high) / 2

    def first_fall(self, end, step, first):
        """The first time at which the sum falls to zero, after `first`, by which it has risen above zero; None: never."""
        low, time = self.rise(end, step, first)
        while time is None and low < end:
            low, time = self.look_through(low, end, step)
        return None if time is None or time > end else time

    def rise(self, end, step, first):
        """From `first` in full precision until binary64 sees the sum: how far that is, and the zero if there is one before."""
        low = first
        value = self.value(low)
        assert value > 0
        sizes = self.samples(np.array([0.0, float(step), float(end)]))[1]
        while low < step or value < WIDE * sizes.max():
            high = min(low * mpf(5) / 4, low + step, end)
            after = self.value(high)
            if after <= 0:
                return low, self.polish(low, high)
            if high >= end:
                return end, None
            low, value = high, after
            if low > 40 * step:
                break
        return low, None

    def look_through(self, low, end, step):
        """One block of samples from `low`: where it ends, and the first zero in it if there is one."""
        times = low + step * (np.arange(BLOCK + 2) - 1)  # mpf in an array
        values, sizes = self.samples(np.array([float(t) for t in times]))
        unsure = np.abs(values) < WIDE * sizes
        for i in range(1, BLOCK + 1):
            if times[i + 1] <= low:
                continue
            if unsure[i] or (i + 1 <= BLOCK and unsure[i + 1]):
                values[i], values[i + 1] = float(self.value(times[i])), float(self.value(times[i + 1]))
            if times[i] > end:
                return end, None
            if values[i] > 0 and values[i + 1] <= 0:
                return end, self.polish(max(times[i], low), times[i + 1])
            if values[i] <= values[i - 1] and values[i] <= values[i + 1] and times[i - 1] >= low:
                bend = values[i - 1] + values[i + 1] - 2 * values[i]
                if values[i] < bend:  # the parabola through the three may dip below zero
                    lowest = self.lowest(times[i - 1], times[i + 1])
                    if self.value(lowest) < 0:
                        return end, self.polish(times[i - 1], lowest)
        return times[BLOCK + 1], None
