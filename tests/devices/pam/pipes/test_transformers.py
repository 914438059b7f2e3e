"""Each transformer alone against its formula and its states (chapter 5 of the manual)."""

import math
from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig_devices.pam.pipes.amplifier import Amplifier
from fieldrig_devices.pam.pipes.block import effective_period_s, nearest, wrapped
from fieldrig_devices.pam.pipes.cam import Cam, Profile
from fieldrig_devices.pam.pipes.comparator import Comparator
from fieldrig_devices.pam.pipes.corrector import Corrector, Settings
from fieldrig_devices.pam.pipes.derivator import Derivator
from fieldrig_devices.pam.pipes.distributor import Distributor
from fieldrig_devices.pam.pipes.phaser import Phaser

MS = 0.001


@pytest.mark.manual("PAML-413")
@pytest.mark.parametrize(
    ("period_s", "thirds", "effective"),
    [(0.001, 3, 0.001), (0.001, 6, 0.002), (0.0104, 3, 0.010), (0.0, 3, 0.001), (0.003, 6, 0.004)],
)
def test_periods_are_multiples_of_the_basic_cycle(period_s: float, thirds: int, effective: float) -> None:
    assert effective_period_s(period_s, thirds) == pytest.approx(effective)


@given(st.floats(-1e6, 1e6), st.floats(0.5, 1e4))
def test_wrapped_values_are_inside_the_period(value: float, period: float) -> None:
    assert 0 <= wrapped(value, period) < period
    assert abs(nearest(value, period)) <= period / 2 * (1 + 1e-9)


@pytest.mark.manual("PAML-430")
@pytest.mark.manual("PAML-431")
def test_amplifier() -> None:
    block = Amplifier(gain=2, offset=5, gain_slope=1, offset_slope=None)
    block.set_gain(3)  # at once, as it is not active
    assert block.gain.value == 3
    block.set_gain(2)
    block.start(MS)
    assert block.pass_on(10) == 30
    block.set_gain(4)
    block.set_offset(0)
    gains = []
    while not block.ready:
        block.pass_on(1)
        gains.append(block.gain.value)
    assert len(gains) == 2000  # 2 s
    assert gains[999] == pytest.approx(3)
    block.set_gain(10)
    block.stop()
    assert block.gain.value == 10  # PAML-433


@pytest.mark.manual("PAML-440")
@pytest.mark.parametrize(("value", "output"), [(0, 10), (20, 10), (110, 35), (200, 60), (380, 110), (400, 110)])
def test_the_range_of_a_cam_begins_at_its_input_offset(value: float, output: float) -> None:
    block = Cam(Profile(lambda z: z, 360, 100, 20, 10), None)
    assert block.profile.at(value) == pytest.approx(output)


@pytest.mark.manual("PAML-440")
@pytest.mark.parametrize(("value", "output"), [(-5, 10), (0, 10), (90, 35), (360, 110), (400, 110)])
def test_cam(value: float, output: float) -> None:
    block = Cam(Profile(lambda z: z, 360, 100, 0, 10), None)
    block.start(MS)
    assert block.pass_on(value) == pytest.approx(output)


@pytest.mark.manual("PAML-443")
def test_cam_changes_its_profile_with_the_next_value() -> None:
    block = Cam(Profile(lambda z: z, 360, 100, 0, 10), value_period=50)
    block.start(MS)
    assert block.pass_on(360) == pytest.approx(10)  # 110 in a period of 50
    block.profile = Profile(lambda z: z * z, 360, 100, 0, 0)
    assert block.pass_on(180) == pytest.approx(25)


@pytest.mark.manual("PAML-461")
@pytest.mark.manual("PAML-464")
@pytest.mark.manual("PAML-465")
def test_comparator_starts_routines_at_each_change() -> None:
    block = Comparator(180)
    started: list[str] = []
    block.routine = lambda: started.append("up")
    block.reverse_routine = lambda: started.append("down")
    block.start(MS)
    assert [block.pass_on(value) for value in (200, 179, 180, 181, 5)] == [200, 179, 180, 181, 5]
    assert started == ["down", "up", "down"]  # none for the first value
    assert not block.ready


