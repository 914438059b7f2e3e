"""The scope of a rig that runs: topic, HTTP API, set-ups and exports, without a browser."""

import csv
import os
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from io import StringIO
from math import inf
from pathlib import Path
from struct import unpack
from typing import Any

import pytest
from in_loop import in_loop
from page_bench import PageBench, Socket, page_of

from fieldrig.clock import MS, S

RIG = {"name": "pulses", "time": "virtual", "devices": {"source": {"kind": "pulse_source:PulseSource"}}}
PULSE = {"kind": "edge", "signal": "source/pulse", "level": 0.5, "what": "rising"}
SHOT = {"signals": ["source/pulse", "source/level"], "window_ns": 400 * MS, "mode": "single", "trigger": PULSE}


@asynccontextmanager
async def pulses(run: Path) -> AsyncIterator[PageBench]:
    async with page_of({**RIG, "run": str(run)}) as page:
        yield page


async def looked(page: PageBench, setup: dict[str, Any], **wish: Any) -> Socket:
    socket = await page.socket()
    await want(socket, setup, **wish)
    await socket.until("scope", lambda frame: all(column["kind"] for column in frame.get("columns", [{"kind": ""}])))
    return socket


async def want(socket: Socket, setup: dict[str, Any], **wish: Any) -> None:
    await socket.send({"t": "want", "topic": "scope", "wish": {"setup": setup, "pixels": 400, **wish}})


@pytest.mark.long
@in_loop
async def test_a_pulse_of_1_ms_is_caught_an_hour_into_a_run_with_what_was_before(tmp_path: Path) -> None:
    async with pulses(tmp_path) as page:
        await page.ask("rig/step", {"ns": 3600 * S + 30 * S})
        socket = await page.socket()
        await want(socket, SHOT)
        await socket.until("scope", lambda frame: frame["status"]["state"] == "armed")
        await page.ask("rig/step", {"ns": 31 * S})
        frame = await socket.until("scope", lambda frame: frame["status"]["state"] == "caught" and "parts" in frame)
        capture = frame["status"]["capture"]
        assert capture["trigger_ns"] == capture["after_ns"] == 3660 * S
        assert (capture["first_ns"], capture["end_ns"], capture["lost"]) == (3659_800 * MS, 3660_200 * MS, 0)
        found = page.site.topics[-1].captures[capture["number"]].traces["source/pulse"]  # type: ignore[attr-defined]
        inside = found.track.values[found.column][found.track.position(capture["first_ns"]) :]
        assert list(inside).count(1.0) == 1
        assert inside.index(1.0) == 200
        (part,) = frame["parts"]
        high = unpack(f"{part['n']}d", part["high"][: 8 * part["n"]])
        assert [place for place, value in enumerate(high) if value == 1.0] == [200]


@pytest.mark.long
@in_loop
async def test_each_pulse_of_an_hour_triggers_when_changes_are_recorded(tmp_path: Path) -> None:
    async with pulses(tmp_path) as page:
        setup = {**SHOT, "signals": ["source/pulse", "source/state"], "mode": "normal", "rhythm": "change"}
        socket = await looked(page, setup)
        await page.ask("rig/step", {"ns": 3601 * S})
        frame = await socket.until("scope", lambda frame: frame["status"]["hits"] == 60)
        assert frame["status"]["lost"] == [0, 0]


@in_loop
async def test_two_pages_have_each_its_own_setup(tmp_path: Path) -> None:
    async with pulses(tmp_path) as page:
        one = await looked(page, {"signals": ["source/ramp"], "window_ns": S})
        other = await looked(page, {"signals": ["source/level", "source/ramp"], "window_ns": 100 * MS})
        await page.ask("rig/step", {"ns": 2 * S})
        frame = await one.until("scope", lambda frame: frame.get("first", -inf) + frame.get("count", 0) > 700)
        assert frame["bucket_ns"] == S // 400
        frame = await other.until("scope", lambda frame: len(frame.get("parts", ())) > 0)
        assert frame["bucket_ns"] == 100 * MS // 400


