"""The topic `values`: what a page has on its screen, polled by one reader for all pages."""

from pathlib import Path

import pytest
from in_loop import in_loop
from page_bench import page_of

LAB = Path(__file__).parents[2] / "configs" / "lab.yaml"
WISH = {"t": "want", "topic": "values", "wish": {"points": ["tank/level", "io/6200:01", "drive/speed_set"]}}

pytestmark = pytest.mark.long


@in_loop
async def test_a_page_gets_the_values_of_its_screen_and_then_what_changes() -> None:
    async with page_of(LAB) as page:
        socket = await page.socket()
        await socket.send(WISH)
        seen: dict[str, object] = {}
        while len(seen) < 3:
            seen |= (await socket.until("values"))["values"]
        assert seen == {"tank/level": 0.5, "io/6200:01": 0, "drive/speed_set": 0.0}
        await page.call("PUT", "devices/io/points/6200:01", {"value": 5})
        assert (await socket.until("values"))["values"] == {"io/6200:01": 5}
        await socket.close()


@in_loop
async def test_a_point_that_is_not_there_says_so_beside_those_that_are() -> None:
    async with page_of(LAB) as page:
        socket = await page.socket()
        wish = {"points": ["tank/level", "tank/bubbles", "tank/volume"]}
        await socket.send({"t": "want", "topic": "values", "wish": wish})
        frame = await socket.until("values")
        assert set(frame["values"]) == {"tank/level", "tank/volume"}
        assert frame["troubles"] == {"tank/bubbles": "tank has no value 'bubbles'"}
        await socket.close()


@in_loop
async def test_five_pages_ask_a_device_no_more_than_one() -> None:
    async with page_of(LAB) as page:
        asked: list[str] = []
        ask = page.site.link.ask

        async def counted(path: str, message: object = None, timeout_s: float = 5.0) -> object:
            asked.append(path)
            return await ask(path, message, timeout_s)

        page.site.link.ask = counted  # type: ignore[method-assign]
        sockets = [await page.socket() for _ in range(5)]
        for socket in sockets:
            await socket.send({"t": "want", "topic": "values", "wish": {"points": ["tank/level"]}})
        for socket in sockets:
            assert (await socket.until("values"))["values"] == {"tank/level": 0.5}
        assert asked.count("device/tank/get") <= 2
        for socket in sockets:
            await socket.close()


@pytest.mark.parametrize(
    "wish",
    [True, {"points": "tank/level"}, {"points": ["tank"]}, {"points": ["moon/x"]}, {"points": ["tank/x"] * 1001}],
)
@in_loop
async def test_a_wish_that_is_not_understood_closes_only_its_socket(wish: object) -> None:
    async with page_of(LAB) as page:
        other, socket = await page.socket(), await page.socket()
        await socket.send({"t": "want", "topic": "values", "wish": wish})
        with pytest.raises(ConnectionError, match="1003"):
            await socket.until("values")
        await other.send(WISH)
        assert (await other.until("values"))["values"]
        await other.close()
