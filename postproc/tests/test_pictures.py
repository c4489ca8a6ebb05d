"""Every picture of the package on results of the program: without warnings, in its place, saying what it shows."""

import inspect
import warnings

import numpy as np
import pytest
from matplotlib.figure import Figure

import beamwave_postproc
from beamwave_postproc import KINDS, NothingToDraw, open_result, swept_inputs
from beamwave_postproc.parts.crowding import is_crowded

DRAWN = {
    name for name in beamwave_postproc.__all__ if name in {kind.split("measured_")[0] or "measured" for kind in KINDS}
}


def overlaps(fig):
    """Words, legends and axes that cover each other or leave the figure; a list of what is wrong."""
    wrong = ["axes or numbers meet"] if is_crowded(fig) else []
    fig.set_layout_engine("none")  # it is laid out
    fig.draw_without_rendering()
    shown = [axes for axes in fig.axes if axes.get_visible()]
    boxes = [axes.get_tightbbox() for axes in shown]
    wrong += [f"legend on the data of {axes}" for axes in shown if axes.get_legend() and covers(axes)]
    for artist in (*fig.texts, *fig.legends):
        box = artist.get_window_extent()
        if box.x0 < 0.0 or box.x1 > fig.bbox.x1 or box.y1 > fig.bbox.y1:
            wrong.append(f"{artist} leaves the figure")
        if any(below.y1 > box.y0 + 1.0 for below in boxes):
            wrong.append(f"{artist} is over axes")
    # Letters stand a pixel beyond the box that they are given room for.
    inside = (box.x0 > -2.0 and box.x1 < fig.bbox.x1 + 2.0 and box.y0 > -2.0 for box in boxes)
    return wrong + [f"{axes} leaves the figure" for axes, fits in zip(shown, inside) if not fits]


def covers(axes):
    """Whether the legend of `axes` lies on what they show."""
    return axes.get_legend().get_window_extent().overlaps(axes.bbox)


def form(ds):
    """What makes a picture of a kind another one: how many inputs are swept, how many points there are, the method."""
    return len(swept_inputs(ds)), min(ds.sizes.get("point", 0), 9), ds.attrs["method"]


def test_each_picture_of_each_form_of_result_is_in_order_and_says_what_it_shows(results):
    seen = set()
    for path in results:
        with open_result(path) as ds, warnings.catch_warnings():
            warnings.simplefilter("error")
            for kind in [kind for kind in KINDS if (kind, form(ds)) not in seen]:
                try:
                    fig = KINDS[kind](ds)
                except NothingToDraw:
                    continue
                wrong = overlaps(fig)
                assert not wrong, f"{path.name}: {kind}: {wrong}"
                words = " ".join(text.get_text() for text in fig.texts).replace("\n", " ")
                for told in (str(ds.attrs["title"]), path.name):
                    assert told in words, f"{path.name}: {kind} does not say {told}"
                for told in ("beam l", *str(ds.attrs["effects"]).split()):
                    assert told in fig.get_label(), f"{path.name}: the label of {kind} does not say {told}"
                seen.add((kind, form(ds)))
    assert {"dispersion", "velocity_jump", "displacement"} <= {kind for kind, _ in seen}


def test_every_function_that_draws_is_a_kind_and_public():
    assert {kind for kind in KINDS if not kind.startswith("measured_")} | {"measured"} == DRAWN
    for name in DRAWN:
        words = inspect.signature(getattr(beamwave_postproc, name)).parameters
        assert "ax" in words and inspect.getdoc(getattr(beamwave_postproc, name)), name


@pytest.mark.parametrize("kind", KINDS)
def test_what_a_result_lacks_is_refused(paper_results, kind):
    with open_result(paper_results / "fig2.nc") as ds, pytest.raises(NothingToDraw):
        KINDS[kind](ds[["mode_count"]].drop_vars("case"))


def test_each_picture_is_drawn_on_axes_of_the_caller(full_result, paper_results):
    drawn = 0
    for path in (full_result, paper_results / "fig6.nc"):
        with open_result(path) as ds:
            for kind, draw in KINDS.items():
                try:
                    count = len([axes for axes in draw(ds).axes if axes.get_label() != "<colorbar>"])
                except NothingToDraw:
                    continue
                fig = Figure(figsize=(9.0, 9.0))
                given = fig.subplots(count, squeeze=False)
                if kind == "spectrogram":
                    given = given[:1]
                assert draw(ds, ax=given if count > 1 else given[0, 0]) is fig, kind
                assert all(axes.has_data() for axes in given.ravel()) and not fig.legends and not fig.texts
                with pytest.raises(ValueError, match="ax holds"):
                    draw(ds, ax=np.array([given[0, 0]] * 7))
                drawn += 1
    assert drawn > 10
