"""Amplitudes as an image of decibels: no more rows than a picture has, and no line lost between them."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes

ROWS = 500
Extent = tuple[float, float, float, float]


def highest_in_rows(frequency: np.ndarray, amplitude: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """At most `ROWS` of the frequencies of `amplitude` (frequency, …), each with the highest of those it stands for."""
    size = -(-frequency.size // ROWS)
    whole = frequency.size // size * size
    return frequency[:whole:size], amplitude[:whole].reshape(-1, size, *amplitude.shape[1:]).max(axis=1)


def decibels(amplitude: np.ndarray, highest: np.ndarray) -> np.ndarray:
    """Level of `amplitude` over `highest` (of one shape with it, but for 1s) in dB, 0 at the most."""
    least = np.finfo(float).tiny
    return np.minimum(20.0 * np.log10(np.maximum(amplitude, least) / np.maximum(highest, least)), 0.0)


def draw_level(axes: Axes, level: np.ndarray, extent: Extent, depth: float, words: str) -> None:
    """Image of `level` (row, column) in dB, -`depth` to 0, over `extent` (left, right, bottom, top), with its scale."""
    shown = axes.imshow(
        level,
        origin="lower",
        aspect="auto",
        extent=extent,
        cmap="magma",
        interpolation="bilinear",
        vmin=-depth,
        vmax=0.0,
    )
    axes.figure.colorbar(shown, ax=axes, label=words, pad=0.02)
    axes.grid(visible=False)