@in_loop
async def test_set_ups_are_saved_in_the_run_folder_and_opened_again(tmp_path: Path) -> None:
    async with pulses(tmp_path) as page:
        assert (await page.call("PUT", "scope/setups/first pulse", SHOT)).status == 200
        assert (await page.get("scope/setups")).json == ["first pulse"]
        assert (await page.call("PUT", "scope/setups/x", SHOT, role="look")).status == 403
        for name in ("a/b", "../../x", ".x", "x" * 65):
            refusal = await page.call("PUT", f"scope/setups/{name}", SHOT)
            assert (refusal.status, "is no name for a set-up" in refusal.json["what"]) == (409, True)
        away = {**SHOT, "signals": ["source/pulze", "xx/y"]}
        assert (await page.call("PUT", "scope/setups/away", away)).status == 200
    async with pulses(tmp_path) as page:
        opened = (await page.get("scope/setups/first pulse")).json
        assert opened["setup"]["trigger"]["signal"] == "source/pulse"
        assert opened["missing"] == []
        missing = (await page.get("scope/setups/away")).json["missing"]
        assert [signal["name"] for signal in missing] == ["source/pulze", "xx/y"]
        assert missing[0]["remedy"] == "did you mean source/pulse?"
        refusal = await page.get("scope/setups/first pulze")
        assert (refusal.status, refusal.json["remedy"]) == (409, "did you mean first pulse?")
        assert (await page.call("DELETE", "scope/setups/away")).status == 200
        assert (await page.get("scope/setups")).json == ["first pulse"]


@in_loop
async def test_a_set_up_is_written_through_no_link_and_its_name_may_have_letters_of_any_language(
    tmp_path: Path,
) -> None:
    async with pulses(tmp_path / "run") as page:
        name = "scope/setups/F\u00fcllstand"
        assert (await page.call("PUT", name, SHOT)).status == 200
        assert (await page.get("scope/setups")).json == ["F\u00fcllstand"]
        file, elsewhere = tmp_path / "run/scope/F\u00fcllstand.json", tmp_path / "elsewhere"
        assert file.stat().st_mode & 0o777 == 0o600
        for link in (file, file.with_name(f".{file.name}.{os.getpid()}")):
            link.unlink(missing_ok=True)
            link.symlink_to(elsewhere)
        assert (await page.call("PUT", name, {**SHOT, "window_ns": 300 * MS})).status == 200
        assert (await page.get(name)).json["setup"]["window_ns"] == 300 * MS
        assert not file.is_symlink()
        assert not elsewhere.exists()


@pytest.mark.parametrize("name", ["..%2Fx", "a%2Fb", "%00", ".hidden", "x" * 65, " x"])
def test_a_name_that_is_none_is_refused(name: str, tmp_path: Path) -> None:
    @in_loop
    async def refused() -> None:
        async with pulses(tmp_path) as page:
            assert (await page.call("PUT", f"scope/setups/{name}", SHOT)).status in (404, 409)

    refused()
    assert not list(tmp_path.rglob("*.json"))


@pytest.mark.long
@in_loop
async def test_a_capture_is_made_by_the_http_api_and_exported(tmp_path: Path) -> None:
    async with pulses(tmp_path) as page:
        await page.ask("rig/run", {"speed": 1000.0})
        shot = {**SHOT, "signals": ["source/pulse", "source/state", "source/level"]}
        capture = (await page.call("POST", "scope/captures", {"setup": shot, "timeout_s": 60})).json
        assert capture["trigger_ns"] % (60 * S) == 0
        assert capture["signals"] == shot["signals"]
        answer = await page.get(f"scope/captures/{capture['number']}/csv")
        assert 'filename="pulses-capture-1.csv"' in answer.headers["content-disposition"]
        head, *lines = csv.reader(StringIO(answer.body.decode()))
        assert head == ["time_s", "source/pulse", "source/state", "source/level [m]"]
        high = [line for line in lines if line[1] == "1"]
        assert [line[:3] for line in high] == [["0.200000000", "1", "high"]]
        assert len(lines) == 401
        dump = (await page.get(f"scope/captures/{capture['number']}/vcd")).body.decode()
        assert "$var wire 1" in dump
        assert "\n#200000000\n" in dump
        assert (await page.get("scope/captures/99/csv")).status == 409
        assert (await page.get(f"scope/captures/{capture['number']}/exe")).status == 422


