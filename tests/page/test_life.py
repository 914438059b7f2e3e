"""The topic `life` and the picture's part of the API, on a rig in virtual time."""

from pathlib import Path
from typing import Any

import pytest
from in_loop import in_loop
from page_bench import Socket, page_of

from fieldrig.control.messages import NoAnswerError

CONFIGS = Path(__file__).parents[2] / "configs"
LAB = CONFIGS / "lab.yaml"
RING: dict[str, Any] = {
    "time": "virtual",
    "buses": {"ring": {"kind": "ring.virtual"}},
    "devices": {
        name: {"kind": "mc4", "ring_address": address, "links": {"ring": "ring"}}
        for address, name in enumerate(("first", "second"), 1)
    },
}
"""A ring whose master is not there yet."""

pytestmark = pytest.mark.long


async def until(socket: Socket, holds: Any) -> dict[str, Any]:
    """Merge frames of `life` as the page does until it holds, and return what is known then."""
    known: dict[str, Any] = {"parts": {}, "values": {}, "samples": [], "events": []}
    while not holds(known):
        frame = await socket.until("life")
        if frame["whole"]:
            known = {"parts": {}, "values": {}, "samples": [], "events": []}
        for key in ("parts", "values"):
            known[key] |= frame.get(key, {})
        for key in ("samples", "events"):
            known[key] += frame.get(key, [])
    return known


@in_loop
async def test_life_has_every_part_with_its_state_and_two_values() -> None:
    async with page_of(LAB) as page:
        socket = await page.socket("look")
        await socket.send({"t": "want", "topic": "life", "wish": True})
        known = await until(socket, lambda known: known["samples"])
        assert set(known["parts"]) == {"tank", "io", "sensor", "drive", "can0", "mb_tcp", "mb_rtu", "wires"}
        assert {part["word"] for part in known["parts"].values()} == {"ready"}
        assert [point["key"] for point in known["values"]["tank"]] == ["level", "volume"]
        assert known["samples"][0]["tank"] == [0.5, 0.125]
        await socket.close()


@in_loop
async def test_a_part_whose_process_does_not_answer_says_so_until_it_does() -> None:
    async with page_of(LAB) as page:
        link, is_stopped = page.site.link, True
        ask, ask_all = link.ask, link.ask_all

        async def to_no_tank(path: str, message: Any = None, timeout_s: float = 5.0) -> Any:
            if is_stopped and path.startswith("device/tank/"):
                raise NoAnswerError("tank does not answer")
            return await ask(path, message, timeout_s)

        async def of_no_can(path: str, timeout_s: float = 5.0) -> dict[str, Any]:
            found = await ask_all(path, timeout_s)
            return {name: answer for name, answer in found.items() if not is_stopped or name not in ("tank", "can0")}

        socket = await page.socket("look")
        await socket.send({"t": "want", "topic": "life", "wish": True})
        await until(socket, lambda known: known["samples"])
        link.ask, link.ask_all = to_no_tank, of_no_can  # type: ignore[method-assign]

        def words(known: dict[str, Any]) -> set[str]:
            return {known["parts"].get(name, {}).get("word") for name in ("tank", "can0")}

        known = await until(socket, lambda known: words(known) == {"no answer"})
        assert known["parts"]["tank"]["level"] == "down"
        assert "its process runs" in known["parts"]["can0"]["why"][0]
        is_stopped = False
        await until(socket, lambda known: words(known) == {"ready"})
        await socket.close()


@in_loop
async def test_a_fault_is_seen_while_it_lasts_with_its_event() -> None:
    async with page_of(LAB) as page:
        socket = await page.socket("look")
        await socket.send({"t": "want", "topic": "life", "wish": True})
        number = (await page.ask("device/tank/add_fault", {"fault": {"what": "power_off"}}))["number"]
        known = await until(socket, lambda known: known["parts"].get("tank", {}).get("word") == "power off")
        assert known["parts"]["tank"]["off"] == number
        await page.ask("device/tank/clear_fault", {"number": number})
        known = await until(socket, lambda known: known["parts"].get("tank", {}).get("word") == "ready")
        assert "off" not in known["parts"]["tank"]
        await socket.close()


