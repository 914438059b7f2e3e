"""The sockets of the page: topics, frames and acknowledgements."""

from pathlib import Path

import pytest
from in_loop import in_loop
from page_bench import page_of

LAB = Path(__file__).parents[2] / "configs" / "lab-virtual.yaml"

pytestmark = pytest.mark.long


@in_loop
async def test_a_socket_greets_and_shows_what_is_wanted() -> None:
    async with page_of(LAB) as page:
        socket = await page.socket("look")
        hello = await socket.until("hello")
        assert (hello["rig"], hello["role"], hello["time"]) == ("lab-virtual", "look", "virtual")
        await socket.send({"t": "want", "topic": "rig", "wish": True})
        assert (await socket.until("rig"))["state"] == "paused"
        await page.call("POST", "rig/step", {"for": "10 ms"})
        assert (await socket.until("rig", lambda rig: rig["now_ns"] > 0))["now_ns"] == 10_000_000
        await socket.close()
