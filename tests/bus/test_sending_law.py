"""Sending a message that cannot be on the bus raises at the sender: every installed kind of bus, at every end.

Each installed kind is included automatically; a kind with messages of its own needs rows for them in `sendable`.
"""

import asyncio
from pathlib import Path
from typing import Any

import pytest
from sendable import BAD, BAD_INTERESTS, GOOD, NO_MESSAGES
from strangers import bus_of, direct_kinds, hub_kinds, kind_names

from fieldrig.bus import Bus, ModelBus
from fieldrig.config import kinds
from fieldrig.hub.attach import RemoteLink
from fieldrig.hub.checked_link import CheckedLink
from fieldrig.hub.hub import LocalHub
from fieldrig.link import Link, patience_of
from fieldrig.loop.real_clock import RealClock
from fieldrig.virtual.node import EventNode, Outbox


def messages_of(kind: str) -> tuple[type, ...]:
    return kinds.find_bus(kind).messages


def rows(table: dict[type, list[Any]], bus: Bus[Any]) -> list[Any]:
    return [message for sort in bus.messages for message in table.get(sort, [])]


def foreign_messages_of(bus: Bus[Any]) -> list[Any]:
    """Objects that are not messages of this bus, including the messages of all others."""
    others = [message for sort, several in GOOD.items() if sort not in bus.messages for message in several]
    if bus.family == "can":  # CanControl is a message of every CAN bus, even where it has no effect
        others = [other for other in others if type(other).__name__ not in ("CanControl", "BitRate")]
    return NO_MESSAGES + others


def check_law(bus: Bus[Any], link: Link[Any]) -> None:
    for wrong in rows(BAD, bus) + foreign_messages_of(bus):
        with pytest.raises((TypeError, ValueError)) as raised:
            link.send(wrong)
        assert type(raised.value) in (TypeError, ValueError), wrong
        assert str(raised.value).startswith("io cannot send "), wrong
        assert " on bus0: " in str(raised.value), wrong
    for wrong in BAD_INTERESTS:
        with pytest.raises((TypeError, ValueError), match=r"^io cannot listen to .* on bus0: "):
            link.on_receive(lambda _: None, wrong)


@pytest.mark.parametrize("kind", kind_names())
def test_every_message_of_a_kind_has_its_rows(kind: str) -> None:
    for sort in messages_of(kind):
        assert sort in BAD, f"{kind}: tests/support/sendable.py says nothing of {sort.__name__}"


@pytest.mark.parametrize("kind", [kind for kind in kind_names() if "virtual" in kinds.find_bus(kind).times])
def test_in_virtual_time(kind: str) -> None:
    bus = bus_of(kind)
    node = EventNode("io", outbox=Outbox({"bus0": bus}))
    check_law(bus, node.link("bus0"))
    assert node.outbox.sent == []
    for good in rows(GOOD, bus):
        node.link("bus0").send(good)
    assert len(node.outbox.sent) == len(rows(GOOD, bus))


@pytest.mark.parametrize("kind", hub_kinds())
def test_in_the_hubs_process_and_in_another(kind: str, tmp_path: Path) -> None:
    async def scene() -> None:
        bus = bus_of(kind)
        assert isinstance(bus, ModelBus)
        clock = RealClock(asyncio.get_running_loop())
        hub = LocalHub(bus, clock, tmp_path)
        remote = RemoteLink(bus, "io", clock, tmp_path, pytest.fail)
        for link in (hub.join("io"), remote):
            check_law(bus, link)
            for good in rows(GOOD, bus):
                link.send(good)
        clock.close()

    asyncio.run(scene())


class Medium:
    """The end of a direct bus, which records what reaches it."""

    def __init__(self) -> None:
        self.sent: list[Any] = []
        self.patience_ns = 7

    def send(self, message: Any) -> None:
        self.sent.append(message)

    def on_receive(self, handler: Any, interest: Any = None) -> None:
        self.interest = interest


@pytest.mark.parametrize("kind", direct_kinds())
def test_at_a_direct_bus(kind: str) -> None:
    bus = bus_of(kind)
    medium = Medium()
    link = CheckedLink(medium, bus, "io")
    check_law(bus, link)
    assert medium.sent == []
    good = rows(GOOD, bus)
    for message in good:
        link.send(message)
    assert medium.sent == good
    assert good
    assert patience_of(link) == 7  # the patience of the bus's own end is still there


@pytest.mark.parametrize("kind", kind_names())
def test_any_sendable_message_crosses_to_another_process_unchanged(kind: str) -> None:
    bus = bus_of(kind)
    for message in rows(GOOD, bus):
        assert bus.decode(bus.encode(message)) == message
