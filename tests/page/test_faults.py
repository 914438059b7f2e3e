"""Faults by the page: forms from schemas, what is active, what it did, and the time line."""

import asyncio
from pathlib import Path
from typing import Any, cast

import pytest
from in_loop import in_loop
from page_bench import page_of
from patience import PATIENCE_S

from fieldrig.config.rig_file import from_dict
from fieldrig.control.messages import Control
from fieldrig_page.faults import Faults
from fieldrig_page.rig_link import RigLink

LAB = Path(__file__).parents[2] / "configs" / "lab.yaml"
BELT = {
    "name": "belt",
    "time": "virtual",
    "buses": {"can0": {"kind": "can.virtual"}},
    "devices": {"belt": {"kind": "cia402.drive", "node_id": 8, "links": {"can": "can0"}}},
}

pytestmark = pytest.mark.long


@in_loop
async def test_every_part_says_what_it_can_suffer() -> None:
    async with page_of(LAB) as page:
        kinds = (await page.get("faults/kinds")).json
        assert set(kinds["parts"]) == {"can0", "mb_tcp", "mb_rtu", "wires", "tank", "io", "sensor", "drive"}
        assert kinds["parts"]["can0"]["members"] == ["io", "sensor"]
        drop = kinds["kinds"][kinds["parts"]["can0"]["kind"]]["drop"]
        assert list(drop["properties"])[-3:] == ["start_ms", "duration_ms", "when"]
        assert "what" not in drop["properties"]
        assert drop["properties"]["probability"]["maximum"] == 1
        assert "power_off" in kinds["kinds"]["plant.tank"]


@in_loop
async def test_a_fault_is_added_counted_and_cleared() -> None:
    async with page_of(BELT) as page:
        await page.call("POST", "rig/step", {"for": "1 s"})
        added = await page.call("POST", "faults", {"part": "can0", "what": "drop", "identifier": "0x708", "count": "1"})
        assert (added.status, added.json) == (200, {"number": 1})
        (fault,) = (await page.get("faults")).json
        assert fault == {
            "part": "can0", "number": 1, "what": "drop", "identifier": 0x708, "count": 1, "state": "on", "applied": 0,
        }  # fmt: skip
        cleared = await page.call("DELETE", "faults/can0/1")
        assert cleared.json == {"cleared": [1]}
        assert (await page.get("faults")).json == []


@pytest.mark.parametrize(
    ("fault", "what"),
    [
        ({"part": "can0", "what": "explode"}, "there is no fault 'explode'"),
        ({"part": "can0", "what": "drop", "node": "wagon"}, "node: there is no device 'wagon'"),
        ({"part": "can0", "what": "drop", "probability": "2"}, "probability"),
        ({"part": "moon", "what": "drop"}, "belt has no bus or device 'moon'"),
        ({"part": "belt", "what": "power_off", "duration_ms": "soon"}, "duration_ms"),
    ],
)
@in_loop
async def test_a_wrong_fault_is_refused_with_its_reason(fault: dict[str, str], what: str) -> None:
    async with page_of(BELT) as page:
        refused = await page.call("POST", "faults", fault)
        assert refused.status == 409
        assert what in refused.json["what"]


@in_loop
async def test_who_may_only_look_adds_no_fault() -> None:
    async with page_of(BELT) as page:
        refused = await page.call("POST", "faults", {"part": "belt", "what": "power_off"}, "look")
        assert refused.status == 403


@in_loop
async def test_a_page_that_looks_sees_a_fault_begin_and_end() -> None:
    async with page_of(BELT) as page:
        socket = await page.socket()
        await socket.send({"t": "want", "topic": "faults", "wish": True})
        first = await socket.until("faults")
        assert (first["whole"], first["faults"], first["lines"]) == (True, [], [])
        await page.call("POST", "faults", {"part": "belt", "what": "power_off", "duration_ms": 100})
        frame, lines = first, list[dict[str, Any]]()
        while not (frame.get("faults") and lines):
            frame = {**frame, **await socket.until("faults")}
            lines += frame["lines"]
        assert frame["faults"][0]["state"] == "on"
        assert (lines[0]["part"], lines[0]["text"]) == ("belt", "power_off duration_ms=100")
        await page.call("POST", "rig/step", {"for": "200 ms"})
        while not any(line["is_over"] for line in lines):
            lines += (await socket.until("faults"))["lines"]
        assert {line["key"] for line in lines} == {"fault 1"}
        await socket.close()


@in_loop
async def test_a_page_that_comes_later_gets_the_lines_before() -> None:
    async with page_of(BELT) as page:
        early = await page.socket()
        await early.send({"t": "want", "topic": "faults", "wish": True})
        await page.call("POST", "faults", {"part": "belt", "what": "power_off"})
        await early.until("faults", lambda frame: bool(frame["lines"]))
        late = await page.socket()
        await late.send({"t": "want", "topic": "faults", "wish": True})
        whole = await late.until("faults")
        assert [line["text"] for line in whole["lines"]] == ["power_off"]
        assert whole["faults"][0]["what"] == "power_off"
        await early.close()
        await late.close()


@pytest.mark.parametrize("turns", range(4))
@in_loop
async def test_a_topic_that_is_cancelled_as_it_is_woken_ends(turns: int) -> None:
    async with page_of(BELT) as page:
        topic = Faults(RigLink(from_dict(BELT), cast(Control, page.control)))
        running = asyncio.get_running_loop().create_task(topic.run())
        for _ in range(10):
            await asyncio.sleep(0)
        topic._changed.set()
        for _ in range(turns):
            await asyncio.sleep(0)
        running.cancel()
        await asyncio.wait({running}, timeout=PATIENCE_S)
        assert running.cancelled()