@pytest.mark.manual("PAML-462")
def test_comparator_waits_for_the_limit_of_the_period() -> None:
    block = Comparator(0)
    block.period = 500
    block.start(MS)
    block.pass_on(400)
    block.set_reference(326, is_through_zero=True)
    seen = []
    for value in (400, 450, 499, 20, 325, 326):
        block.pass_on(value)
        seen.append(block.ready)
    assert seen == [False, False, False, False, False, True]
    block.pass_on(20)  # afterwards as in the normal mode
    assert not block.ready


@pytest.mark.manual("PAML-531")
@pytest.mark.parametrize(("period", "answer"), [(360, 1000), (1000, -359000), (None, -359000)])
def test_derivator(period: float | None, answer: float) -> None:
    block = Derivator(period)
    block.start(MS)
    assert [block.pass_on(value) for value in (358, 359, 0)] == [0, pytest.approx(1000), pytest.approx(answer)]


@pytest.mark.manual("PAML-542")
def test_distributors_share_the_periods_of_their_network() -> None:
    pipes = {2: Distributor(5, 0), 3: Distributor(5, 1), 4: Distributor(5, 2)}
    computed = [{1} | {pipe for pipe, block in pipes.items() if block.computes_in(number)} for number in range(6)]
    assert computed == [{1, 2}, {1, 3}, {1, 4}, {1}, {1}, {1, 2}]
    assert Distributor(0, 0).computes_in(7)


@pytest.mark.manual("PAML-580")
@pytest.mark.manual("PAML-582")
@pytest.mark.manual("PAML-583")
def test_phaser_stops_and_starts_at_its_standby_value() -> None:
    block = Phaser(phase=10, phase_slope=None, standby_value=0, value_period=90)
    block.start(MS)
    assert block.pass_on(70) == 80
    block.command_stop()
    assert (block.pass_on(75), block.ready) == (85, False)
    assert (block.pass_on(85), block.ready) == (0, True)  # 5 in the next period: past the stand-by value
    assert block.pass_on(40) == 0
    block.command_start()
    assert (block.pass_on(60), block.ready) == (0, False)
    assert (block.pass_on(82), block.ready) == (2, True)


@pytest.mark.manual("PAML-584")
@pytest.mark.manual("PAML-585")
@pytest.mark.manual("PAML-588")
def test_phaser_slews_its_phase_only_while_started() -> None:
    block = Phaser(phase=0, phase_slope=1000, standby_value=135, value_period=90)
    block.start(MS)
    assert block.standby_value == 45
    block.set_phase(3)
    assert [block.pass_on(0) for _ in range(4)] == [1, 2, 3, 3]
    block.set_phase(0)
    block.command_stop()
    assert block.phase.value == 0  # PAML-587
    block.pass_on(40)
    block.pass_on(50)
    assert block.state == "stopped"
    block.standby_value = 91
    assert block.value == 1
    block.set_phase(20)
    assert block.phase.value == 20


def corrected(block: Corrector, flow: list[float]) -> list[float]:
    return [block.pass_on(value) for value in flow]


@pytest.mark.manual("PAML-503")
@pytest.mark.manual("PAML-507")
@pytest.mark.parametrize(("is_output", "correction"), [(True, 10), (False, -10)])
def test_corrector_moves_the_flow_by_the_difference(is_output: bool, correction: float) -> None:
    block = Corrector(Settings(is_immediate=True, is_output=is_output, is_repetitive=False), 1000, 100, 0)
    block.start(MS)
    corrected(block, [170, 170, 170])
    block.event()
    assert block.state == "standby"  # not triggered yet
    block.trigger(180)
    assert (block.ready, block.triggered) == (True, False)
    block.event()
    assert (block.correction, block.ready, block.triggered) == (correction, False, True)
    flow = corrected(block, [170] * 1000)
    assert flow[-1] == pytest.approx(170 + correction)
    assert (block.state, block.ready) == ("standby", True)
    steps = [abs(after - before) for before, after in pairwise(flow)]
    assert max(steps) <= 100 * MS * (1 + 1e-9)  # CORRECTION_LEVEL


