"""The topic `traffic`: messages by name, gaps that are said, and downloads."""

import asyncio
import io
from pathlib import Path

import pytest
from in_loop import in_loop
from page_bench import PageBench, Socket, page_of

from fieldrig.config.rig_file import load
from fieldrig.traces.formats import format_of
from fieldrig.traces.names import namer_of
from fieldrig_bus.can.frame import CanFrame
from fieldrig_page.bus_record import MOST_MESSAGES, MOST_SORTS, BusRecord
from fieldrig_page.traffic import Traffic

LAB = Path(__file__).parents[2] / "configs" / "lab.yaml"


async def looking(page: PageBench, **wish: object) -> Socket:
    socket = await page.socket()
    await socket.send({"t": "want", "topic": "traffic", "wish": {"buses": ["can0"], **wish}})
    assert (await socket.until("traffic"))["whole"]
    return socket


@pytest.mark.long
@in_loop
async def test_messages_come_by_name_with_the_time_since_the_last_of_their_sort() -> None:
    async with page_of(LAB) as page:
        socket = await looking(page, kind="heartbeat", node="io")
        await page.call("POST", "rig/step", {"for": "3500 ms"})
        rows: list[list[object]] = []
        while len(rows) < 3:
            rows += (await socket.until("traffic", lambda frame: "rows" in frame))["rows"]
        assert rows[-1][2:7] == ["can0", "io", "io", "heartbeat", "pre-operational"]
        assert rows[-1][8] == 1_000_000_000  # 1017:00 of the rig file
        await socket.close()


@pytest.mark.long
@in_loop
async def test_what_was_recorded_is_read_and_downloaded() -> None:
    async with page_of(LAB) as page:
        refused = await page.get("buses/can0/messages")
        assert refused.status == 409
        socket = await looking(page)
        await page.call("POST", "rig/step", {"for": "2 s"})
        await socket.until("traffic", lambda frame: "rows" in frame)
        listed = (await page.get("buses/can0/messages?kind=boot-up")).json
        assert [message["node"] for message in listed] == ["io", "sensor"]
        log = await page.get("traces/can0.log")
        assert log.status == 200
        assert b"can0 705#00" in log.body
        assert (await page.get("traces/can0.pcapng")).body[:4] == bytes.fromhex("0a0d0d0a")
        can0 = page.site.link.config.buses["can0"].bus
        offered = (await page.get("traces/formats")).json
        assert {"ending": "vcd", "families": ["wires"]} in offered
        for ending in [form["ending"] for form in offered if form["families"] in ([], ["can"])]:
            file = (await page.get(f"traces/can0.{ending}")).body
            entries = [*format_of(Path(f"x.{ending}")).read(io.BytesIO(file))]
            assert [can0.show(can0.decode(entry.data)) for entry in entries[:2]] == ["705 [1] 00", "706 [1] 00"], ending
        assert (await page.get("traces/can0.xls")).status == 404
        assert (await page.get("traces/can9.log")).status == 404
        await socket.close()


@pytest.mark.long
@in_loop
async def test_who_looks_later_begins_with_the_last_messages_and_nothing_is_said_to_be_left_out() -> None:
    async with page_of(LAB) as page:
        first = await looking(page)
        for _ in range(30):  # 20 heartbeats each
            await page.call("POST", "rig/step", {"for": "10 s"})
        while len((await page.get("buses/can0/messages")).json) < 590:
            await asyncio.sleep(0)
        later = await page.socket()
        await later.send({"t": "want", "topic": "traffic", "wish": {"buses": ["can0"]}})
        frame = await later.until("traffic")
        assert len(frame["rows"]) == 500
        assert "gaps" not in frame
        assert frame["rows"][-1][1] > 290 * 10**9
        await first.close()
        await later.close()


@pytest.mark.long
@in_loop
async def test_what_was_configured_before_a_page_looked_has_its_names_too() -> None:
    async with page_of(LAB) as page:
        for cob_id in (0x80000195, 0x195):  # another COB-ID of TPDO 1, which is switched off for it
            await page.call("PUT", "devices/io/points/1800:01", {"value": cob_id})
        socket = await looking(page)
        (traffic,) = (topic for topic in page.site.topics if isinstance(topic, Traffic))
        name = traffic._records["can0"]._namer
        while name(CanFrame(0x195, bytes(4))).kind != "TPDO 1":
            await asyncio.sleep(0)
        assert name(CanFrame(0x185, bytes(4))).kind == ""
        await socket.close()


PAM = """
APPLICATION NAME = FILTER V1.00 ; BASIC_PAM_CYCLE = 6 ; END
NODE NOD_Left; ADDRESS = 1; TYPE = SMART_IO; END
NODE NOD_Right; ADDRESS = 2; TYPE = SMART_IO; END
BINARY_OUTPUT SBO_Left; NODE = NOD_Left; ADDRESS = 101; ACTIVE = HIGH; END
BINARY_OUTPUT SBO_Right; NODE = NOD_Right; ADDRESS = 101; ACTIVE = HIGH; END
"""
RING = """
time: virtual
buses:
  ring: {kind: pamring.virtual}
  wires: {kind: wires.virtual}
devices:
  pam: {kind: pam, application: app.pam, links: {ring: ring, wires: wires}}
  left: {kind: smart_io, ring_address: 1, links: {ring: ring, wires: wires}, terminals: {out101: left.lamp}}
  right: {kind: smart_io, ring_address: 2, links: {ring: ring, wires: wires}}
"""


