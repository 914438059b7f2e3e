"""Fronts by HTTP and by the socket: values while a page looks, keys that are pressed and held, and never stick."""

import asyncio
import json
from pathlib import Path
from typing import Any

import pytest
from in_loop import in_loop
from page_bench import PageBench, Socket, page_of

from fieldrig.config.rig_file import from_dict
from fieldrig_page.fronts import HELD_FILE

pytestmark = pytest.mark.long

IO32 = Path(__file__).parents[2] / "configs" / "eds" / "io32.eds"
RIG: dict[str, Any] = {
    "time": "virtual",
    "buses": {"can": {"kind": "can.virtual", "bitrate": 500_000}, "wires": {"kind": "wires.virtual"}},
    "devices": {
        "card": {
            "kind": "arp", "terminal": True, "parameters": {"general": {8: 20}},
            "links": {"can": "can", "wires": "wires"},
        },
        "panel": {"kind": "terminal.tr", "model": "TR4", "node_id": 20, "links": {"can": "can"}},
        "io": {"kind": "canopen.node", "node_id": 5, "eds": str(IO32), "links": {"can": "can"}},
        "tank": {
            "kind": "plant.tank", "area_m2": 0.25, "height_m": 2.0, "outlet_area_m2": 0.0002,
            "pump_flow_m3_per_s": 0.001, "links": {"wires": "wires"},
        },
    },
}  # fmt: skip


def rig_in(folder: Path) -> dict[str, Any]:
    return {**RIG, "run": str(folder)}


async def looking_at(page: PageBench, device: str) -> tuple[Socket, str]:
    """Return a socket that looks at a front and has all of it, and how the topic names the page."""
    socket, name, _ = await first_look(page, device)
    return socket, name


async def first_look(page: PageBench, device: str) -> tuple[Socket, str, dict[str, Any]]:
    socket = await page.socket()
    await socket.send({"t": "want", "topic": "front", "wish": {"devices": [device]}})
    frame = await socket.until("front")
    name = frame["page"]
    while device not in frame["devices"]:
        frame = await socket.until("front")
    return socket, name, frame["devices"][device]


async def value_of(page: PageBench, device: str, point: str) -> Any:
    return (await page.ask(f"device/{device}/get", {"keys": [point]}))[point]


async def until(page: PageBench, device: str, point: str, value: Any) -> None:
    while await value_of(page, device, point) != value:
        await asyncio.sleep(0)


@in_loop
async def test_a_front_is_answered_with_the_kind_of_its_device(tmp_path: Path) -> None:
    async with page_of(rig_in(tmp_path)) as page:
        front = (await page.get("devices/panel/front")).json
        assert (front["plate"]["kind"], front["plate"]["model"]) == ("terminal.tr", "TR4")
        assert (await page.get("devices/pannel/front")).status == 404


@in_loop
async def test_a_page_gets_all_values_of_a_front_and_then_what_changes(tmp_path: Path) -> None:
    async with page_of(rig_in(tmp_path)) as page:
        socket, _, whole = await first_look(page, "tank")
        assert whole["values"]["level"] == 0
        assert (await page.call("POST", "devices/tank/front/level", {"value": 1.5})).status == 200
        changed = await socket.until(
            "front", lambda frame: "level" in frame["devices"].get("tank", {}).get("values", {})
        )
        assert changed["devices"]["tank"]["values"]["level"] == 1.5
        assert "overflows" not in changed["devices"]["tank"]["values"]


@in_loop
async def test_a_device_without_power_says_why_it_has_no_values(tmp_path: Path) -> None:
    async with page_of(rig_in(tmp_path)) as page:
        socket, _ = await looking_at(page, "tank")
        added = await page.ask("device/tank/add_fault", {"fault": {"what": "power_off"}})
        dark = await socket.until("front", lambda frame: frame["devices"].get("tank", {}).get("why", "") != "")
        assert dark["devices"]["tank"] == {"values": {}, "why": "tank is switched off", "whole": True}
        await page.ask("device/tank/clear_fault", added)
        lit = await socket.until("front", lambda frame: frame["devices"].get("tank", {}).get("why") == "")
        assert lit["devices"]["tank"]["values"]["level"] == 0


@in_loop
async def test_a_key_goes_down_and_up(tmp_path: Path) -> None:
    async with page_of(rig_in(tmp_path)) as page:
        _, name = await looking_at(page, "panel")
        assert (await page.call("POST", "devices/panel/front/key.F1", {"value": True, "page": name})).status == 200
        assert await value_of(page, "panel", "key.F1") is True
        assert (await page.call("POST", "devices/panel/front/key.F1", {"value": False, "page": name})).status == 200
        assert await value_of(page, "panel", "key.F1") is False


@in_loop
async def test_a_held_key_goes_up_when_the_socket_drops(tmp_path: Path) -> None:
    async with page_of(rig_in(tmp_path)) as page:
        socket, name = await looking_at(page, "panel")
        await page.call("POST", "devices/panel/front/key.F1", {"value": True, "page": name})
        await page.call("POST", "devices/panel/front/key.CR", {"value": True, "page": name})
        await socket.close()
        await until(page, "panel", "key.F1", False)
        await until(page, "panel", "key.CR", False)