@pytest.mark.manual("PAML-508")
def test_a_repetitive_corrector_stays_armed() -> None:
    block = Corrector(Settings(is_immediate=True, is_output=True, is_repetitive=True), 1e6, 1e4, 0)
    block.start(MS)
    corrected(block, [170, 170, 170])
    block.trigger(180)
    for _ in range(2):
        block.event()
        assert (block.ready, block.triggered) == (False, False)
        corrected(block, [170] * 100)
        assert block.state == "wait event"
    assert block.value == pytest.approx(180)  # the second event found no difference


@pytest.mark.manual("PAML-509")
@pytest.mark.manual("PAML-510")
def test_a_corrector_on_request_waits_for_its_start() -> None:
    block = Corrector(Settings(is_immediate=False, is_output=True, is_repetitive=False), 1e6, 1e4, 0)
    block.start(MS)
    corrected(block, [170, 170])
    block.start_correction()
    assert block.state == "standby"
    block.trigger(180)
    block.event()
    assert (block.state, block.correction) == ("wait correction", 10)
    block.start_correction(3.5)
    assert corrected(block, [170] * 100)[-1] == pytest.approx(173.5)


@pytest.mark.manual("PAML-513")
def test_the_delay_of_the_sensor_is_computed_back() -> None:
    block = Corrector(Settings(is_immediate=False, is_output=False, is_repetitive=False), 1, 1, delay_s=0.01)
    block.start(MS)
    corrected(block, [100 + step for step in range(10)])  # 1000 u/s
    block.trigger(0)
    block.event()
    assert list(block.latched) == pytest.approx([99, 1000, 0])


@pytest.mark.manual("PAML-513", "PAML-517")
@pytest.mark.parametrize("age_s", [0, 0.004])
def test_a_flow_that_accelerates_is_computed_back_along_its_parabola(age_s: float) -> None:
    block = Corrector(Settings(is_immediate=False, is_output=False, is_repetitive=False), 1, 1, delay_s=0.01)
    block.start(MS)
    corrected(block, [500 * (step * MS) ** 2 for step in range(101)])  # 1000 u/s^2 for 100 ms
    block.trigger(0)
    block.event(age_s)
    seen_s = 0.1 - 0.01 - age_s
    assert list(block.latched) == pytest.approx([500 * seen_s**2, 1000 * seen_s, 1000])


@pytest.mark.long
@settings(max_examples=40)
@given(st.lists(st.floats(-10, 10), min_size=1, max_size=5), st.floats(10, 1e4), st.floats(1, 1e3))
def test_corrections_are_continuous_and_add_up(values: list[float], slope: float, level: float) -> None:
    block = Corrector(Settings(is_immediate=False, is_output=True, is_repetitive=True), slope, level, 0)
    block.start(MS)
    block.pass_on(0)
    block.trigger(0)
    last, total = 0.0, 0.0
    for value in values:
        block.event()
        block.start_correction(value)
        total += value
        while not block.ready:
            now = block.pass_on(0)
            assert abs(now - last) <= level * MS * (1 + 1e-6) + 1e-9
            last = now
    assert math.isclose(last, total, abs_tol=1e-6)


@pytest.mark.manual("PAML-509")
def test_triggered_is_true_while_a_correction_is_requested() -> None:
    block = Corrector(Settings(is_immediate=False, is_output=True, is_repetitive=True), 1e6, 1e4, 0)
    block.start(MS)
    corrected(block, [170, 170])
    block.trigger(180)
    block.event()
    assert (block.ready, block.triggered) == (True, True)  # G-33
    block.start_correction()
    assert (block.ready, block.triggered) == (False, False)


@pytest.mark.manual("PAML-506")
@pytest.mark.manual("PAML-512")
@pytest.mark.parametrize(
    ("is_repetitive", "command", "state"),
    [
        (False, None, "standby"),
        (True, None, "wait event"),
        (False, "trigger", "wait event"),
        (True, "trigger_off", "standby"),
    ],
)
def test_commands_during_a_correction_work_after_it(is_repetitive: bool, command: str | None, state: str) -> None:
    block = Corrector(Settings(is_immediate=True, is_output=True, is_repetitive=is_repetitive), 1e6, 1e4, 0)
    block.start(MS)
    corrected(block, [170, 170])
    block.trigger(180)
    block.event()
    if command == "trigger":
        block.trigger(200)
    elif command == "trigger_off":
        block.trigger_off()
    assert block.state == "in correction"
    assert corrected(block, [170] * 100)[-1] == pytest.approx(180)
    assert block.state == state


