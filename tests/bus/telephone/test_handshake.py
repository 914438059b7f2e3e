"""Two modems agree once, whenever what they say to each other arrives: also while one of them speaks."""

from collections import deque
from typing import Any

from hypothesis import given
from hypothesis import strategies as st

from fieldrig.clock import MS, S, VirtualClock
from fieldrig.testing import RecordedLink
from fieldrig_bus.telephone.handshake import Handshake
from fieldrig_bus.telephone.message import Carrier, Offer, TelephoneMessage
from fieldrig_bus.telephone.modulation import OPTIONAL, everything

TRAINING_NS = 100 * MS
FRAME_NS = 10 * MS


class End:
    """A modem, and what is on its way to it."""

    def __init__(self, clock: VirtualClock, hears_while_it_speaks: deque[bool]) -> None:
        self.inbox = deque[TelephoneMessage]()
        self.other: End
        self.connected: list[Any] = []
        self.failed = 0
        self._choices = hears_while_it_speaks
        link: RecordedLink[TelephoneMessage] = RecordedLink()
        link.send = self._send  # type: ignore[method-assign]
        self.handshake = Handshake(
            clock,
            link,
            Offer(everything(), OPTIONAL),
            TRAINING_NS,
            lambda *agreed: self.connected.append(agreed),
            self._fail,
        )

    def _fail(self) -> None:
        self.failed += 1

    def _send(self, message: TelephoneMessage) -> None:
        self.other.inbox.append(message)
        if self._choices and self._choices.popleft():
            self.hear()

    def hear(self) -> None:
        while self.inbox:
            message = self.inbox.popleft()
            assert isinstance(message, Offer | Carrier)
            self.handshake.hear(message)


@given(st.lists(st.booleans(), max_size=12), st.lists(st.integers(0, 3), max_size=40))
def test_both_connect_once_whenever_they_hear(within_send: list[bool], order: list[int]) -> None:
    clock, choices = VirtualClock(), deque(within_send)
    near, far = End(clock, choices), End(clock, choices)
    near.other, far.other = far, near
    far.handshake.answer()
    for who in order:  # 0 and 1: an end hears; 2 and 3: time passes, or a second in which the host stood still
        if who < 2:
            (near, far)[who].hear()
        else:
            clock.advance_to(clock.now_ns() + (FRAME_NS if who == 2 else S))
    for _ in range(3 * S // FRAME_NS):
        near.hear()
        far.hear()
        clock.advance_to(clock.now_ns() + FRAME_NS)
    assert (len(near.connected), len(far.connected)) == (1, 1)
    assert near.connected[0][0] == far.connected[0][0]
    assert near.failed == far.failed == 0
