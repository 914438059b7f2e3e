"""The guarantees of every link that carries CAN frames, regardless of the medium behind it.

A suite subclasses `CanLinkLaws` and has a fixture `wire`.
No case waits for nothing to happen: a frame that is let through comes after the one that must not be.
"""

from collections.abc import Callable, Sequence
from typing import Any, Protocol

import pytest

from fieldrig.link import Link
from fieldrig_bus.can.acceptance import EXTENDED
from fieldrig_bus.can.frame import FD_LENGTHS, CanFrame

MARK = CanFrame(0x7FE, b"mark")


class Wire(Protocol):
    """One bus with three members, and a way to let time pass."""

    @property
    def a(self) -> Link[CanFrame]: ...
    @property
    def b(self) -> Link[CanFrame]: ...
    @property
    def c(self) -> Link[CanFrame]: ...

    carries_fd: bool

    def settle(self) -> None:
        """Return when what the links were asked for, such as a change of interest, is in force."""

    def pump(self, until: Callable[[], bool]) -> None:
        """Let time pass until the condition holds; fail if it doesn't in a generous time."""

    def garble(self, data: bytes) -> None:
        """Put bytes that are no frame in where bytes come in from outside."""


def listen(wire: Wire, link: Link[CanFrame], interest: Sequence[Any] | None = None) -> list[CanFrame]:
    """Return a list of what the link receives from now on."""
    heard: list[CanFrame] = []
    link.on_receive(heard.append, interest)
    wire.settle()
    return heard


def sent(wire: Wire, link: Link[CanFrame], frames: Sequence[CanFrame], heard: list[CanFrame]) -> list[CanFrame]:
    """Return what is received until as many frames have arrived as were sent."""
    for frame in frames:
        link.send(frame)
    wire.pump(lambda: len(heard) >= len(frames))
    return heard


def until_mark(wire: Wire, link: Link[CanFrame], heard: list[CanFrame]) -> list[CanFrame]:
    """Return what is received before a mark that the link sends now."""
    link.send(MARK)
    wire.pump(lambda: MARK in heard)
    return heard[: heard.index(MARK)]


