"""A film of the moving beam, as a GIF."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle
from PIL import Image

from ..parts.events import Event
from ..parts.head import MARGIN, Head, grow_by_head
from ..parts.units import number_text, si_prefix
from ..style import COLOURS, GREY, RC
from ..writing import MARK, put
from .motion import FEW_POINTS, Motion

DPI = 90
BELOW = 3.1  # inches, height below the head
LEFT = 0.85  # inches, room for the numbers and words of the y axis
FRAME_MS, HOLD_MS = 50, 500  # how long a frame stands, and one with an event
FLASH, WORDS = 6, 16  # frames that a flash, and the name of its event, remain
PALETTE = 64  # colours of the GIF
EDGE = 0.93  # of half the height: where a mass beyond the picture is marked
ROOM = 1.3  # of the largest deflection, above and below
GROWN = 0.1  # a growing motion fills the picture from this part of its frames on
HUB = 0.07  # radius of the hub as drawn, in lengths of the beam
BEAM, MASS, FLASHES, BODIES = COLOURS[1], COLOURS[2], COLOURS[6], "0.3"
JOINT = {"marker": "o", "color": BODIES, "markerfacecolor": "white", "markersize": 12, "markeredgewidth": 1.5}


def save_film(shown: Motion, path: Path, *, overwrite: bool = False) -> None:
    """Write the film as a GIF file, whole or not at all.

    A film that this package made is replaced, and anything else with `overwrite`; else raises `FileExistsError`.
    """
    put(path, partial(_write, shown), overwrite=overwrite, mark=MARK)


def _write(shown: Motion, path: Path) -> None:
    """Draw all frames, and write them."""
    with mpl.rc_context({**RC, "axes.grid": False}):
        frames = list(Film(shown).frames())
    holds = [HOLD_MS if any(event.time >= 0.0 for event in events) else FRAME_MS for events in shown.events]
    first, *others = frames
    first.save(path, format="GIF", save_all=True, append_images=others, duration=holds, loop=0, comment=MARK.encode())


class Film:
    """The frames of a `Motion`, drawn one at a time into one figure: what moves onto what does not."""

    def __init__(self, shown: Motion) -> None:
        self.shown = shown
        turning = shown.angle is not None
        figure = Figure(figsize=(8.6 if turning else 6.4, BELOW), dpi=DPI)
        self.canvas = FigureCanvasAgg(figure)
        key = _key(shown)
        head = Head(shown.title, [], [shown.scene], handles=key, labels=[one.get_label() for one in key], warning=shown.warning)
        share = BELOW / (BELOW + grow_by_head(figure, head))
        self.limits = limits(shown)
        left, right = LEFT / figure.get_figwidth(), 0.65 if turning else 0.96
        self.beam = _BeamView(figure.add_axes((left, 0.16 * share, right - left, 0.72 * share)), shown)
        self.hub = _HubView(figure.add_axes((0.69, 0.02, 0.3, 0.86 * share)), shown) if turning else None
        self.heading = figure.text(MARGIN / figure.get_figwidth(), 0.98 * share, "", va="top", fontsize=9.5)
        self.moving = [self.heading, *self.beam.moving, *(self.hub.moving if self.hub else ())]
        for artist in self.moving:
            artist.set_animated(True)
        self.limit = 0.0  # of the background
        self.background = None

    def frames(self) -> Iterator[Image.Image]:
        """All frames, as images of one palette: that of the first, of the first event and of the last."""
        last = self.shown.time.size - 1
        event = next((frame for frame, events in enumerate(self.shown.events) if events), 0)
        samples = [np.asarray(self.image(frame)) for frame in (0, event, min(event + 1, last), last)]
        palette = _palette(np.vstack(samples))
        for frame in range(last + 1):
            yield self.image(frame).quantize(palette=palette, dither=Image.Dither.NONE)

    def image(self, frame: int) -> Image.Image:
        """Frame number `frame`, all that moves being where it is then."""
        if self.limits[frame] != self.limit:
            self.limit = self.limits[frame]
            self.beam.set_limit(self.limit)
            self.canvas.draw()
            self.background = self.canvas.copy_from_bbox(self.canvas.figure.bbox)
        self.canvas.restore_region(self.background)
        scale = self.beam.place(frame, self.limit)
        if self.hub is not None:
            self.hub.place(frame, scale)
        self.heading.set_text(self._words(frame, scale))
        for artist in self.moving:
            (artist.axes or self.canvas.figure).draw_artist(artist)
        return Image.fromarray(np.asarray(self.canvas.buffer_rgba())).convert("RGB")

    def _words(self, frame: int, scale: float) -> str:
        """Time, pace and scale."""
        shown = self.shown
        prefix, factor = si_prefix(shown.time, "s")
        time = f"t = {shown.time[frame] * factor:.4g} {prefix}s" if shown.time[frame] >= 0.0 else "before the impact"
        step = np.median(np.diff(shown.time)) if shown.time.size > 1 else 0.0
        pace = f", slowed {number_text(FRAME_MS / 1e3 / step, 2)} times" if step > 0.0 else ""
        return f"{time}{pace}; deflection drawn {number_text(scale, 2)} times as large"


def _key(shown: Motion) -> list[Line2D]:
    """What the film shows, as handles of a legend."""
    key = [Line2D([], [], color=BEAM, linewidth=3.0, label="beam")]
    if shown.mass is not None:
        key.append(Line2D([], [], linestyle="", marker="o", color=MASS, markersize=9, label="mass that strikes"))
        if (beyond := shown.mass[np.abs(shown.mass) > EDGE * limits(shown)]).size:
            key.append(Line2D([], [], linestyle="", **_arrow(beyond[0]), color=MASS, markersize=9, label="mass beyond the picture"))
    if not shown.clamped:
        key.append(Line2D([], [], linestyle="", **JOINT, label="joint"))
    if shown.carried.locked.any():
        key.append(Line2D([], [], linestyle="", **{**JOINT, "markerfacecolor": BODIES}, label="locked joint"))
    if shown.carried.place.size:
        key.append(Line2D([], [], linestyle="", marker="s", color=BODIES, markersize=8, label="body"))
    return key


def _arrow(place: float) -> dict[str, str]:
    """The mark of a mass that is beyond the picture, pointing there."""
    return {"marker": "^" if place > 0.0 else "v", "markerfacecolor": "white"}


class _BeamView:
    """The beam in the rotating frame, its deflection drawn larger than its length."""

    def __init__(self, axes: Axes, shown: Motion) -> None:
        self.axes, self.shown = axes, shown
        self.factor = 1.0
        length, few = shown.length, shown.points.size < FEW_POINTS
        axes.set(xlim=(-0.06 * length, 1.12 * length), xlabel="Place along the beam (m)")
        axes.axhline(0.0, color="0.8", linewidth=0.8, zorder=0)
        axes.axvline(
            shown.struck, color=GREY, linewidth=0.8, linestyle=(0, (1, 3)), zorder=0, visible=shown.mass is not None
        )
        clamp = axes.axvspan(-0.06 * length, 0.0, ymin=0.3, ymax=0.7, facecolor="0.85", edgecolor="0.5", hatch="////")
        clamp.set_visible(shown.clamped)
        (self.joint,) = axes.plot([0.0], [0.0], linestyle="", visible=not shown.clamped, **JOINT)
        (self.line,) = axes.plot([], [], color=BEAM, linewidth=1.2 if few else 3.0, linestyle="--" if few else "-")
        (self.dots,) = axes.plot([], [], "o", color=BEAM, markersize=5, visible=few)
        (self.bodies,) = axes.plot([], [], "s", color=BODIES, markersize=8)
        (self.mass,) = axes.plot([], [], "o", color=MASS, markersize=11, clip_on=False)
        (self.flash,) = axes.plot([], [], "o", color=FLASHES, markerfacecolor="none")
        self.words = axes.text(0.08, 0.96, "", transform=axes.transAxes, va="top", color="0.3")
        self.mode = axes.text(0.08, 0.04, "", transform=axes.transAxes, color="0.3")  # near the root, where little moves
        self.moving = [self.line, self.dots, self.joint, self.bodies, self.mass, self.flash, self.words, self.mode]

    def set_limit(self, limit: float) -> None:
        """Let the picture reach from -`limit` to `limit` (m), in the unit that suits."""
        prefix, self.factor = si_prefix(np.array([limit]), "m")
        self.axes.set_ylabel(f"Deflection ({prefix}m)")
        self.axes.set_ylim(-limit * self.factor, limit * self.factor)

    def place(self, frame: int, limit: float) -> float:
        """Put all where it is in the frame; how much larger deflections are drawn than lengths."""
        shown = self.shown
        self.line.set_data(shown.place, shown.line[frame] * self.factor)
        self.dots.set_data(shown.points, shown.deflection[frame] * self.factor)
        bodies, deflection = _bodies_of(shown, frame)
        self.bodies.set_data(bodies, deflection * self.factor)
        self.joint.set_markerfacecolor(BODIES if shown.carried.locked[frame] else "white")
        self.mode.set_text(shown.first_mode[frame])
        if shown.mass is not None:
            self._place_mass(frame, limit)
        self._place_events(frame)
        box = self.axes.get_window_extent()
        left, right = self.axes.get_xlim()
        return float(box.height / (2.0 * limit) / (box.width / (right - left)))

    def _place_mass(self, frame: int, limit: float) -> None:
        """The mass on the beam or in its guide; at the picture's edge, as an arrow head, once it is beyond."""
        place = self.shown.mass[frame]
        beyond = abs(place) > EDGE * limit
        self.mass.set(**_arrow(place) if beyond else {"marker": "o", "markerfacecolor": MASS})
        self.mass.set_data([self.shown.struck], [np.clip(place, -EDGE * limit, EDGE * limit) * self.factor])

    def _place_events(self, frame: int) -> None:
        """Rings that widen where the latest events are, and their names: of a contact no longer than it lasts."""
        shown = self.shown
        ages = [age for age in range(min(WORDS, frame + 1)) if _told(shown, frame - age, frame)]
        self.words.set_text(_names(_told(shown, frame - ages[0], frame)) if ages else "")
        flashing = bool(ages) and ages[0] < FLASH
        self.flash.set_visible(flashing)
        if flashing:
            there = shown.flashes[frame - ages[0]]
            self.flash.set_data(there, _on_line(shown, frame, there) * self.factor)
            self.flash.set(markersize=14 + 7 * ages[0], markeredgewidth=3.0 * (1.0 - ages[0] / FLASH))