@pytest.mark.long
@in_loop
async def test_a_message_of_several_nodes_is_found_by_each_of_them_and_by_each_of_its_kinds(tmp_path: Path) -> None:
    (tmp_path / "app.pam").write_text(PAM)
    (tmp_path / "rig.yaml").write_text(RING)
    async with page_of(tmp_path / "rig.yaml") as page:
        socket = await looking(page, buses=["ring", "wires"])
        await page.call("POST", "rig/step", {"for": "1 s"})
        for output in ("SBO_Left", "SBO_Right"):
            await page.call("PUT", f"devices/pam/points/{output}", {"value": True})
        await page.call("POST", "rig/step", {"for": "20 ms"})
        await socket.until("traffic", lambda frame: any(row[5] == "set output" for row in frame.get("rows", ())))
        for query in ("node=left&kind=set%20output", "node=right", "kind=output&text=sbo_right", "kind=set"):
            texts = [message["text"] for message in (await page.get(f"buses/ring/messages?{query}")).json]
            assert "left: SBO_Left level 1; right: SBO_Right level 1" in texts, query
        assert (await page.get("buses/ring/messages?node=middle")).json == []
        (lamp,) = (await page.get("buses/wires/messages?node=left&kind=digital&text=true")).json
        assert lamp["text"] == "left.lamp = True"
        await socket.close()


@pytest.mark.long
@in_loop
async def test_cycles_that_say_nothing_new_are_one_row_that_counts_on(tmp_path: Path) -> None:
    """The basic cycle of this PAM is 6 ms (`BASIC_PAM_CYCLE`), and a ring has orders and reports in each of its own."""
    (tmp_path / "app.pam").write_text(PAM)
    (tmp_path / "rig.yaml").write_text(RING)
    async with page_of(tmp_path / "rig.yaml") as page:
        socket = await looking(page, buses=["ring"], folds=True)
        await page.call("POST", "rig/step", {"for": "2 s"})
        counts: dict[int, int] = {}
        kinds: dict[int, str] = {}

        async def count() -> None:
            total = len((await page.get("buses/ring/messages")).json)
            while sum(counts.values()) < total:
                for row in (await socket.until("traffic", lambda frame: "rows" in frame))["rows"]:
                    counts[row[0]] = counts.get(row[0], 0) + row[9]
                    kinds[row[0]] = row[5]

        await count()
        before = set(counts)
        assert len(counts) < 20
        most = max(counts, key=lambda number: counts[number])
        assert (kinds[most], counts[most] > 500) == ("cycle", True)
        await page.call("PUT", "devices/pam/points/SBO_Left", {"value": True})
        await page.call("POST", "rig/step", {"for": "1 s"})
        await count()
        assert [kinds[number] for number in sorted({*counts} - before)] == ["set output"], (
            "the cycles count on in theirs"
        )
        await socket.close()


def test_a_message_that_says_the_same_as_the_last_of_its_sort_and_sender_counts_with_it(record: BusRecord) -> None:
    other = HEARTBEAT.replace("0507", "0607")
    stopped = HEARTBEAT[:-2] + "04"
    record.take(batch(0, HEARTBEAT, other, HEARTBEAT, other, stopped, stopped, HEARTBEAT))
    assert [row.first for row in record.rows(0, 9)] == [0, 1, 0, 1, 4, 4, 6]


@pytest.fixture
def record() -> BusRecord:
    config = load(LAB, ["time=virtual"])
    return BusRecord(config.buses["can0"].bus, namer_of(config, "can0"))


def batch(first: int, *data: str) -> dict[str, object]:
    entries = [[first + number, "io", text] for number, text in enumerate(data)]
    return {"family": "can", "process": "can0", "first": first, "epoch_ns": 0, "entries": entries}


HEARTBEAT = "050700000105"
"""705h with one byte, as the bus encodes it."""


def test_a_gap_in_the_batches_is_counted(record: BusRecord) -> None:
    record.take(batch(0, HEARTBEAT))
    record.take(batch(41, HEARTBEAT))
    assert (record.next, record.lost) == (2, 40)
    record.take(batch(0, HEARTBEAT))  # the process was restarted
    assert record.lost == 40


def test_memory_stays_the_same_however_much_comes(record: BusRecord) -> None:
    for number in range(0, MOST_MESSAGES + 2_000, 1_000):
        identifiers = range(number, number + 1_000)
        record.take(batch(number, *(f"{i % 0x7FF:04x}"[2:] + f"{i % 0x7FF:04x}"[:2] + "000000" for i in identifiers)))
    assert record.next - record.first == MOST_MESSAGES
    assert len(record._last_ns) <= MOST_SORTS
    assert [row.message.number for row in record.rows(0, 2)] == [2_000, 2_001]


def test_messages_after_the_instant_to_which_a_rig_went_back_are_gone(record: BusRecord) -> None:
    def entries(*times_ns: int) -> list[list[object]]:
        return [[time_ns, "io", HEARTBEAT] for time_ns in times_ns]

    record.take({**batch(0), "entries": entries(10, 20, 30)})
    record.take({**batch(0), "entries": entries(25), "backs": 1, "back_ns": 20})
    record.take({**batch(1), "entries": entries(26), "backs": 1, "back_ns": 20})
    assert [entry.time_ns for entry in record.entries()] == [10, 20, 25, 26]
    assert record.lost == 0
    assert record.next == 5, "a page that has seen the first three sees what is new"
    assert [row.message.time_ns for row in record.rows(3, 9)] == [25, 26]