class CanLinkLaws:
    def test_data_of_every_length_arrives_in_order(self, wire: Wire) -> None:
        frames = [CanFrame(0x123, bytes(range(0xF0, 0xF0 + length))) for length in (8, *range(9))]
        assert sent(wire, wire.a, frames, listen(wire, wire.b)) == frames

    def test_the_outermost_identifiers_of_both_formats_arrive(self, wire: Wire) -> None:
        frames = [
            CanFrame(0x7FF),
            CanFrame(0),
            *(CanFrame(n, b"\x01", is_extended=True) for n in (0x1FFF_FFFF, 0, 0x7FF)),
        ]
        assert sent(wire, wire.a, frames, listen(wire, wire.b)) == frames

    def test_remote_frames_say_how_much_they_ask_for(self, wire: Wire) -> None:
        frames = [
            *(CanFrame(0x701, is_remote=True, remote_length=length) for length in range(9)),
            CanFrame(0x18FEF100, is_extended=True, is_remote=True, remote_length=3),
        ]
        assert sent(wire, wire.a, frames, listen(wire, wire.b)) == frames

    def test_fd_frames_of_every_length_arrive(self, wire: Wire) -> None:
        if not wire.carries_fd:
            pytest.skip("this bus is a classical one by its definition")
        frames = [
            CanFrame(0x123, bytes([length] * length), is_fd=True, is_bit_rate_switched=is_switched)
            for length in FD_LENGTHS
            for is_switched in (False, True)
        ]
        frames.append(CanFrame(0x1FFF_FFFF, bytes(64), is_extended=True, is_fd=True))
        assert sent(wire, wire.a, frames, listen(wire, wire.b)) == frames

    def test_frames_go_both_ways(self, wire: Wire) -> None:
        at_a, at_b = listen(wire, wire.a), listen(wire, wire.b)
        wire.a.send(CanFrame(0x601, b"request"))
        wire.pump(lambda: bool(at_b))
        wire.b.send(CanFrame(0x581, b"answer"))
        wire.pump(lambda: bool(at_a))
        assert (at_b, at_a) == ([CanFrame(0x601, b"request")], [CanFrame(0x581, b"answer")])

    def test_a_handler_may_answer(self, wire: Wire) -> None:
        at_a = listen(wire, wire.a)
        wire.b.on_receive(lambda frame: wire.b.send(CanFrame(frame.identifier + 1, frame.data)))
        wire.settle()
        assert sent(wire, wire.a, [CanFrame(0x100, b"\x05")], at_a) == [CanFrame(0x101, b"\x05")]

    def test_all_others_hear_and_the_sender_does_not(self, wire: Wire) -> None:
        at_a, at_b, at_c = listen(wire, wire.a), listen(wire, wire.b), listen(wire, wire.c)
        assert sent(wire, wire.a, [CanFrame(0x100)], at_b) == [CanFrame(0x100)]
        assert until_mark(wire, wire.b, at_a) == []
        wire.pump(lambda: MARK in at_c)
        assert at_c == [CanFrame(0x100), MARK]

    def test_only_what_is_of_interest_arrives(self, wire: Wire) -> None:
        base = 0x181 << 18
        at_b = listen(
            wire,
            wire.b,
            [[0x180, 0x780 | EXTENDED], [base | EXTENDED, 0x1FFF_FFFF | EXTENDED], [MARK.identifier, 0x7FF]],
        )
        wanted = [CanFrame(0x181), CanFrame(0x1FF, b"\x01"), CanFrame(base, is_extended=True)]
        unwanted = [CanFrame(0x201), CanFrame(0x181, is_extended=True), CanFrame(base + 1, is_extended=True)]
        for pair in zip(unwanted, wanted, strict=True):
            for frame in pair:
                wire.a.send(frame)
        assert until_mark(wire, wire.a, at_b) == wanted

    def test_an_empty_interest_is_silence(self, wire: Wire) -> None:
        at_b, at_c = listen(wire, wire.b, []), listen(wire, wire.c)
        sent(wire, wire.a, [CanFrame(0x100), CanFrame(0, is_extended=True)], at_c)
        assert at_b == []
        at_b = listen(wire, wire.b)
        assert until_mark(wire, wire.a, at_b) == []

    def test_a_new_interest_replaces_the_old_one(self, wire: Wire) -> None:
        before, at_c = listen(wire, wire.b, [[0x100, 0x7FF]]), listen(wire, wire.c)
        sent(wire, wire.a, [CanFrame(0x100)], at_c)
        wire.pump(lambda: bool(before))
        after = listen(wire, wire.b, [[0x200, 0x7FF], [MARK.identifier, 0x7FF]])
        for frame in (CanFrame(0x100), CanFrame(0x200)):
            wire.a.send(frame)
        assert until_mark(wire, wire.a, after) == [CanFrame(0x200)]
        assert before == [CanFrame(0x100)]

    def test_a_burst_of_1000_frames_arrives_complete_and_in_order(self, wire: Wire) -> None:
        frames = [CanFrame(0x100 + number % 7, number.to_bytes(8, "big")) for number in range(1000)]
        assert sent(wire, wire.a, frames, listen(wire, wire.b)) == frames

    def test_garbage_from_outside_disturbs_no_member(self, wire: Wire) -> None:
        at_b = listen(wire, wire.b)
        for garbage in (b"", b"\x00", b"\xff" * 5, b"\xff" * 100, b"GET / HTTP/1.1\r\n\r\n"):
            wire.garble(garbage)
        assert sent(wire, wire.a, [CanFrame(0x123, b"still")], at_b) == [CanFrame(0x123, b"still")]