class _HubView:
    """Hub and beam from above, where the turning is seen."""

    def __init__(self, axes: Axes, shown: Motion) -> None:
        self.shown = shown
        reach = 1.2 * shown.length
        axes.set(xlim=(-reach, reach), ylim=(-reach, reach), aspect="equal", xticks=[], yticks=[])
        axes.spines[:].set_visible(False)
        axes.add_patch(Circle((0.0, 0.0), shown.length, fill=False, edgecolor="0.85"))
        axes.add_patch(Circle((0.0, 0.0), HUB * shown.length, facecolor="0.85", edgecolor="0.5", zorder=3))
        (self.mark,) = axes.plot([], [], color="0.5", linewidth=1.2, zorder=4)
        (self.rest,) = axes.plot([], [], color="0.8", linewidth=0.8)
        (self.line,) = axes.plot([], [], color=BEAM, linewidth=2.0)
        (self.bodies,) = axes.plot([], [], "s", color=BODIES, markersize=4.5)
        (self.mass,) = axes.plot([], [], "o", color=MASS, markersize=6)
        self.moving = [self.rest, self.mark, self.line, self.bodies, self.mass]
        words = "from above; the beam bends along the axis" if shown.out_of_plane else "seen from above"
        axes.set_title(words, fontsize="small", color="0.3")

    def place(self, frame: int, scale: float) -> None:
        """Turn everything; deflections are drawn `scale` times as large, those out of the plane not at all."""
        shown, angle = self.shown, self.shown.angle[frame]
        scale = 0.0 if shown.out_of_plane else scale
        self.line.set_data(*_turned(angle, shown.place, scale * shown.line[frame]))
        bodies, deflection = _bodies_of(shown, frame)
        self.bodies.set_data(*_turned(angle, bodies, scale * deflection))
        self.rest.set_data(*_turned(angle, np.array([0.0, shown.length]), np.zeros(2)))
        self.mark.set_data(*_turned(angle, np.array([-HUB, HUB]) * shown.length, np.zeros(2)))
        if shown.mass is not None:
            self.mass.set_data(*_turned(angle, np.array([shown.struck]), scale * shown.mass[frame : frame + 1]))


