"""The sockets of the page: topics, frames, acknowledgements, and messages that are not understood."""

from typing import Any, ClassVar

import msgpack
import pytest
from hypothesis import given
from hypothesis import strategies as st
from in_loop import in_loop
from page_bench import TANK, page_of

from fieldrig.outside.untrusted import MalformedError
from fieldrig_page.live import MOST_SOCKETS, MOST_UNSEEN, Live, Page
from fieldrig_page.wire import LONGEST, taken


class Numbers:
    """A topic that has something new in every tick, and begins with everything after each request."""

    name: ClassVar[str] = "numbers"

    def __init__(self) -> None:
        self.next: dict[Page, int] = {}
        self.count = 0

    def want(self, page: Page, wish: Any) -> None:
        if wish != "all":
            raise MalformedError("expected all")
        self.next[page] = 0

    def forget(self, page: Page) -> None:
        self.next.pop(page, None)

    def frame(self, page: Page) -> dict[str, Any] | None:
        self.count += 1
        first, self.next[page] = self.next[page], self.count
        return {"first": first, "end": self.count}

    async def run(self) -> None:
        pass


def wanting(live: Live) -> Page:
    page = Page("look")
    live.take(page, msgpack.packb({"t": "want", "topic": "numbers", "wish": "all"}))
    return page


async def frames(page: Page, count: int) -> list[tuple[int, int]]:
    ticks = [msgpack.unpackb(await page.next()) for _ in range(count)]
    return [(message["first"], message["end"]) for _number, message in ticks]


@in_loop
async def test_a_page_that_does_not_acknowledge_is_left_out_and_then_gets_everything_anew() -> None:
    live = Live([Numbers()], {})
    page = wanting(live)
    for _ in range(10):
        live.tick(page)
    assert await frames(page, MOST_UNSEEN) == [(0, 1), (1, 2), (2, 3)]
    assert live.left_out == 10 - MOST_UNSEEN
    live.take(page, msgpack.packb({"t": "seen", "number": MOST_UNSEEN}))
    live.tick(page)
    assert await frames(page, 1) == [(0, 4)]


@in_loop
async def test_nothing_is_sent_once_nothing_is_wanted() -> None:
    topic = Numbers()
    live = Live([topic], {})
    page = wanting(live)
    live.take(page, msgpack.packb({"t": "want", "topic": "numbers", "wish": None}))
    live.tick(page)
    assert page.may_be_sent
    assert topic.count == 0
    assert topic.next == {}


@pytest.mark.long
@in_loop
async def test_a_socket_greets_and_shows_what_is_wanted() -> None:
    async with page_of(TANK) as page:
        socket = await page.socket("look")
        hello = await socket.until("hello")
        assert (hello["rig"], hello["role"], hello["time"]) == ("rig", "look", "virtual")
        await socket.send({"t": "want", "topic": "rig", "wish": True})
        assert (await socket.until("rig"))["state"] == "paused"
        await page.call("POST", "rig/step", {"for": "10 ms"})
        assert (await socket.until("rig", lambda rig: rig["now_ns"] > 0))["now_ns"] == 10_000_000
        await socket.close()
        assert not page.site.live.pages


MALFORMED = {
    "no MessagePack": b"\xc1",
    "nothing": b"",
    "half a map": b"\x81\xa1t",
    "a long array that is not there": b"\x82\xa1t\xa4want\xa5topic\xdd\xff\xff\xff\xff",
    "deep": b"\x91" * 5000,
    "no map": msgpack.packb([1]),
    "another type": msgpack.packb({"t": 1}),
    "an unknown type": msgpack.packb({"t": "halt"}),
    "an unknown topic": msgpack.packb({"t": "want", "topic": "secrets", "wish": True}),
    "a request that is not understood": msgpack.packb({"t": "want", "topic": "rig", "wish": [1]}),
    "a tick that was not sent": msgpack.packb({"t": "seen", "number": 99}),
    "a number of bytes": msgpack.packb({b"t": "seen"}),
}


@pytest.mark.long
@in_loop
async def test_a_message_that_is_not_understood_closes_only_its_own_socket() -> None:
    async with page_of(TANK) as page:
        other = await page.socket()
        await other.until("hello")
        for what, data in MALFORMED.items():
            socket = await page.socket()
            await socket.until("hello")
            await socket.send_bytes(data)
            with pytest.raises(ConnectionError, match="1003"):
                await socket.next()
            assert len(page.site.live.pages) == 1, what
        text = await page.socket()
        await text.send_text('{"t": "want"}')
        with pytest.raises(ConnectionError, match="1003"):
            await text.until("never")
        await other.send({"t": "want", "topic": "rig", "wish": True})
        assert (await other.until("rig"))["state"] == "paused"


@pytest.mark.long
@in_loop
async def test_there_is_a_limit_of_sockets() -> None:
    async with page_of(TANK) as page:
        sockets = [await page.socket() for _ in range(MOST_SOCKETS)]
        with pytest.raises(ConnectionError, match="refused"):
            await page.socket()
        await sockets[0].close()
        assert (await (await page.socket()).next())["t"] == "hello"


numbers = st.integers(-(2**63), 2**64 - 1)
values = st.recursive(
    st.none() | st.booleans() | numbers | st.floats() | st.text() | st.binary(),
    lambda inner: st.lists(inner) | st.dictionaries(st.text() | numbers | st.binary(), inner),
    max_leaves=10,
)
messages = st.builds(lambda value: bytes(msgpack.packb(value)), values)


@st.composite
def mutated(draw: st.DrawFn) -> bytes:
    """A right message with some bytes changed, or cut off."""
    wish = draw(values)
    data = bytearray(msgpack.packb({"t": draw(st.sampled_from(["want", "seen"])), "topic": "numbers", "wish": wish}))
    for _ in range(draw(st.integers(0, 4))):
        data[draw(st.integers(0, len(data) - 1))] = draw(st.integers(0, 255))
    return bytes(data[: draw(st.integers(0, len(data)))])


@given(st.binary() | messages | mutated())
def test_no_bytes_of_a_page_raise_anything_else(data: bytes) -> None:
    live, page = Live([Numbers()], {}), Page("operate")
    try:
        live.take(page, data)
    except MalformedError:
        pass
    else:
        assert page.wishes in ({}, {"numbers": "all"})


def test_a_message_that_is_too_long_is_refused() -> None:
    with pytest.raises(MalformedError, match="expected at most 65536"):
        taken(bytes(LONGEST + 1))
