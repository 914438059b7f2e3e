"""The roll, its web and the dancer: steady states by the closed formulas, transients against fine steps."""

import itertools
import math
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from winders import DANCER, FILM

from fieldrig_devices.plants.winder_model import WinderModel
from fieldrig_devices.plants.winder_settings import WinderSettings

ROLES = ["unwinder", "rewinder"]


def winder(role: str, **keys: Any) -> tuple[WinderSettings, WinderModel]:
    settings = WinderSettings(**{**FILM, "role": role, **keys})
    return settings, WinderModel(settings)


def run(model: WinderModel, seconds: float, torque: float, dry: float = 0.0, line: float = 0.0) -> None:
    if not model.speed:
        model.speed = line / model.radius_m  # else the roll runs up first, and gives too much
    for _ in range(round(seconds * 1000)):
        model.step(0.001, torque, dry, line * 0.001)


@pytest.mark.long
@pytest.mark.parametrize(("role", "sign"), [("unwinder", 1), ("rewinder", -1)])
def test_steady_tension_is_torque_over_radius_and_friction_brakes_the_roll(role: str, sign: int) -> None:
    _, model = winder(role, viscous_nm_s_per_rad=0.1)
    run(model, 60, torque=20.0, dry=1.0, line=2.0)
    friction = 1.0 + 0.1 * model.speed
    # the radius changes still, and the roll with it: what that takes is below 1 part in 10,000
    assert model.tension(2.0) * model.radius_m == pytest.approx(20.0 + sign * friction, rel=1e-3)
    assert model.speed * model.radius_m == pytest.approx(2.0, rel=2e-3)  # but for the strain


@pytest.mark.long
@pytest.mark.parametrize(("role", "sign"), [("unwinder", -1), ("rewinder", 1)])
def test_radius_follows_the_wound_length(role: str, sign: int) -> None:
    settings, model = winder(role, modulus_pa=2e11)
    run(model, 120, torque=10.0, line=5.0)
    expected_m = math.sqrt(0.2**2 + sign * 600 * 0.0001 / math.pi)
    assert model.radius_m == pytest.approx(expected_m, rel=2e-5)
    assert settings.length_m(model.radius_m) - settings.length_m(0.2) == pytest.approx(sign * 600, rel=2e-5)


def test_inertia_is_that_of_a_hollow_cylinder() -> None:
    settings, model = winder("rewinder")
    mass_kg = 1000 * 0.5 * math.pi * (0.2**2 - 0.05**2)
    assert model.inertia == pytest.approx(0.05 + mass_kg * (0.2**2 + 0.05**2) / 2)
    assert settings.inertia_kg_m2(0.05) == 0.05


@settings(max_examples=20, deadline=None)
@given(st.lists(st.tuples(st.floats(-30, 50), st.floats(0, 8), st.integers(1, 60)), max_size=12), st.booleans())
def test_no_web_is_lost(moves: list[tuple[float, float, int]], has_dancer: bool) -> None:
    settings, model = winder("unwinder", dancer=DANCER if has_dancer else None, initial_tension_n=50.0)
    at_first = settings.length_m(model.radius_m) + model.span_m
    passed = 0.0
    for torque, line, steps in moves:
        for _ in range(steps):
            passed += line * 0.001 / (1 + max(0.0, model.stretch_m) / model.span_m)
            model.step(0.001, torque, 0.0, line * 0.001)
    assert settings.length_m(model.radius_m) + model.span_m + passed == pytest.approx(at_first, abs=1e-8)


@pytest.mark.parametrize("role", ROLES)
def test_roll_swings_on_the_web_with_its_own_frequency(role: str) -> None:
    settings, model = winder(role, damping_s=0.0, initial_tension_n=100.0)
    sense = 1 if role == "rewinder" else -1
    middle = 100.0 / model.radius_m * model.radius_m
    pulls = []
    model.speed = 0.005 * sense
    for _ in range(2000):
        model.step(0.001, 100.0 * model.radius_m, 0.0, 0.0)
        pulls.append(model.tension(0.0) - middle)
    rising = [n for n, (before, then) in enumerate(itertools.pairwise(pulls)) if before < 0 <= then]
    period = (rising[-1] - rising[0]) / (len(rising) - 1) / 1000
    stiffness = settings.stiffness_n / model.span_m
    assert period == pytest.approx(math.tau * math.sqrt(model.inertia / stiffness) / model.radius_m, rel=0.01)
    early, late = max(pulls[:300]), max(pulls[-300:])
    assert late == pytest.approx(early, rel=0.02)  # nothing is lost but what the material does


