"""What a user would write instead: roots and shapes in numpy, the sum by FINUFFT, on one core.

Without dimensions: lengths in l, times in l²/h; the mass comes with velocity 1 and stays.
"""
import numpy as np
from peers.beam import roots, shapes, tips_and_masses

try:
    import finufft
except ImportError:  # its times and errors are left out
    finufft = None

FEW = 16  # modes; beyond them sech α is below rounding


def modes(n, gamma):
    """Frequencies, velocities and midpoint and tip shapes of n modes; most without an exponential."""
    alpha = roots(n, gamma)
    delta = alpha - (np.arange(1, n + 1) - 0.75)*np.pi
    tip, sine = np.empty(n), np.sin(delta)
    tip[0::2], tip[1::2] = -np.sqrt(8)*sine[0::2], np.sqrt(8)*sine[1::2]
    mass = 1 + 2*gamma*sine**2
    middle = np.sqrt(2)*np.cos(0.5*alpha + 0.25*np.pi)
    near = slice(FEW, min(n, 2*FEW))
    middle[near] += (0.5*tip[near] - 1)*np.exp(-0.5*alpha[near])
    low = alpha[:FEW]
    tip[:FEW], mass[:FEW] = tips_and_masses(low, gamma)
    middle[:FEW] = shapes(low, 0.5)
    return alpha**2, gamma*tip/mass, middle, tip


class Transform:
    """Histories at two points; the fastest of FINUFFT's ways for the size, found by trying them. Its coarser grid, upsampfac
    1.25, is not among them: the width of its kernel is cut there, and it is off by 6e-10 to 9e-10 of the peak."""

    ways = ('pair', 'both sides')

    def __init__(self, samples, step, eps):
        self.samples, self.step, self.eps = samples, step, eps
        self.way = self.ways[0]

    def __call__(self, beta, rate, middle, tip):
        amplitude = rate/beta
        options = dict(eps=self.eps, isign=1, nthreads=1, upsampfac=2.0)
        if self.way == 'pair':                             # two transforms, times 0 … T
            half = self.samples//2
            turn = np.exp(1j*np.fmod(beta*(half*self.step), 2*np.pi))*amplitude
            sums = finufft.nufft1d1(np.fmod(beta*self.step, 2*np.pi), np.stack([middle*turn, tip*turn]), self.samples,
                                    **options)
            return sums.imag
        both = finufft.nufft1d1(np.fmod(beta*self.step, 2*np.pi), amplitude*(middle + 1j*tip), 2*self.samples, **options)
        after, before = both[self.samples:], np.r_[both[self.samples:self.samples + 1], both[self.samples - 1:0:-1]]
        return np.stack([0.5*(after - before).imag, -0.5*(after - before).real])   # times −T … T: sines are odd

    def choose(self, seconds, *arguments):
        """Try all ways and keep the fastest; `seconds` times a call."""
        prices = {}
        for self.way in self.ways:
            prices[self.way] = min(seconds(lambda: self(*arguments)) for _ in range(3))
        self.way = min(prices, key=prices.get)


def job(n, gamma, transform):
    return transform(*modes(n, gamma))