@in_loop
async def test_a_page_that_comes_later_gets_the_whole() -> None:
    async with page_of(LAB) as page:
        first, second = await page.socket("look"), await page.socket("look")
        await first.send({"t": "want", "topic": "life", "wish": True})
        await until(first, lambda known: known["samples"])
        await second.send({"t": "want", "topic": "life", "wish": True})
        known = await until(second, lambda known: known["parts"])
        assert len(known["parts"]) == 8
        assert known["samples"][0].keys() == {"tank", "io", "sensor", "drive"}
        for socket in (first, second):
            await socket.close()


@in_loop
async def test_a_cut_of_a_ring_is_known_by_its_station() -> None:
    async with page_of(RING) as page:
        socket = await page.socket("look")
        await socket.send({"t": "want", "topic": "life", "wish": True})
        number = (await page.ask("bus/ring/add_fault", {"fault": {"what": "break", "after": "first"}}))["number"]
        known = await until(socket, lambda known: known["parts"].get("ring", {}).get("cuts"))
        assert known["parts"]["ring"]["cuts"] == {"first": number}
        assert (known["parts"]["ring"]["level"], known["parts"]["ring"]["word"]) == ("fault", "break")
        await page.ask("bus/ring/clear_fault", {"number": number})
        await until(socket, lambda known: known["parts"].get("ring", {}).get("word") == "ready")
        await socket.close()


@in_loop
async def test_the_picture_as_data() -> None:
    async with page_of(LAB) as page:
        rig = (await page.get("rig")).json
        assert rig["devices"]["tank"]["kind"] == "plant.tank"
        assert rig["buses"]["can0"]["members"] == ["io", "sensor"]
        assert rig["partners"]["sensor"] == ["io", "tank"]
        places = (await page.get("rig/layout?width=1200")).json
        assert places["columns"] == 4
        assert places["cards"].keys() == rig["devices"].keys()
        assert (await page.get("rig/layout?width=0")).status == 422
        assert (await page.get("rig/layout?width=wide")).status == 422


@in_loop
async def test_the_wires_of_a_device_have_values_and_units() -> None:
    async with page_of(LAB) as page:
        socket = await page.socket("look")
        await socket.send({"t": "want", "topic": "wires", "wish": "io"})
        whole = await socket.until("wires")
        assert whole["whole"]
        assert whole["values"]["wires/tank.level"] == [0.5, "m"]
        assert whole["values"].keys() == {"wires/tank.level", "wires/tank.high", "wires/tank.low", "wires/tank.outlet"}
        await page.call("PUT", "devices/tank/points/level", {"value": 1.5})
        await page.call("POST", "rig/step", {"for": "1 s"})
        frame = await socket.until("wires", lambda frame: "wires/tank.level" in frame["values"])
        assert frame["values"]["wires/tank.level"] == [1.5, "m"]
        await socket.close()


@in_loop
async def test_wires_of_a_device_that_is_not_there_close_the_socket() -> None:
    async with page_of(LAB) as page:
        for wish in ("tnk", 5, ["tank"]):
            socket = await page.socket("look")
            await socket.send({"t": "want", "topic": "wires", "wish": wish})
            with pytest.raises(ConnectionError, match="1003"):
                await socket.until("wires")


@in_loop
async def test_a_device_that_falls_silent_with_a_fault_leaves_the_others_as_they_are() -> None:
    async with page_of(LAB) as page:
        socket = await page.socket("look")
        await socket.send({"t": "want", "topic": "life", "wish": True})
        await page.ask("device/tank/add_fault", {"fault": {"what": "leak"}})
        await until(socket, lambda known: known["parts"].get("tank", {}).get("word") == "leak")
        page.control.silence("device/tank/*")
        known = await until(socket, lambda known: known["parts"].get("tank", {}).get("word") == "ready")
        assert {part["word"] for part in known["parts"].values()} == {"ready"}
        await socket.close()
