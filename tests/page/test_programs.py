"""Programs by the page: source, current line, live values, task times, start, stop and force."""

from pathlib import Path

import pytest
from in_loop import in_loop
from page_bench import PageBench, page_of

CONFIGS = Path(__file__).parents[2] / "configs"
PROGRAM = """\
PROGRAM Main
VAR
    Count : INT;
    Lamp : BOOL;
END_VAR
Count := Count + 1;
Lamp := Count > 3;
END_PROGRAM
"""

pytestmark = pytest.mark.long


def rig(folder: Path) -> dict[str, object]:
    (folder / "main.st").write_text(PROGRAM)
    return {
        "name": "plc",
        "time": "virtual",
        "buses": {"can0": {"kind": "can.virtual"}},
        "devices": {
            "plc": {"kind": "hmiscu", "program": str(folder / "main.st")},
            "belt": {"kind": "cia402.drive", "node_id": 8, "links": {"can": "can0"}},
        },
    }


async def loaded(page: PageBench) -> None:
    while (await page.get("programs/plc")).json["state"] != "running":
        await page.call("POST", "rig/step", {"for": "100 ms"})


@in_loop
async def test_a_program_shows_its_source_and_its_variables(tmp_path: Path) -> None:
    async with page_of(rig(tmp_path)) as page:
        await loaded(page)
        state = (await page.get("programs/plc")).json
        (file,) = state["files"]
        assert (await page.get(f"programs/plc/source/{file}")).json["text"] == PROGRAM
        assert {value["key"] for value in (await page.get("programs/plc/values")).json} >= {
            "program:Main.Count", "program:Main.Lamp",
        }  # fmt: skip


@in_loop
async def test_a_page_sees_live_values_and_the_times_of_tasks(tmp_path: Path) -> None:
    async with page_of(rig(tmp_path)) as page:
        await loaded(page)
        socket = await page.socket()
        names = ["Main.Count", "Main.Lamp", "END_VAR"]
        await socket.send({"t": "want", "topic": "program", "wish": {"device": "plc", "names": names}})
        frame = await socket.until("program")
        assert frame["values"]["Main.Count"] > 0
        assert frame["values"]["END_VAR"] is None
        assert any(key.endswith("/cycles") for key in frame["tasks"])
        await page.call("POST", "programs/plc/force", {"values": {"Main.Count": -5}})
        forced = await socket.until("program", lambda frame: bool(frame.get("forced")))
        assert forced["forced"][0]["path"] == "Main.Count"
        await page.call("POST", "rig/step", {"for": "1 s"})
        assert (await page.ask("device/plc/debug", {"command": "read", "names": ["Main.Lamp"]}))["variables"][0][
            "value"
        ] is False
        released = await page.call("POST", "programs/plc/release", {"names": ["Main.Count"]})
        assert released.status == 200
        await socket.close()


@in_loop
async def test_a_program_is_stopped_and_started(tmp_path: Path) -> None:
    async with page_of(rig(tmp_path)) as page:
        await loaded(page)
        assert (await page.call("POST", "programs/plc/stop", {})).status == 200
        assert (await page.get("programs/plc")).json["state"] == "paused"
        await page.call("POST", "programs/plc/start", {})
        assert (await page.get("programs/plc")).json["state"] == "running"


@pytest.mark.parametrize(
    ("path", "body", "status", "what"),
    [
        ("programs/plc/force", {"values": {"Main.Nothing": 1}}, 409, "Nothing"),
        ("programs/plc/fly", {}, 409, "cannot 'fly'"),
        ("programs/belt/start", {}, 409, "cannot answer debug"),
        ("programs/moon/start", {}, 404, "no device 'moon'"),
        ("programs/plc/reset", {"kind": "hot"}, 422, "the body is not as expected"),
    ],
)
@in_loop
async def test_what_a_program_cannot_do_is_refused(
    tmp_path: Path, path: str, body: dict[str, object], status: int, what: str
) -> None:
    async with page_of(rig(tmp_path)) as page:
        await loaded(page)
        refused = await page.call("POST", path, body)
        assert refused.status == status
        assert what in refused.json["what"]
