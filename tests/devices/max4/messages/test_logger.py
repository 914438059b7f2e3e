"""The message logger, with both logs that the manual prints."""

from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from max4_bench import Bench

from fieldrig.storage.store import MemoryStore
from fieldrig_devices.max4.messages.diagnosis import Sender
from fieldrig_devices.max4.messages.logger import Entry, stamp
from fieldrig_devices.max4.storage.buffered_ram import RAM_BYTES, BufferedRam

GOLDEN_1 = """\
325	11:19.582	0x0001	LZS	LZS	8004		IEC-Programm gestartet
324	22.470	0x0001	LZS	LZS	8007		EPAS-4 Login
323	72				8003		Max4-Boot beendet
322	1				8002		Max4-Boot gestartet
321	24:31.389				8016		System Reset
320	23:04.244				8010	\\TEST.SCF	Datei schreiben
319	23:03.456				8010	\\PROFISL.CON	Datei schreiben
318	23:03.235				8010	\\PROFIMA.CON	Datei schreiben
317	23:03.042				8010	\\CANSL.CON	Datei schreiben
316	23:02.832				8010	\\CANMA.CON	Datei schreiben
315	23:02.160				8010	\\TEST.PAR	Datei schreiben
314	22:56.887				8010	\\DEFAULT.PRG	Datei schreiben
313	22:39.709				8007		EPAS-4 Login
312	6:30.233				8008		EPAS-4 Logout
311	3:34.739	0x0001	LZS	LZS	8004		IEC-Programm gestartet
310	1:32.483	0x0001	LZS	LZS	8007		EPAS-4 Login
309	57	0x0001	MAX4	MAX4	8003		Max4-Boot beendet
"""
"""Manual 4093-4110; in the middle a menu hides three columns."""
GOLDEN_2 = """\
325	9.540	0x0001	LZS	LZS	8007		EPAS-4 Login
324	9.529	0x1000	LZS	LZS	8013	0acd0a18	connect zum TCP/IP Server
323	98	0x0001	MAX4	MAX4	8003		Max4-Boot beendet
322	92	0x0001	LZS	LZS	8005		Automatischer Programmstart aktiv
321	92	0x0001	LZS	LZS	8004		IEC-Programm gestartet
320	14	0x0002	MC_4	Achse_1	2106		Kommunikationsfehler ZK-Controller
319	1	0x0001	MAX4	MAX4	8002		Max4-Boot gestartet
318	2:35:21.429	0x0002	MC_4	Achse_2	7134		Externe 24V-Versorgung zu niedrig
317	98	0x0001	MAX4	MAX4	8003		Max4-Boot beendet
316	92	0x0001	LZS	LZS	8005		Automatischer Programmstart aktiv
315	92	0x0001	LZS	LZS	8004		IEC-Programm gestartet
314	16	0x0002	MC_4	Achse_1	2106		Kommunikationsfehler ZK-Controller
313	1	0x0001	MAX4	MAX4	8002		Max4-Boot gestartet
312	1:18:17.155	0x1000	MAX4	MAX4	8016		System Reset
311	1:18:02.841	0x1000	LZS	LZS	8010	\\TEST.SCF	Datei schreiben
310	1:18:01.900	0x1000	LZS	LZS	8010	\\PROFISL.CON	Datei schreiben
309	1:18:01.681	0x1000	LZS	LZS	8010	\\PROFIMA.CON	Datei schreiben
308	1:18:01.487	0x1000	LZS	LZS	8010	\\CANSL.CON	Datei schreiben
307	1:18:01.276	0x1000	LZS	LZS	8010	\\CANMA.CON	Datei schreiben
"""
"""Manual 4317-4337."""
MAX4 = Sender("MAX4", "MAX4")


def fill(bench: Bench, count: int) -> None:
    for number in range(count):
        bench.max4.firmware.logger.insert(1, Sender("LZS", "LZS"), 0, "", f"entry {number}")


