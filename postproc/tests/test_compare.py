"""Two results laid over each other: what is drawn of each, and what is said of both."""

import numpy as np
import pytest
import synthetic
import xarray as xr

from beamwave_postproc import NothingToDraw, compare, open_result
from beamwave_postproc.compare import COMPARED
from beamwave_postproc.parts.labels import plain
from beamwave_postproc.parts.pairs import differences, head_of_both, pairs_of

RESPONSE = {"duration": 0.1, "samples": 512}


@pytest.fixture(scope="module")
def two(tmp_path_factory):
    """A beam at rest and one that turns, alike in all else; B also at a further point."""
    directory = tmp_path_factory.mktemp("two")
    found = []
    for name, speed, points in (("rest", 0.0, [0.5, 1.0]), ("turning", 50.0, [0.25, 0.5, 1.0])):
        settings = synthetic.scene(
            rotation={"angular_velocity": speed},
            modes={"before": 5, "after": 5},
            response={**RESPONSE, "points": points},
            spectrum={"max_peaks": 3},
        )
        with open_result(synthetic.write(directory / f"{name}.nc", settings, title=f"Beam {name}")) as ds:
            found.append(ds.load())
    return found


def test_what_both_hold_is_drawn(two):
    assert set(compare(*two)) == {"frequencies", "velocity_jump", "displacement", "spectrum"}
    first, second = two
    assert set(compare(first.drop_vars("amplitude"), second)) == {"frequencies", "velocity_jump", "displacement"}
    with pytest.raises(NothingToDraw, match="nothing in common"):
        compare(first[["time"]], second)


def test_changes_are_those_of_b_over_a_in_per_cent(two):
    first, second = two
    _, right = COMPARED["frequencies"](first, second).axes
    drawn = {line.get_label(): line for line in right.lines}
    for label, name in (("frequency", "angular_frequency"), ("group velocity", "group_velocity")):
        expected = 100.0 * (second[name].values / first[name].values - 1.0)
        np.testing.assert_array_equal(drawn[label].get_ydata(), expected)


def test_histories_stand_above_their_difference_at_the_points_of_both(two):
    first, second = two
    axes = COMPARED["displacement"](first, second).axes
    assert [one.get_ylabel().split("= ")[1].split(" ")[0] for one in axes] == ["0.5", "0.5", "1", "1"]
    a, b = (line.get_ydata() for line in axes[2].lines)
    np.testing.assert_allclose(a, 1e3 * first["displacement"][1], rtol=1e-15)
    np.testing.assert_allclose(b, 1e3 * second["displacement"][2], rtol=1e-15)
    (difference,) = axes[3].lines
    scale = 1e3 if "(mm)" in axes[3].get_ylabel() else 1e6
    np.testing.assert_allclose(difference.get_ydata(), scale * (second["displacement"][2] - first["displacement"][1]))


def test_what_may_be_nothing_but_error_carries_a_warning_by_its_letter(two):
    first, second = two
    doubtful = second.assign(displacement_error=("point", [0.0, 2e9, 0.0]))
    head = " ".join(text.get_text() for text in COMPARED["displacement"](first, doubtful).texts).replace("\n", " ")
    assert "B: Warning: the displacement may be nothing but error" in head and "A: Warning" not in head
    assert not any("Warning" in text.get_text() for text in COMPARED["displacement"](first, second).texts)


def test_the_axis_of_time_ends_with_the_record_at_a_tick(two):
    first, second = two
    axes = COMPARED["displacement"](first, second).axes[-1]
    step = float(first["time"][1] - first["time"][0])
    factor = axes.lines[0].get_xdata()[-1] / float(first["time"][-1])
    assert axes.get_xlim()[1] == pytest.approx(factor * first.sizes["time"] * step, rel=1e-12)


def test_other_times_have_no_difference_and_the_head_says_so(two):
    first, second = two
    fig = COMPARED["displacement"](first, second.isel(time=slice(None, None, 2)))
    assert len(fig.axes) == 2 and any("the times differ" in text.get_text() for text in fig.texts)


def test_the_head_says_what_differs(two):
    first, second = two
    texts = [
        plain(text.get_text()).replace("\n", " ").replace("\u00a0", " ")
        for text in COMPARED["spectrum"](first, second).texts
    ]
    assert texts[0] == "A: Beam rest; B: Beam turning"
    assert texts[1].startswith("A: rest.nc; beam l = 1 m") and "rotation ω = 0" in texts[1]
    assert texts[2].startswith("B: turning.nc; rotation ω = 50")
    assert "they differ in ω = 0 rad/s and 50 rad/s" in texts[3]
    # What is the same stands in the head once.
    assert "beam" not in texts[2] and "rotation ω = 50 rad/s" in texts[2] and "else as A" in texts[2]
    without = head_of_both(first.assign_attrs(effects="rotation stiffening impact"), second, []).about.partition(" B: ")[2]
    assert "without stiffening" in without
    assert "stiffening in B alone" in differences(
        first, second.assign_attrs(effects="rotation impact capture stiffening")
    )
    assert differences(first, first) == "effects and inputs are the same"
    out, within = (first.assign_attrs(scene=f"&rotation plane = '{plane}' /") for plane in ("out", "in"))
    assert differences(out, within) == "they differ in rotation plane\u00a0=\u00a0out and in"


