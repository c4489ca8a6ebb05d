"""The moving beam over frequency and wave number: what runs along it, beside what the dispersion relation allows."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..parts.growth import grows
from ..parts.labels import axis_label
from ..parts.level import decibels, draw_level, highest_in_rows
from ..parts.line import beam_line, places_of_line, whole_line
from ..parts.moving import folding_note, is_released, last_modes
from ..parts.passage import length_of
from ..parts.relation import relation_of
from ..parts.points import error_warning
from ..parts.select import Chosen, chosen, one_case
from ..parts.sheet import Given, sheet_for
from ..parts.units import si_prefix
from ..result import NothingToDraw, require
from ..style import ON_IMAGE, styled

FINER = 8  # times as many wave numbers as points, for a smooth picture
RANGE = 80.0  # decibels below the highest amplitude that are shown
ROOM = 1.25  # beyond the wave number at the highest frequency
LEAST_SAMPLES = 16


@styled
def wavenumber_spectrum(ds: xr.Dataset, *, cases: Chosen = None, ax: Given = None) -> Figure:
    """Amplitude of the velocity of the first case over wave number (1/m) and frequency (Hz), and the relation on it.

    Positive wave numbers run to the tip, negative ones to the root; both windows are Hann's. Needs points along all of
    the beam, and a motion that does not grow.
    """
    ds = chosen(ds, cases=cases)
    require(ds, "displacement", "time", "point_position", "wavenumber", "angular_frequency")
    case, note = one_case(ds)
    if grows(case) or not np.isfinite(case["displacement"].values).all():
        raise NothingToDraw("a motion that grows has no spectrum worth a picture")
    if case.sizes["time"] < LEAST_SAMPLES:
        raise NothingToDraw(f"{case.sizes['time']} samples are no spectrum")
    wave, frequency, amplitude = transform(case)
    if not amplitude.any():
        raise NothingToDraw("the beam is at rest")
    sheet = sheet_for(ax, height=4.6)
    axes = sheet.axes[0]
    limits = _limits(case, wave, frequency)
    prefix, factor = si_prefix(np.array([limits[1]]), "Hz")
    frequency, amplitude = highest_in_rows(frequency, amplitude)
    extent = (wave[0], wave[-1], 0.0, factor * frequency[-1])
    level = decibels(amplitude, amplitude.max(keepdims=True))
    draw_level(axes, level, extent, RANGE, "Amplitude of the velocity (dB, 0 = the highest)")
    _draw_relation(axes, case, frequency, factor)
    axes.set(xlim=(-limits[0], limits[0]), ylim=(0.0, factor * limits[1]), ylabel=f"Frequency ({prefix}Hz)")
    axes.set_xlabel(f"{axis_label(ds['wavenumber'])}: to the root | to the tip")
    return sheet.finish(ds, [note, folding_note([case])], warning=error_warning([case], "displacement"))


def transform(case: xr.Dataset) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Wave numbers (1/m), frequencies (Hz) and amplitudes of the velocity (m/s), (frequency, wave number), of one case.

    A wave A cos(βt − Px) that runs over the whole beam through the whole record has the amplitude βA at P and β.
    """
    xi, history = whole_line(case, "displacement")
    places = places_of_line(case, xi, xi.size + 1)
    line = beam_line(case, xi, history)(places)
    across, along = np.hanning(places.size), np.hanning(history.shape[0] + 1)[:-1]
    windowed = line * across[:, None] * along[None, :]
    size = FINER * places.size
    both = np.fft.fftshift(np.fft.fft(np.fft.rfft(windowed, axis=1), n=size, axis=0), axes=0)
    wave = 2.0 * np.pi * np.fft.fftshift(np.fft.fftfreq(size, length_of(case) * float(places[1] - places[0])))
    frequency = np.fft.rfftfreq(history.shape[0], float(case["time"][1] - case["time"][0]))
    amplitude = 4.0 * np.pi * frequency[:, None] * np.abs(both).T / (across.sum() * along.sum())
    return -wave[::-1], frequency, amplitude[:, ::-1]  # e^(i(βt − Px)): a positive P turns backwards in x


def _limits(case: xr.Dataset, wave: np.ndarray, frequency: np.ndarray) -> tuple[float, float]:
    """Largest wave number and frequency shown: those of the modes, as far as points and samples resolve them."""
    p, beta = case["wavenumber"].values, case["angular_frequency"].values / (2.0 * np.pi)
    widest = float(min(wave[-1], -wave[0]))  # to either side
    resolved = np.isfinite(p) & np.isfinite(beta) & (beta < frequency[-1]) & (p < widest)
    if not resolved.any():
        return widest, float(frequency[-1])
    return min(ROOM * p[resolved].max(), widest), min(ROOM * beta[resolved].max(), float(frequency[-1]))


def _draw_relation(axes: Axes, case: xr.Dataset, frequency: np.ndarray, factor: float) -> None:
    """The dispersion relation where the modes obey it, and the modes, on both sides; after a release both sets."""
    relation = relation_of(case)
    last = last_modes(case)
    sets = [("modes", "o", case)]
    if is_released(case):
        sets = [("modes with the mass", "o", case)]
        sets += [("modes after the release", "D", last)] if last is not None and "wavenumber" in last else []
    for side in (-1.0, 1.0):
        for words, marker, modes in sets:
            p, beta = modes["wavenumber"].values, modes["angular_frequency"].values
            marks = {**ON_IMAGE, "linestyle": "", "marker": marker, "markersize": 5, "markerfacecolor": "none"}
            axes.plot(side * p, factor * beta / (2.0 * np.pi), label=words, **marks)
        if relation is not None:
            curve = 2.0 * np.pi * frequency[-1] * np.linspace(0.0, 1.0, 800) ** 2  # even in wave number, nearly
            line = {**ON_IMAGE, "linewidth": 0.8}
            axes.plot(side * relation.wavenumber(curve), factor * curve / (2.0 * np.pi), label="Eq. 2", **line)