def seen(line: str, printed: str) -> str:
    """The line without what the menu hides in the printed one."""
    hidden = [not field and place in (2, 3, 4) for place, field in enumerate(printed.split("\t"))]
    fields = line.split("\t")
    return "\t".join("" if is_hidden else field for field, is_hidden in zip(fields, hidden, strict=True))


@pytest.mark.manual("PD-042")
@pytest.mark.manual("PD-043")
@pytest.mark.manual("PD-044")
@pytest.mark.manual("PD-045")
@pytest.mark.manual("PD-113")
@pytest.mark.manual("PD-114")
@pytest.mark.manual("PD-118")
@pytest.mark.manual("PD-123")
def test_logged_run_of_the_manual(tmp_path: Path) -> None:
    program = tmp_path / "conveyor.prg"
    program.write_bytes(b"PROGRAM PLC_PRG\nEND_PROGRAM")
    bench = Bench(simulated=("Achse_1",), program=str(program))
    fill(bench, 325)
    bench.run(100).max4.firmware.logger.reset()
    fill(bench, 308)
    bench.do("system reset").run(100)
    entries = [entry for _, entry in bench.max4.firmware.logger.entries()][::-1]
    bench.max4.firmware.logger.reset()
    for entry in entries[:308] + entries[-1:]:  # without 8016 and 8002, which the manual does not print
        bench.max4.firmware.memory.ram.log.append(entry)
    bench.clock_shows(92_483).do("login").clock_shows(214_739).do("start").clock_shows(390_233).do("logout")
    bench.clock_shows(1_359_709).do("login").clock_shows(1_376_887).do("download").run(8_000)
    bench.clock_shows(1_471_389).do("system reset")
    again = Bench(simulated=("Achse_1",), program=str(program), store=bench.store, boot={"finished_ms": 72})
    again.run(80).clock_shows(22_470).do("login").clock_shows(679_582).do("start")
    lines = again.log()
    printed = GOLDEN_1.splitlines()
    assert [seen(line, expected) for line, expected in zip(lines[: len(printed)], printed, strict=True)] == printed
    assert len(lines) == 325
    older = [line.split("\t") for line in lines[len(printed) :]]
    assert [(fields[0], fields[7]) for fields in older] == [(f"{n}", f"entry {n - 1}") for n in range(308, 0, -1)]


@pytest.mark.long
@pytest.mark.manual("PD-040")
@pytest.mark.manual("PD-041")
@pytest.mark.manual("PD-116")
@pytest.mark.manual("PD-124")
def test_logged_error_boot_of_the_manual(tmp_path: Path) -> None:
    program = tmp_path / "conveyor.prg"
    program.write_bytes(b"PROGRAM PLC_PRG\nEND_PROGRAM")
    common: dict[str, Any] = {
        "program": str(program),
        "autostart": True,
        "of_drives": {"Achse_1": {"faults": [{"what": "dc_bus"}]}},
    }
    bench = Bench("Achse_1", "Achse_2", boot={"drives_ms": 16}, **common).boot()
    bench.max4.firmware.logger.reset()
    fill(bench, 306)
    for name, ms in (("CANMA", 4_681_276), ("CANSL", 4_681_487), ("PROFIMA", 4_681_681), ("PROFISL", 4_681_900)):
        bench.clock_shows(ms).max4.firmware.disk.write(f"\\{name}.CON", b"")
    scf = bench.max4.firmware.disk.read("\\TEST.SCF")
    bench.clock_shows(4_682_841).max4.firmware.disk.write("\\TEST.SCF", scf)
    bench.clock_shows(4_697_155).do("system reset").boot()
    bench.fault("Achse_2", what="supply_24v", duration_ms=100)
    bench.clock_shows(9_321_400).run(29)
    entries = [entry for _, entry in bench.max4.firmware.logger.entries()]
    (supply,) = (entry for entry in entries if entry.code == 7134)
    assert 9_321_400 <= supply.stamp_ms <= 9_321_429
    bench.max4.firmware.logger.reset()
    for entry in entries[::-1]:  # which cycle hears of it is not the manual's
        is_supply = entry.code == 7134
        bench.max4.firmware.memory.ram.log.append(entry._replace(stamp_ms=9_321_429) if is_supply else entry)
    again = Bench("Achse_1", "Achse_2", boot={"drives_ms": 14}, store=bench.store, **common).boot()
    again.clock_shows(9_529).max4.firmware.tcp_connected("10.205.10.24")
    again.clock_shows(9_540).do("login")
    assert again.log()[:19] == GOLDEN_2.splitlines()