def _on_line(shown: Motion, frame: int, places: np.ndarray) -> np.ndarray:
    """Deflection (m) of the beam's line at `places` (m)."""
    return np.interp(places, shown.place, shown.line[frame])


def _bodies_of(shown: Motion, frame: int) -> tuple[np.ndarray, np.ndarray]:
    """Places and deflections (m) of the bodies in a frame, on the beam and on their way; those beyond the picture are left out."""
    carried = shown.carried
    on_beam, free = carried.place[carried.there[frame]], carried.free[frame]
    seen = np.abs(free) < limits(shown)[frame]
    return np.append(on_beam, carried.free_place[seen]), np.append(_on_line(shown, frame, on_beam), free[seen])


def _palette(pixels: np.ndarray) -> Image.Image:
    """Colours of `pixels` (rows, columns, 3), those of small things among them, as an image without content."""
    own = [round(255 * part) for colour in (BEAM, MASS, FLASHES, BODIES) for part in to_rgb(colour)]
    found = Image.fromarray(pixels).quantize(PALETTE).getpalette()[: 3 * PALETTE]
    palette = Image.new("P", (1, 1))
    palette.putpalette([*own, *found])
    return palette


def _turned(angle: float, along: np.ndarray, across: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Coordinates in the plane at rest."""
    return along * np.cos(angle) - across * np.sin(angle), along * np.sin(angle) + across * np.cos(angle)


def limits(shown: Motion) -> np.ndarray:
    """Half the height of the picture in each frame, m: one for all, or for a growing motion one that follows it."""
    largest = np.abs(shown.line).max(axis=1)
    if not largest.any():
        return np.full(largest.size, shown.length)
    if not shown.grows:
        return np.full(largest.size, ROOM * largest.max())
    so_far = np.maximum.accumulate(largest)
    start = so_far[int(GROWN * so_far.size)] or so_far[so_far > 0.0][0]
    return ROOM * np.maximum(so_far, start)


def _told(shown: Motion, begin: int, frame: int) -> list[Event]:
    """The events of frame `begin` that are told in `frame`: moments, and what lasts until it ends, but at least once."""
    now = shown.time[frame]
    return [event for event in shown.events[begin] if frame == begin or event.end <= event.time or now < event.end]


def _names(events: list[Event]) -> str:
    """Kinds of events, several of one kind counted."""
    kinds = [event.kind for event in events]
    counts = {kind: kinds.count(kind) for kind in kinds}
    return ", ".join(kind if count == 1 else f"{count} {kind}s" for kind, count in counts.items())