@pytest.mark.manual("PAML-503")
def test_the_sign_of_the_reference_input_can_be_reversed() -> None:
    settings = Settings(is_immediate=True, is_output=False, is_repetitive=False, is_input_sign_reversed=True)
    block = Corrector(settings, 1000, 100, 0)
    block.start(MS)
    corrected(block, [170, 170])
    block.trigger(180)
    block.event()
    assert block.correction == 10


@pytest.mark.manual("PAML-518")
def test_a_correction_in_a_periodic_flow_takes_the_shorter_way() -> None:
    block = Corrector(Settings(is_immediate=True, is_output=True, is_repetitive=False, value_period=360), 1000, 100, 0)
    block.start(MS)
    corrected(block, [355, 358, 1])
    block.trigger(350)
    block.event()
    assert block.correction == -11
    assert block.latched == (1, 3000, 0)


@pytest.mark.manual("PAML-583")
def test_a_phaser_that_waits_at_its_standby_value_starts_at_once() -> None:
    block = Phaser(phase=0, phase_slope=None, standby_value=0, value_period=90)
    block.command_stop()
    block.start(MS)
    assert block.pass_on(0) == 0
    block.command_start()
    assert (block.pass_on(2), block.ready) == (2, True)


@pytest.mark.manual("PAML-436")
@given(st.lists(st.floats(-40, 40), min_size=1, max_size=20), st.floats(-5, 5))
def test_an_amplifier_has_no_step_where_its_input_begins_again(ways: list[float], gain: float) -> None:
    block = Amplifier(gain, 0)
    block.period = 90
    block.start(MS)
    place = 10.0
    first = block.pass_on(place)
    for way in ways:
        place += way
        assert block.pass_on(wrapped(place, 90)) == pytest.approx(first + gain * (place - 10), abs=1e-6)


@pytest.mark.manual("PAML-431")
@given(
    st.lists(
        st.tuples(st.sampled_from(["gain", "offset"]), st.floats(-5, 5), st.integers(1, 50)), min_size=1, max_size=8
    ),
    st.floats(0.1, 100),
)
def test_a_slewed_amplifier_never_steps(commands: list[tuple[str, float, int]], slope: float) -> None:
    block = Amplifier(1, 0, slope, slope)
    block.start(MS)
    last = block.pass_on(3)
    for name, value, periods in commands:
        (block.set_gain if name == "gain" else block.set_offset)(value)
        for _ in range(periods):
            now = block.pass_on(3)
            assert abs(now - last) <= slope * MS * (5 + 3 + 5) * (1 + 1e-6)
            last = now


@pytest.mark.manual("PAML-582")
@pytest.mark.manual("PAML-584")
@given(
    st.lists(
        st.tuples(st.sampled_from(["start", "stop", "phase"]), st.floats(-200, 200), st.integers(1, 80)),
        min_size=1,
        max_size=10,
    ),
    st.floats(-3, 3),
)
def test_a_phaser_never_steps(commands: list[tuple[str, float, int]], speed: float) -> None:
    """A stop in the middle of a slew is left out, since it applies the rest of the slew at once (PAML-587)."""
    block = Phaser(phase=0, phase_slope=1000, standby_value=20, value_period=90)
    block.start(MS)
    place = 10.0
    last = block.pass_on(place)
    for name, value, periods in commands:
        if name == "start":
            block.command_start()
        elif name == "phase":
            block.set_phase(value)
        elif block.phase.is_there:
            block.command_stop()
        for _ in range(periods):
            place = wrapped(place + speed, 90)
            now = block.pass_on(place)
            assert abs(nearest(now - last, 90)) <= abs(speed) + 1000 * MS + 1e-6
            last = now
