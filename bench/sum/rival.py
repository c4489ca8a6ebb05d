"""What a user would write instead: roots and shapes in numpy, the sum by FINUFFT, on one core.

Without dimensions: lengths in l, times in l²/h; the mass comes with velocity 1 and stays.
"""
import numpy as np

try:
    import finufft
except ImportError:  # its times and errors are left out
    finufft = None


def modes(n, gamma):
    """Frequencies, velocities and midpoint and tip shapes of n modes, by Newton's method from an asymptotic start."""
    k = np.arange(1, n + 1)
    anchor = (k - 0.75)*np.pi
    u = 1/(gamma*anchor)
    delta = np.arctan(u/(2 + u))
    few = min(n, 16)                                   # beyond them sech α is below rounding
    delta[:few] = low_roots(anchor[:few], gamma, delta[:few])
    far = slice(few, n)
    for _ in range(1 if few > 300 else 2):
        x = 1 + 2*gamma*(anchor[far] + delta[far])
        delta[far] -= (delta[far] - np.arctan(1/x))/(1 + 2*gamma/(1 + x*x))
    alpha = anchor + delta
    tip, mass, middle = np.empty(n), np.empty(n), np.empty(n)
    tip[:few], mass[:few], middle[:few] = low_shapes(alpha[:few], gamma)
    sign = np.where(k[far] % 2 == 0, -1.0, 1.0)
    sine = np.sin(delta[far])
    tip[far] = -np.sqrt(8)*sign*sine
    mass[far] = 1 + 2*gamma*sine**2
    middle[far] = np.sqrt(2)*np.cos(0.5*alpha[far] + 0.25*np.pi)
    near = slice(few, min(n, 32))
    middle[near] += -np.exp(-0.5*alpha[near]) + 0.5*tip[near]*np.exp(-0.5*alpha[near])
    return alpha**2, gamma*tip/mass, middle, tip


def low_roots(anchor, gamma, delta):
    """Newton's method on the frequency equation with its exponentials."""
    delta[0] = 0.35*min(1.0, gamma**-0.25) if gamma > 0 else 1.09      # the first root is far from its asymptote
    alpha = anchor + delta
    alpha[0] = (3/gamma/(1 + 0.2427/gamma))**0.25
    for _ in range(6):
        c, s, h, th = np.cos(alpha), np.sin(alpha), 1/np.cosh(alpha), np.tanh(alpha)
        value = h + c + gamma*alpha*(c*th - s)
        slope = -h*th - s + gamma*(c*th - s) + gamma*alpha*(-s*th + c*h*h - c)
        alpha -= value/slope
    return alpha - anchor


def low_shapes(alpha, gamma):
    """Tip, mass and midpoint where the exponentials count."""
    c, s, ch, sh = np.cos(alpha), np.sin(alpha), np.cosh(alpha), np.sinh(alpha)
    sigma = (c + ch)/(s + sh)
    tip = 2*(c*sh - s*ch)/(s + sh)
    mass = 0.25*(1 + gamma)*tip**2 + 2*(1 + c*ch)*s*sh/(s + sh)**2
    z = 0.5*alpha
    middle = np.cos(z) - sigma*np.sin(z) - 0.5*(1 + sigma)*np.exp(-z) \
        - 0.5*(s - c - np.exp(-alpha))/(s + sh)*np.exp(z)
    return tip, mass, middle


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