@in_loop
async def test_a_key_that_is_pressed_while_the_socket_drops_goes_up(tmp_path: Path) -> None:
    async with page_of(rig_in(tmp_path)) as page:
        socket, name = await looking_at(page, "panel")
        press = page.call("POST", "devices/panel/front/key.F1", {"value": True, "page": name})
        pressing, _ = await asyncio.gather(press, socket.close())
        await until(page, "panel", "key.F1", False)
        assert pressing.status in (200, 409)
        late = await page.call("POST", "devices/panel/front/key.F1", {"value": True, "page": name})
        assert (late.status, late.json["what"]) == (409, "the socket of this page has gone")
        assert await value_of(page, "panel", "key.F1") is False


@in_loop
async def test_a_key_that_two_pages_hold_goes_up_with_the_last(tmp_path: Path) -> None:
    async with page_of(rig_in(tmp_path)) as page:
        first, one = await looking_at(page, "panel")
        _, other = await looking_at(page, "panel")
        for name in (one, other):
            await page.call("POST", "devices/panel/front/key.F1", {"value": True, "page": name})
        await first.close()
        await asyncio.sleep(0)
        assert await value_of(page, "panel", "key.F1") is True
        await page.call("POST", "devices/panel/front/key.F1", {"value": False, "page": other})
        assert await value_of(page, "panel", "key.F1") is False


@in_loop
async def test_a_key_that_a_killed_process_left_held_goes_up_at_the_next_start(tmp_path: Path) -> None:
    rig = rig_in(tmp_path)
    (tmp_path / HELD_FILE).write_text(json.dumps([["panel", "key.F1", False], ["gone", "key", False], 5, ["panel"]]))
    assert from_dict(rig).run == tmp_path
    async with page_of(
        rig,
    ) as page:
        await page.ask("device/panel/set", {"values": {"key.F1": True}})
        await until(page, "panel", "key.F1", False)


@in_loop
async def test_what_is_held_is_written_down_until_it_is_released(tmp_path: Path) -> None:
    async with page_of(rig_in(tmp_path)) as page:
        _, name = await looking_at(page, "panel")
        await page.call("POST", "devices/panel/front/key.F1", {"value": True, "page": name})
        assert json.loads((tmp_path / HELD_FILE).read_text()) == [["panel", "key.F1", False]]
        await page.call("POST", "devices/panel/front/key.F1", {"value": False, "page": name})
        assert json.loads((tmp_path / HELD_FILE).read_text()) == []


@in_loop
async def test_a_bit_of_an_input_is_set_beside_the_others(tmp_path: Path) -> None:
    async with page_of(rig_in(tmp_path)) as page:
        for bit in (0, 3):
            assert (await page.call("POST", f"devices/io/front/6000:01.{bit}", {"value": True})).status == 200
        await page.call("POST", "devices/io/front/6000:01.0", {"value": False})
        assert await value_of(page, "io", "6000:01") == 0b1000


@pytest.mark.parametrize(
    ("path", "body", "status", "what"),
    [
        ("card/front/run", {"value": True}, 409, "run is not possible in state init"),
        ("tank/front/level", {"value": 5}, 409, "expected a number from 0 to 2 m"),
        ("tank/front/inflow", {"value": 5}, 409, "inflow of tank only shows something"),
        ("tank/front/levle", {"value": 5}, 404, "the front of tank has no part 'levle'"),
        ("panel/front/key.F1", {"value": 1}, 422, "key.F1 is a key: expected true or false"),
        ("panel/front/key.F1", {"value": [1]}, 422, "the body is not as expected"),
    ],
)
@in_loop
async def test_refusals_say_what_was_expected(tmp_path: Path, path: str, body: Any, status: int, what: str) -> None:
    async with page_of(rig_in(tmp_path)) as page:
        answer = await page.call("POST", f"devices/{path}", body)
        assert (answer.status, what in answer.json["what"]) == (status, True), answer.json


@in_loop
async def test_a_page_that_only_looks_presses_nothing(tmp_path: Path) -> None:
    async with page_of(rig_in(tmp_path)) as page:
        answer = await page.call("POST", "devices/panel/front/key.F1", {"value": True}, "look")
        assert answer.status == 403
        assert await value_of(page, "panel", "key.F1") is False


@pytest.mark.parametrize("wish", [5, {}, {"devices": "panel"}, {"devices": ["pannel"]}, {"devices": ["panel"] * 65}])
@in_loop
async def test_a_wish_that_is_not_understood_closes_its_socket_only(tmp_path: Path, wish: Any) -> None:
    async with page_of(rig_in(tmp_path)) as page:
        other, _ = await looking_at(page, "panel")
        socket = await page.socket()
        await socket.send({"t": "want", "topic": "front", "wish": wish})
        with pytest.raises(ConnectionError, match="1003"):
            await socket.until("front")
        await page.call("POST", "devices/panel/front/key.F1", {"value": True})
        await other.until(
            "front", lambda frame: frame["devices"].get("panel", {}).get("values", {}).get("key.F1") is True
        )