@pytest.mark.manual("PD-113")
@pytest.mark.manual("PD-118")
@pytest.mark.parametrize("sender", [Sender("MAX4", "MAX4"), Sender("LZS", "LZS"), Sender("MC_4", "Achse_2")])
def test_entry_has_the_fields_of_the_manual_in_their_order(sender: Sender) -> None:
    bench = Bench().run(100)
    bench.max4.firmware.logger.reset()
    bench.clock_shows(22_470)
    bench.max4.firmware.logger.insert(0x0002, sender, 2106, "0acd0a18", "Kommunikationsfehler")
    line = f"1\t22.470\t0x0002\t{sender.object}\t{sender.instance}\t2106\t0acd0a18\tKommunikationsfehler"
    assert bench.log() == [line]
    bench.max4.firmware.logger.save("\\RUN.LOG")
    head = "No.\tTimestamp\tType\tObject\tInstance\tDiag. Code\tExt. diagnosis\tMessage"
    assert bench.max4.firmware.disk.read("\\RUN.LOG").decode() == f"{head}\n{line}\n"


@pytest.mark.long
@pytest.mark.manual("PD-118", "PD-123", "PD-124")
def test_each_message_says_whose_it_is(tmp_path: Path) -> None:
    """Type, object and instance, also of lines in which the manual's print hides them."""
    program = tmp_path / "conveyor.prg"
    program.write_bytes(b"PROGRAM PLC_PRG\nEND_PROGRAM")
    bench = Bench("Achse_1", "Achse_2", program=str(program)).boot()
    bench.fault("Achse_2", what="supply_24v")
    bench.run(100).do("login").do("start").do("logout").do("system reset").boot()
    seen = {entry.code: (f"0x{entry.type:04x}", *entry.sender) for _, entry in bench.max4.firmware.logger.entries()}
    of_run = {8004: "LZS", 8007: "LZS", 8008: "LZS", 8002: "MAX4", 8003: "MAX4"}
    assert {code: seen[code] for code in of_run} == {code: ("0x0001", name, name) for code, name in of_run.items()}
    assert seen[8016] == ("0x1000", "MAX4", "MAX4")
    assert seen[7134] == ("0x0002", "MC_4", "Achse_2")


@pytest.mark.manual("PD-110")
@pytest.mark.manual("PD-111")
def test_buffer_holds_325_entries_and_loses_the_oldest() -> None:
    bench = Bench().run(100)
    bench.max4.firmware.logger.reset()
    fill(bench, 325)
    assert bench.get("MsgEntries") == 325
    assert bench.log()[-1].endswith("entry 0")
    fill(bench, 2)
    assert bench.get("MsgEntries") == 325
    assert bench.log()[0].startswith("325\t")
    assert bench.log()[-1].startswith("1\t")
    assert bench.log()[-1].endswith("entry 2")


@pytest.mark.manual("PD-115")
@pytest.mark.parametrize(
    ("ms", "text"),
    [
        (1, "1"),
        (98, "98"),
        (9_540, "9.540"),
        (22 * 60_000 + 39_709, "22:39.709"),
        (4_697_155, "1:18:17.155"),
        (9_321_429, "2:35:21.429"),
        (3 * 86_400_000 + 7_323_004, "3 02:02:03.004"),
    ],
)
def test_stamps_leave_out_leading_zero_parts(ms: int, text: str) -> None:
    assert stamp(ms) == text