@in_loop
async def test_a_trigger_that_never_comes_is_said(tmp_path: Path) -> None:
    async with pulses(tmp_path) as page:
        answer = await page.call("POST", "scope/captures", {"setup": SHOT, "timeout_s": 0.1})
        assert (answer.status, answer.json["what"]) == (409, "nothing has triggered within 0.1 s")
        wrong = {**SHOT, "trigger": {**PULSE, "signal": "source/pulze"}}
        answer = await page.call("POST", "scope/captures", {"setup": wrong})
        assert answer.status == 409
        assert answer.json["remedy"] == "did you mean pulse?"


@in_loop
@pytest.mark.parametrize(
    ("setup", "what"),
    [
        ({**SHOT, "trigger": {"kind": "message", "part": "can7"}}, "the rig has no 'can7' to wait for"),
        ({**SHOT, "trigger": {"kind": "message"}}, "the rig has no '' to wait for"),
        ({**SHOT, "trigger": {"kind": "fault", "part": "sourze"}}, "the rig has no 'sourze' to wait for"),
        ({"signals": [], "mode": "run"}, "there is nothing to record"),
    ],
)
async def test_a_capture_that_can_never_come_is_refused_at_once(
    setup: dict[str, Any], what: str, tmp_path: Path
) -> None:
    async with pulses(tmp_path) as page:
        answer = await page.call("POST", "scope/captures", {"setup": setup, "timeout_s": 600})
        assert (answer.status, answer.json["what"]) == (409, what)


@in_loop
async def test_signals_are_found_by_words_of_their_names_and_descriptions(tmp_path: Path) -> None:
    async with pulses(tmp_path) as page:
        found = (await page.get("scope/signals?search=source%20long")).json
        assert [signal["name"] for signal in found] == ["source/pulse"]


@in_loop
async def test_a_fault_triggers(tmp_path: Path) -> None:
    async with pulses(tmp_path) as page:
        setup = {**SHOT, "trigger": {"kind": "fault", "part": "source"}}
        socket = await looked(page, setup)
        await page.ask("rig/step", {"ns": S})
        await page.ask("device/source/add_fault", {"fault": {"what": "power_off"}})
        frame = await socket.until("scope", lambda frame: bool(frame.get("events")))
        assert [(event["sort"], event["part"], event["text"]) for event in frame["events"]] == [
            ("fault", "source", "power_off")
        ]
        await page.ask("rig/step", {"ns": S})
        frame = await socket.until("scope", lambda frame: frame.get("status", {}).get("state") == "caught")
        assert frame["status"]["capture"]["after_ns"] == frame["status"]["capture"]["trigger_ns"] == S


@in_loop
async def test_a_message_triggers_by_the_words_that_the_list_of_messages_has() -> None:
    async with page_of("configs/lab.yaml") as page:
        setup = {"signals": ["tank/level"], "window_ns": 10 * MS, "mode": "single"}
        socket = await looked(
            page, {**setup, "trigger": {"kind": "message", "part": "can0", "words": "Heartbeat SENSOR"}}
        )
        await page.ask("rig/step", {"ns": 3 * S})
        frame = await socket.until("scope", lambda frame: frame.get("status", {}).get("state") == "caught")
        assert frame["status"]["messages_lost"] == 0


@in_loop
async def test_a_message_on_a_bus_triggers_at_its_instant(tmp_path: Path) -> None:
    hot = {"power_w": 100, "heat_capacity_j_per_k": 100, "resistance_k_per_w": 1, "initial_degc": 90}
    devices = {"boiler": {"kind": "plant.heater", **hot, "links": {"wires": "wires"}}}
    rig = {"name": "boiler", "time": "virtual", "run": str(tmp_path), "devices": devices}
    async with page_of({**rig, "buses": {"wires": {"kind": "wires.virtual"}}}) as page:
        await page.ask("rig/step", {"ns": MS})
        found = [signal["name"] for signal in (await page.get("scope/signals?search=temperature")).json]
        assert "wires/boiler.temperature" in found
        setup = {"signals": ["wires/boiler.temperature"], "window_ns": 10 * MS, "mode": "single"}
        socket = await looked(page, {**setup, "trigger": {"kind": "message", "part": "wires", "words": "boiler"}})
        await page.ask("rig/step", {"ns": 3 * S})
        frame = await socket.until("scope", lambda frame: frame.get("status", {}).get("state") == "caught")
        assert frame["status"]["capture"]["trigger_ns"] == frame["status"]["capture"]["after_ns"]
        assert frame["status"]["messages_lost"] == 0
