"""Every subset of the effect groups that the program knows, in both planes: each runs and balances, or is refused for what a group
needs or excludes by its description."""

import itertools
import re

import numpy as np
import pytest
from workplace import PAPER_BEAM, example, namelist

NOT_EFFECTS = {"scene", "beam", "impact", "modes", "response", "frequency_response", "record", "spectrum", "identify", "design", "sweep"}
SAMPLES = {  # each effect group's variants; of one that is not here that of a scene in input/
    "rotation": [{"angular_velocity": 50.0, "plane": "in"}, {"angular_velocity": 50.0, "plane": "out"}],
    "stiffening": [{"hub_radius": 0.1}],
    "shear": [{}],
    "damping": [{"ratio": 0.01}, {"mass_proportional": 3.0, "stiffness_proportional": 1e-6}],
    "capture": [{}, {"rotary_inertia": 1e-3}],
    "release": [{"time": 0.011}],
    "recontact": [{}],
    "support": [{"rotational_stiffness": 2e5}],
    "hub": [{"rotary_inertia": 2.0}],
    "body": [{"position": 0.6, "mass_ratio": 0.1, "rotary_inertia": 1e-3}],
}
TOGETHER = ("support", "body", "tip_support")  # they stand together here
EVERY = {"body": 23, "force": 23, "base": 23, "contact": 5}  # of the scenes with such a group one in so many is run


def known_groups(here):
    return set(re.findall(r"^## &(\w+)", here.beamwave("describe").stdout, re.MULTILINE))


def named_after(words, text):
    """The groups of a sentence that begins so."""
    sentence = re.search(rf"\b{words} ([^.]*)\.", " ".join(text.split()))
    return set(re.findall(r"`&(\w+)`", sentence[1])) if sentence else set()


def reason(described, groups):
    """What must be said of a scene with these effects, by the descriptions of all; None where it must run."""
    for group in sorted(groups & described.keys()):
        needed, excluded = (named_after(words, described[group]) for words in ("Needs", "Cannot be combined with"))
        for word, others in (("needs", needed - groups), ("excludes", excluded & groups)):
            if others:
                return f"&{group}: {word} &{min(others)}"
    return None


def is_walked(scene, number):
    """Left out: most of those with what stands together, and what a hub that is free, or a capture, refuses for more than a group."""
    if len({group in scene for group in TOGETHER}) > 1 or number % max(EVERY.get(group, 1) for group in ["beam", *scene]):
        return False
    if {"capture", "contact"} <= scene.keys() and scene.keys() & {"force", "base"}:
        return False
    if "hub" not in scene or "recontact" in scene:
        return True
    turns = scene.get("rotation")
    return "tip_support" not in scene and (turns is None or (turns["plane"] == "in" and "stiffening" in scene))


def variants(group):
    """The samples of a group."""
    return SAMPLES[group] if group in SAMPLES else [example(group)[group]]


@pytest.fixture(scope="module")
def walked(shared):
    """All scenes by name, and what the program said when it ran them in one call."""
    here = shared("subsets")
    effects = sorted(known_groups(here) - NOT_EFFECTS)
    scenes = {}
    for number, choice in enumerate(itertools.product(*[[None, *variants(group)] for group in effects])):
        if not is_walked({group: values for group, values in zip(effects, choice) if values is not None}, number):
            continue
        scene = {
            "beam": dict(PAPER_BEAM),
            "impact": {"mass_ratio": 0.2},
            "modes": {"before": 6},
            "response": {"duration": 0.02, "samples": 32, "velocity": True},
        }
        scene |= {group: values for group, values in zip(effects, choice) if values is not None}
        name = f"s{len(scenes)}"
        here.write(f"all/{name}.nml", namelist(scene))
        scenes[name] = scene
    described = {group: here.beamwave("describe", group).stdout for group in effects}
    reasons = {name: reason(described, scene.keys()) for name, scene in scenes.items()}
    return here, scenes, reasons, here.beamwave("run", "all")


def test_every_effect_group_is_in_a_scene_of_input(here):
    assert all(example(group) for group in known_groups(here) - NOT_EFFECTS)


def test_what_is_refused_is_refused_for_the_reason_in_the_table(walked):
    here, scenes, reasons, ended = walked
    lines = {name: [] for name in scenes}
    for name, line in re.findall(r"^all/(\w+)\.nml(?::\d+)?: (.*accepted.*)$", ended.stderr, re.MULTILINE):
        lines[name].append(line)
    refused = {name for name in scenes if reasons[name]}
    assert {name for name in scenes if lines[name]} == refused
    for name in refused:
        assert any(re.search(reasons[name], line) for line in lines[name]), (scenes[name], lines[name])
    assert ended.returncode == 2
    assert {path[:-3] for path in here.left()} == scenes.keys() - refused


def test_what_runs_keeps_its_balance(walked):
    """Energy falls at events and, if damped, between them unless loads act; generalised momentum is kept at every instant."""
    here, scenes, reasons, _ = walked
    checked = 0
    for name, scene in scenes.items():
        if reasons[name]:
            continue
        result = here.result(name)
        assert np.isfinite(result["displacement"]).all()
        assert np.abs(result["displacement"]).max() > 1e-4
        assert set(result.attributes["effects"].split()) == scene.keys() - {"beam", "modes", "response"}
        check_balance(scene, result)
        checked += 1
    assert checked > 20


def check_balance(scene, result):
    count = (result["event_kind"] > 0).sum()
    before, after, momentum_before, momentum_after, start, end = (
        result[name][:count]
        for name in ["energy_before", "energy_after", "momentum_before", "momentum_after", "event_time", "event_end"]
    )
    slack = 1e-11 * before[0]
    instant = start == end
    loaded = bool(scene.keys() & {"force", "base"})
    assert (after <= before + slack)[instant | (not loaded)].all(), scene  # loads do work during a contact
    assert loaded or (before[1:] <= after[:-1] + slack).all(), scene
    if not loaded and "damping" not in scene:
        np.testing.assert_allclose(before[1:], after[:-1], atol=slack, err_msg=str(scene))
    np.testing.assert_allclose(
        momentum_after[instant], momentum_before[instant], atol=1e-10 * momentum_before[0], err_msg=str(scene)
    )
