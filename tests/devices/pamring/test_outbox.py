"""Free frames and the FIFO behind them: nothing is lost, doubled or overtaken."""

from hypothesis import given
from hypothesis import strategies as st

from fieldrig_bus.ring.pam.message import Frame
from fieldrig_devices.pamring.codec import decode_order
from fieldrig_devices.pamring.frames import Order, SetOutput, SetPoint, SetPointMode
from fieldrig_devices.pamring.outbox import Outbox


def orders(frames: list[Frame]) -> list[Order]:
    return [decode_order(contents) for _, contents in frames]


@given(st.lists(st.tuples(st.integers(0, 30), st.integers(0, 30)), max_size=12), st.integers(1, 20))
def test_commands_leave_in_order_and_set_points_at_once(bursts: list[tuple[int, int]], free: int) -> None:
    full: list[int] = []
    outbox = Outbox(free, 1_000, lambda: full.append(1))
    commands: list[Order] = []
    sent: list[Order] = []
    for number, (few, many) in enumerate(bursts):
        points: list[Order] = [SetPoint(SetPointMode.SPEED, number)] * few
        more: list[Order] = [SetOutput(len(commands) + place, number) for place in range(many)]
        commands += more
        for order in (*more, *points):
            outbox.put(1, order)
        frames = orders(list(outbox.take()))
        assert frames[:few] == points
        assert len(frames) <= max(few + 1, free)
        sent += frames[few:]
    while len(outbox):
        sent += orders(list(outbox.take()))
    assert sent == commands
    assert not full


@given(st.lists(st.one_of(st.just("take"), st.just("put")), max_size=60))
def test_a_full_fifo_is_said_once_until_it_has_been_empty(steps: list[str]) -> None:
    said: list[int] = []
    outbox = Outbox(1, 3, lambda: said.append(1))
    waiting, is_full, expected = 0, False, 0
    for step in steps:
        if step == "put":
            outbox.put(1, SetOutput(1, 1))
            expected += waiting == 3 and not is_full
            is_full |= waiting == 3
            waiting = min(waiting + 1, 3)
        else:
            outbox.take()
            waiting = max(waiting - 1, 0)
            is_full &= waiting > 0
    assert (len(said), len(outbox)) == (expected, waiting)