@pytest.mark.parametrize("role", ROLES)
def test_viscous_web_lets_no_energy_grow(role: str) -> None:
    settings, model = winder(role, initial_tension_n=300.0, dancer={**DANCER, "initial_m": 0.1, "spring_n_per_m": 50.0})

    def energy() -> float:
        web = settings.stiffness_n / model.span_m * max(0.0, model.stretch_m) ** 2 / 2
        dancer = 4.0 * model.dancer_speed**2 / 2 - 200.0 * model.dancer_m + 50.0 * model.dancer_m**2 / 2
        return web + dancer + model.inertia * model.speed**2 / 2

    energies = []
    for _ in range(3000):
        energies.append(energy())
        model.step(0.001, 0.0, 0.0, 0.0)
    assert all(then <= before + 0.005 for before, then in itertools.pairwise(energies))
    assert energies[-1] < energies[0]


@pytest.mark.long
def test_dancer_with_a_spring_comes_to_rest_where_forces_are_equal() -> None:
    _, model = winder("unwinder", dancer={**DANCER, "spring_n_per_m": 400.0})
    run(model, 30, torque=14.0, line=1.0)
    tension = 14.0 / model.radius_m
    assert model.tension(1.0) == pytest.approx(tension, rel=2e-3)
    assert model.dancer_m == pytest.approx((200.0 - 2 * tension) / 400.0, rel=1e-2)


@pytest.mark.long
@pytest.mark.parametrize(("torque", "stop_m"), [(30.0, 0.0), (10.0, 0.3)])
def test_dancer_without_a_spring_goes_to_the_stop_that_is_stronger(torque: float, stop_m: float) -> None:
    _, model = winder("unwinder", dancer={**DANCER, "initial_m": 0.15})
    run(model, 30, torque=torque, line=1.0)
    assert (model.dancer_m, model.dancer_speed) == (stop_m, 0.0)
    assert model.tension(1.0) == pytest.approx(torque / model.radius_m, rel=2e-3)


def test_dancer_that_floats_keeps_the_tension_whatever_the_roll_does() -> None:
    _, model = winder("unwinder", dancer={**DANCER, "initial_m": 0.15, "damping_n_s_per_m": 0.0}, initial_tension_n=100)
    run(model, 0.2, torque=20.05, line=0.0)
    assert 0 < model.dancer_m < 0.15
    mass_of_roll = model.inertia / model.radius_m**2
    pull = (20.05 / model.radius_m - 100.0) / (mass_of_roll + 4.0 / 4) * (4.0 / 4)  # of the dancer's own inertia
    assert model.tension(0.0) == pytest.approx(100.0 + pull, rel=0.02)


def test_slack_web_pulls_at_nothing() -> None:
    _, model = winder("unwinder")
    run(model, 1.0, torque=-5.0, line=0.0)  # the roll gives web that the line does not take
    assert model.stretch_m < -0.1
    assert model.tension(0.0) == 0.0
    assert model.speed == pytest.approx(5.0 / model.inertia, rel=1e-2)


def test_dry_friction_stops_a_roll_within_a_step_and_holds_it() -> None:
    _, model = winder("rewinder")
    model.break_web()
    model.speed = 0.5 / model.inertia * 0.01
    run(model, 0.1, torque=0.0, dry=0.5)
    assert model.speed == 0.0
    assert model.angle == pytest.approx(0.5 / model.inertia * 0.01**2 / 2, rel=1e-6)
    run(model, 1.0, torque=0.49, dry=0.5)
    assert model.speed == 0.0


def test_unwound_roll_ends_at_its_core() -> None:
    settings, model = winder("unwinder", initial_radius_m=0.051)
    length = settings.length_m(0.051)
    run(model, length / 2.0 - 0.1, torque=2.0, line=2.0)
    assert 0.05 < model.radius_m < 0.0501
    assert model.tension(2.0) > 0
    run(model, 0.5, torque=2.0, line=2.0)
    assert (model.is_broken, model.radius_m, model.tension(2.0)) == (True, 0.05, 0.0)