def test_results_without_a_file_or_a_scene_are_compared(two):
    first, second = (xr.Dataset({"displacement": ds["displacement"].variable}) for ds in two)
    assert head_of_both(first, second, []).scenes == [["A"], ["B: else as A"]]


def test_sweeps_over_the_same_values_are_compared_case_by_case(paper_results):
    with open_result(paper_results / "fig6.nc") as first, open_result(paper_results / "fig7.nc") as other:
        pairs, note = pairs_of(first, first)
        assert [pair.labels[0].split("\u00a0")[2] for pair in pairs] == ["0", "50", "100"] and not note
        assert all(pair.labels[0] == pair.labels[1] for pair in pairs)
        axes = COMPARED["displacement"](first, first).axes
        assert len(axes[0].lines) == 6 and not any(line.get_ydata().any() for line in axes[1].lines)
        pairs, note = pairs_of(first, other)
        assert len(pairs) == 1 and note == "of A and B the first case"
        assert "γ = 0.2 and 0.1 to 1" in plain(differences(first, other)).replace("\u00a0", " ")


def test_the_case_of_each_sweep_that_is_drawn_is_named_by_all_that_either_sweeps(paper_results):
    with open_result(paper_results / "fig6.nc") as first, open_result(paper_results / "fig7.nc") as other:
        for kind, fig in compare(first, other).items():
            labels = [plain(text.get_text()).replace("\u00a0", " ") for text in fig.legends[0].get_texts()]
            assert labels[:2] == ["A: fig6.nc, ω = 0 rad/s, γ = 0.2", "B: fig7.nc, ω = 50 rad/s, γ = 0.1"], kind


def test_a_jump_of_the_tip_alone_has_no_ramp_beside_another_one_either(two):
    first, second = two
    limit = first.assign(velocity_jump=first["velocity_jump"].where(first["profile_position"] == 1.0, 0.0))
    (axes,) = COMPARED["velocity_jump"](limit, second).axes
    rest, mark, other = axes.lines
    assert not rest.get_ydata().any() and list(mark.get_xdata()) == [1.0] and mark.get_linestyle() == "None"
    np.testing.assert_array_equal(other.get_ydata(), second["velocity_jump"])
    assert [mark.get_label()[0], other.get_label()[0]] == ["A", "B"]


def test_points_at_which_both_rest_take_no_panel_and_rest_alone_invents_no_number(two):
    first, second = (ds.assign(displacement=ds["displacement"].where(ds["point_position"] != 0.5, 0.0)) for ds in two)
    assert ["= 1" in axes.get_ylabel() for axes in COMPARED["displacement"](first, second).axes] == [True, True]
    still = [ds.assign(displacement=0.0 * ds["displacement"]) for ds in two]
    assert all(axes.get_yticks().tolist() == [0.0] for axes in COMPARED["displacement"](*still).axes)
    same = COMPARED["displacement"](two[0], two[0]).axes
    assert [axes.get_yticks().size > 1 for axes in same] == [True, False, True, False]


def test_a_and_b_are_told_apart_without_colour(two):
    for kind, fig in compare(*two).items():
        lines = [line for line in fig.axes[0].lines if line.get_label()[0] in "AB"]
        assert len({(str(line.get_linestyle()), line.get_marker(), line.is_dashed()) for line in lines}) == 2, kind


def test_two_sweeps_over_the_speed_have_one_campbell_diagram():
    speed = np.linspace(0.0, 60.0, 7)

    def sweep(growth):
        """Modes whose β² grows by so many times ω² from that at rest."""
        beta = np.sqrt(np.array([50.0, 300.0]) ** 2 + growth * speed[:, None] ** 2)
        inputs = {"case": np.arange(1, 8), "mode": [1, 2], "rotation_angular_velocity": ("case", speed)}
        ds = xr.Dataset({"angular_frequency": (("case", "mode"), beta)}, inputs)
        ds.encoding["source"] = "sweep.nc"
        return ds

    (axes,) = compare(sweep(1.2), sweep(0.2))["campbell"].axes
    for line, (rest, growth) in zip(axes.lines, ((50.0, 1.2), (300.0, 1.2), (50.0, 0.2), (300.0, 0.2))):
        omega = line.get_xdata() * np.pi / 30.0
        np.testing.assert_allclose(2.0 * np.pi * line.get_ydata(), np.sqrt(rest**2 + growth * omega**2), rtol=1e-9)
    assert [line.is_dashed() for line in axes.lines] == [False, False, True, True]
