"""A stepper judges pulses by their instants: messages that arrive late change neither a step nor a verdict.

What is expected is the same stepper with the same messages at once, each at the instant at which its segment begins.
In real time every message is late, and those of a ramp of single pulses all arrive after the end of their segment.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig.clock import MS, S, VirtualClock
from fieldrig.testing import RecordedLink
from fieldrig_bus.signals.pulse_train import PulseTrain
from fieldrig_bus.wires import Signal
from fieldrig_devices.hmiscu.pto.command import Order
from fieldrig_devices.hmiscu.pto.matrix import Next
from fieldrig_devices.hmiscu.pto.output import PulseOutput
from fieldrig_devices.hmiscu.pto.planner import Ends, Planner
from fieldrig_devices.hmiscu.pto.settings import PtoSettings
from fieldrig_devices.plants.stepper import Stepper
from fieldrig_devices.plants.stepper_settings import StepperSettings

US = 1_000
MOTOR: dict[str, Any] = {
    "pulse_wire": "cw", "pulses_per_turn": 1_000, "start_hz": 500.0,
    "pull_out": [(0.0, 2.0), (10.0, 2.0), (30.0, 1.0)], "motor_inertia_kg_m2": 0.001,
}  # fmt: skip
READ = ("steps", "position", "received", "sent", "missed", "surplus", "lost", "in_step", "alarm", "ready")


class Message(NamedTuple):
    at_ns: int
    signal: Signal


def played(messages: Sequence[Message], **keys: Any) -> dict[str, Any]:
    """Return the points of a stepper, and what its contacts show, long after it has received these messages."""
    clock, wires = VirtualClock(), RecordedLink[Signal]()
    stepper = Stepper(clock, "axis", StepperSettings(**{**MOTOR, **keys}), wires)
    stepper.start()
    for message in sorted(messages, key=lambda message: message.at_ns):
        clock.advance_to(message.at_ns)
        wires.deliver(message.signal)
    clock.advance_to(clock.now_ns() + 10 * S)
    shown = {signal.name: signal.value for signal in wires.sent}
    return shown | {key: stepper.points()[key].read() for key in READ}


def delayed(messages: Sequence[Message], delays: Sequence[int]) -> list[Message]:
    """Return the same with late segments; those of one wire keep their order."""
    latest: dict[str, int] = {}
    found = []
    for number, (at_ns, signal) in enumerate(messages):
        if isinstance(signal, PulseTrain):
            at_ns = max(at_ns + delays[number % len(delays)], latest.get(signal.name, 0))
            latest[signal.name] = at_ns
        found.append(Message(at_ns, signal))
    return found


def move(velocity: int, distance: int, ramp_ms: int) -> list[Message]:
    """Return the segments of PTOMoveRelative with the rounded periods of the manual: one for most pulses of a ramp."""
    segments: list[PulseTrain] = []
    output = PulseOutput("cw", segments.extend)
    plan = Planner(PtoSettings(mode="pto")).move_relative(
        Order(Next.MOVE_RELATIVE, velocity, distance, ramp_ms, ramp_ms), Ends(0, 0)
    )
    assert plan is not None
    output.begin(MS, plan, 1)
    while output.is_moving:
        output.advance(output.next_ns)
    return [Message(segment.start_ns, segment) for segment in segments]


@pytest.mark.manual("SCU-084")
@pytest.mark.parametrize("late_ns", [0, 150 * US, 30 * MS, 3 * S])
def test_a_move_in_periods_loses_no_step_however_late_it_arrives(late_ns: int) -> None:
    messages = move(5_000, 400, 100)
    assert len(messages) > 100
    found = played(delayed(messages, [late_ns]))
    assert (found["steps"], found["lost"], found["alarm"], found["axis.ready"]) == (400, 0, False, True)


def test_an_alarm_is_not_shown_while_the_messages_of_a_ramp_come_late() -> None:
    """The process of the stepper takes longer for a message than the pulses do, so that it is more and more late."""
    clock, wires = VirtualClock(), RecordedLink[Signal]()
    Stepper(clock, "axis", StepperSettings(**MOTOR), wires).start()
    for number, (at_ns, signal) in enumerate(move(5_000, 400, 100)):
        clock.advance_to(at_ns + number * 5 * MS)
        wires.deliver(signal)
    clock.advance_to(clock.now_ns() + S)
    assert [signal.value for signal in wires.sent if signal.name == "axis.alarm"] == [False]


@pytest.mark.parametrize("late_ns", [0, 150 * US, 30 * MS, 3 * S])
@pytest.mark.parametrize("is_told", [True, False], ids=["rest", "silence"])
def test_an_abrupt_stop_costs_a_pole_pair_however_late_it_arrives(late_ns: int, is_told: bool) -> None:
    """A sender may say that it rests, as an HMISCU does, or send nothing more, as a generator does."""
    train = PulseTrain("cw", 0, start_ns=MS, frequency=400, count=4)
    fast = train.then(train.end_ns or 0, 900, count=50)
    rest = fast.then(fast.end_ns or 0)
    messages = [Message(one.start_ns, one) for one in (train, fast, rest)[: 3 if is_told else 2]]
    found = played(delayed(messages, [late_ns]))
    assert (found["steps"], found["lost"], found["alarm"]) == (34, 1_000 // 50, True)


@pytest.mark.parametrize("late_ns", [0, 150 * US, 30 * MS, 300 * MS])
def test_a_stop_that_nothing_told_of_is_before_a_reset_and_the_next_move(late_ns: int) -> None:
    """The last message before the silence is so late that the next one arrives while the first is still news."""
    train = PulseTrain("cw", 0, start_ns=MS, frequency=400, count=4)
    fast = train.then(train.end_ns or 0, 900, count=50)
    slow = fast.then(450 * MS, 400, count=10)
    messages = [Message(MS + late_ns, train), Message(fast.start_ns + late_ns, fast), Message(450 * MS, slow)]
    found = played([*messages, Message(400 * MS, Signal("axis.reset", True))])
    assert (found["steps"], found["lost"], found["alarm"]) == (44, 20, False)


def test_segments_that_are_announced_before_they_begin() -> None:
    train = PulseTrain("cw", 0, start_ns=S, frequency=400, count=4)
    fast = train.then(train.end_ns or 0, 900, count=50)
    slow = fast.then(fast.end_ns or 0, 450, count=4)
    found = played([Message(number, one) for number, one in enumerate((train, fast, slow))])
    assert (found["received"], found["steps"], found["lost"]) == (58, 58, 0)


class Run(NamedTuple):
    frequency: int
    rate: int
    pulses: int
    direction: int
    cut_us: int | None
    pause_us: int | None
    """Time at rest after it, of which the sender tells; None goes on at once."""


RUNS = st.lists(
    st.builds(
        Run,
        st.sampled_from((100, 400, 500, 900, 1_000, 1_400, 5_000)) | st.integers(1, 40_000),
        st.sampled_from((0, 0, 0, 2_000, -2_000, 400_000)),
        st.integers(1, 30),
        st.sampled_from((1, 1, 1, -1)),
        st.none() | st.integers(1, 20_000),
        st.none() | st.sampled_from((0, 300, 3_000, 700_000)),
    ),
    max_size=8,
)
INPUTS = st.lists(
    st.tuples(
        st.integers(0, 1_500_000),
        st.sampled_from(("axis.reset", "enable", "axis.load_torque")),
        st.sampled_from((0.0, 1.0, 2.5)),
    ),
    max_size=5,
)
DELAYS = st.lists(st.sampled_from((0, 0, 100, 5_000, 400_000)) | st.integers(0, 2_000_000), min_size=1, max_size=8)


def sent(wire: str, runs: Sequence[Run], start_ns: int = MS) -> list[Message]:
    """Return the segments of runs one after the other, each beginning a whole number of microseconds later."""
    train, trains, odd_ns = PulseTrain(wire, 0), [], start_ns % US
    for run in runs:
        train = train.then(start_ns, run.frequency, run.rate, run.pulses, direction=run.direction)
        trains.append(train)
        ends = [] if train.end_ns is None else [-(-(train.end_ns - odd_ns) // US) * US + odd_ns]
        ends += [] if run.cut_us is None else [start_ns + run.cut_us * US]
        start_ns = min(ends)
        if run.pause_us is not None:
            train = train.then(start_ns)
            trains.append(train)
            start_ns += run.pause_us * US
    return [Message(train.start_ns, train) for train in trains]


@pytest.mark.long
@pytest.mark.parametrize("detects_loss", [True, False])
@settings(max_examples=60)
@given(runs=RUNS, inputs=INPUTS, delays=DELAYS)
def test_late_messages_change_neither_a_step_nor_a_verdict(
    detects_loss: bool, runs: list[Run], inputs: list[tuple[int, str, float]], delays: list[int]
) -> None:
    keys = {"detects_loss": detects_loss, "enable_wire": "enable"}
    messages = [Message(0, Signal("enable", True)), *sent("cw", runs)]
    messages += [Message(at_us * US + 500, Signal(name, value)) for at_us, name, value in inputs]
    assert played(delayed(messages, [delay * US for delay in delays]), **keys) == played(messages, **keys)


@pytest.mark.long
@settings(max_examples=60)
@given(cw=RUNS, ccw=RUNS, delays=DELAYS)
def test_late_messages_on_two_wires(cw: list[Run], ccw: list[Run], delays: list[int]) -> None:
    keys = {"mode": "cw_ccw", "ccw_wire": "ccw"}
    messages = [*sent("cw", cw), *sent("ccw", ccw, MS + 500)]
    assert played(delayed(messages, [delay * US for delay in delays]), **keys) == played(messages, **keys)