@pytest.mark.manual("PD-115")
@pytest.mark.manual("PD-335")
@pytest.mark.parametrize(("version", "text"), [("V00.06.03", "22470"), ("V00.06.99", "22470"), ("V00.07.00", "22.470")])
def test_stamps_are_plain_below_version_7(version: str, text: str) -> None:
    bench = Bench(version=version).run(100)
    bench.clock_shows(22_470).do("login")
    assert bench.log()[0].split("\t")[1] == text


@pytest.mark.manual("PD-117")
def test_filter_keeps_classes_from_being_recorded() -> None:
    bench = Bench().run(100)
    bench.set("MsgFilter", 0x1000).do("login").do("save parameters")
    assert bench.codes() == [8002, 8003, 8010]
    let_through = [bench.max4.firmware.logger.insert(1 << bit, MAX4, 9000 + bit, "", "") for bit in range(16)]
    assert let_through == [bit == 12 for bit in range(16)]
    assert bench.codes() == [8002, 8003, 8010, 9012]
    bench.set("MsgFilter", 0xFFFF)
    assert bench.max4.firmware.tree.get("MAx-4.General.MsgFilter") == 0xFFFF
    bench.do("login")
    assert bench.codes()[-1] == 8007
    assert [line.split("\t")[5] for line in bench.max4.firmware.logger.lines(0x1000)] == ["9012", "8010"]


@pytest.mark.manual("PD-119")
@pytest.mark.manual("PD-120")
def test_logs_are_saved_loaded_reset_and_deleted() -> None:
    bench = Bench().run(100)
    before = bench.log()
    bench.do("save and reset log \\RUN1.LOG")
    assert bench.get("MsgEntries") == 0
    bench.max4.firmware.logger.insert(0x0004, Sender("POU", "MAIN"), 9001, "12", "lid is open")
    assert bench.log()[0].endswith("0x0004\tPOU\tMAIN\t9001\t12\tlid is open")
    bench.do("save log \\RUN2.LOG")
    assert bench.max4.firmware.logger.load("\\RUN1.LOG") == before
    assert "\\RUN1.LOG" in str(bench.get("files"))
    bench.do("delete log \\RUN1.LOG")
    assert "\\RUN1.LOG" not in str(bench.get("files"))
    with pytest.raises(ValueError, match="expected the name of a file"):
        bench.max4.firmware.logger.load("\\RUN1.LOG")
    bench.do("reset log")
    assert bench.get("MsgEntries") == 0


@pytest.mark.manual("PD-112")
@pytest.mark.parametrize(("days", "is_kept"), [(0.0, True), (7.0, True), (7.1, False)])
def test_buffer_lasts_seven_days_without_power(days: float, is_kept: bool) -> None:
    bench = Bench().run(100).do("login")
    again = Bench(store=bench.store, off_days=days).run(100)
    assert (8007 in again.codes()) is is_kept
    assert (7567 in again.codes()) is not is_kept


texts = st.text(st.characters(codec="utf-8", exclude_characters="\0"), max_size=90)
entries = st.builds(
    Entry,
    st.integers(0, 2**63),
    st.integers(0, 0xFFFF),
    st.builds(Sender, texts, texts),
    st.integers(0, 9999),
    texts,
    texts,
)


@pytest.mark.long
@settings(max_examples=30, deadline=None)
@given(st.lists(entries, max_size=8))
def test_ring_gives_back_what_fits_into_it(given_entries: list[Entry]) -> None:
    ram = BufferedRam(MemoryStore().buffered_ram(RAM_BYTES))
    for entry in given_entries:
        ram.log.append(entry)
    found = list(ram.log.entries())
    assert [entry[:2] for entry in found] == [entry[:2] for entry in given_entries]
    assert all(given.text.startswith(kept.text) for given, kept in zip(given_entries, found, strict=True))


def test_a_ring_full_of_rubbish_can_be_read() -> None:
    store = MemoryStore()
    store.buffered_ram(RAM_BYTES)[:] = b"\xff" * RAM_BYTES
    assert len(list(BufferedRam(store.buffered_ram(RAM_BYTES)).log.entries())) == 325