def test_web_that_a_line_draws_out_of_a_roll_that_holds_breaks_in_the_end() -> None:
    _, model = winder("rewinder", modulus_pa=1_000.0)
    run(model, 3.0, torque=0.0, dry=1_000.0, line=-1.0)  # 2 m of span
    assert (model.is_broken, model.speed) == (True, 0.0)
    model.thread_web()
    assert model.tension(0.0) == 0.0


def test_web_is_threaded_without_tension() -> None:
    _, model = winder("rewinder", initial_tension_n=100.0, dancer=DANCER)
    model.break_web()
    run(model, 2.0, torque=0.0)
    assert (model.dancer_m, model.tension(0.0)) == (0.3, 0.0)
    model.thread_web()
    assert (model.stretch_m, model.tension(0.0)) == (0.0, 0.0)


@pytest.mark.long
@pytest.mark.parametrize("role", ROLES)
@pytest.mark.parametrize("has_dancer", [False, True])
def test_transient_is_what_fine_steps_of_another_method_come_to(role: str, has_dancer: bool) -> None:
    """Explicit steps of 5 us with the speeds taken before the places."""
    keys: dict[str, Any] = {"dancer": {**DANCER, "initial_m": 0.15} if has_dancer else None, "initial_tension_n": 100.0}
    config, model = winder(role, **keys)
    sense, strands = (1, 2) if role == "rewinder" else (-1, 2)
    strands = strands if has_dancer else 0
    h = 5e-6
    w = q = angle = 0.0
    p, s, radius = (0.15 if has_dancer else 0.0), model.span_m, 0.2
    largest = 0.0
    for n in range(1, 60_001):
        line = 0.3 * min(1.0, n * h / 0.1)  # speeds up for 0.1 s
        x = 2.0 + strands * p - s
        share = 1 / (1 + max(0.0, x) / s)
        at_roll, at_line = (share, 1.0) if sense > 0 else (1.0, share)
        rate = strands * q + sense * (w * radius * at_roll - line * at_line)
        pull = max(0.0, config.stiffness_n * (x + 0.002 * rate) / s) if x > 0 else 0.0
        w += h * sense * (21.0 - radius * pull) / config.inertia_kg_m2(radius)
        if has_dancer:
            q += h * (200.0 - 60.0 * q - 2 * pull) / 4.0
            p += h * q
        angle += h * w
        s -= h * sense * (w * radius * at_roll - line * at_line)
        radius += sense * 0.0001 * w * h / math.tau
        largest = max(largest, pull)
        if n % 200 == 0:
            before, now = (min(t, 0.1) ** 2 / 0.2 + max(0.0, t - 0.1) for t in (n * h - 0.001, n * h))
            model.step(0.001, 21.0, 0.0, 0.3 * (now - before))
            assert model.tension(line) == pytest.approx(pull, abs=0.02 * largest)
            assert model.speed == pytest.approx(w, abs=0.02)
            assert model.dancer_m == pytest.approx(p, abs=1e-4)
    assert model.angle == pytest.approx(angle, abs=1e-4)


@pytest.mark.long
@settings(max_examples=60, deadline=None)
@given(
    st.sampled_from(ROLES),
    st.sampled_from([1e6, 2e9, 2e11]),
    st.sampled_from([0.0, 0.002]),
    st.booleans(),
    st.lists(
        st.tuples(
            st.floats(-500, 500), st.floats(0, 50), st.floats(-30, 30), st.floats(1e-9, 0.01), st.sampled_from("+-...")
        ),
        max_size=60,
    ),
)
def test_nothing_runs_away_whatever_comes(
    role: str, modulus: float, damping: float, has_dancer: bool, moves: list[tuple[float, float, float, float, str]]
) -> None:
    keys: dict[str, Any] = {"modulus_pa": modulus, "damping_s": damping, "dancer": DANCER if has_dancer else None}
    _, model = winder(role, **keys)
    for torque, dry, line, seconds, web in moves:
        if web == "-":
            model.break_web()
        elif web == "+" and model.radius_m > 0.05:
            model.thread_web()
        model.step(seconds, torque, dry, line * seconds)
        assert 0 <= model.tension(line) < math.inf
        assert 0 <= model.dancer_m <= 0.3
        assert 0.05 <= model.radius_m < 1.0
        assert abs(model.speed) < 1e6
