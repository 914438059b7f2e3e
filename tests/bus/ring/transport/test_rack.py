"""The telegrams that stations of one process leave, on their way back to the centre: none is lost."""

from collections.abc import Callable
from typing import Any, cast

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig.bus import Attachment
from fieldrig_bus.ring.pam.cycle_wire import encode_spread
from fieldrig_bus.ring.pam.message import Cycle
from fieldrig_bus.ring.pam.star_bus import NodeRack
from fieldrig_bus.ring.transport.image import SLOTS
from fieldrig_bus.ring.transport.rack import MOST_BETWEEN, MOST_LEFT
from fieldrig_bus.ring.transport.wire import decode_back


class Loop:
    """An event loop that the test turns."""

    def __init__(self) -> None:
        self._soon: list[Callable[[], None]] = []

    def call_soon(self, action: Callable[[], None]) -> None:
        self._soon.append(action)

    def turn(self) -> None:
        soon, self._soon = self._soon, []
        for action in soon:
            action()


class At:
    member = "panel"

    def deliver(self, handler: Callable[[Any], None], message: Any, instant_ns: int | None = None) -> None:
        handler(message)


class Process:
    def __init__(self) -> None:
        self.loop = Loop()
        self.rack = NodeRack("ring0", cast(Any, self.loop))
        self.backs: list[bytes] = []
        self.rack.listen(cast(Attachment, At()), lambda _message: None, [["node", 33]])
        self.rack.connect(lambda _stations: None, self.backs.append)
        self._sequence = 0

    def leave(self, number: int) -> None:
        """The station leaves a telegram, and the event loop turns."""
        self.rack.leave("panel", number.to_bytes(2, "big"))
        self.loop.turn()

    def hear(self) -> None:
        self._sequence += 1
        self.rack.on_spread(encode_spread(self._sequence, 2, [(Cycle(5, ()), ("panel",))], b"", 1))

    def numbers(self) -> list[int]:
        """The telegrams that have come back."""
        return [int.from_bytes(telegram, "big") for back in self.backs for _, telegram in decode_back(back)[2]]


def test_what_is_left_between_two_cycles_comes_back_at_once() -> None:
    process = Process()
    process.leave(1)
    assert process.numbers() == [1]


@given(st.lists(st.integers(0, 60), max_size=6))
def test_no_telegram_is_lost_or_doubled_and_the_transport_has_room_for_all_messages(bursts: list[int]) -> None:
    process, number = Process(), 0
    for burst in bursts:
        before = len(process.backs)
        for _ in range(burst):
            process.leave(number)
            number += 1
        process.hear()
        assert len(process.backs) - before <= SLOTS / 2, "also if one more cycle passes before the centre looks"
    assert process.numbers() == list(range(number))


@pytest.mark.parametrize(("left", "kept"), [(MOST_LEFT, MOST_LEFT), (MOST_LEFT + 10, MOST_LEFT + MOST_BETWEEN)])
def test_a_process_that_hears_no_cycles_keeps_the_last_telegrams(left: int, kept: int) -> None:
    process = Process()
    for number in range(left):
        process.leave(number)
    process.hear()
    assert process.numbers() == [*range(MOST_BETWEEN), *range(left - kept + MOST_BETWEEN, left)]
    assert len(process.backs) <= SLOTS
