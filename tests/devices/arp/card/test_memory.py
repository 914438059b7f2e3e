"""The memory of a card over power-off, and its behaviour if the memory fails (digest 10.1, 10.3; manual 2.1, 2.3)."""

import json
from collections.abc import Callable
from errno import ENOSPC
from pathlib import Path
from typing import Any

import pytest
from arp_bench import CardBench, Groups, whole
from full_store import FullStore
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig.storage.store import FileStore, MemoryStore, StoreError
from fieldrig_devices.arp.card.permanent import MARK
from fieldrig_devices.arp.card_access import CardState, RefusedError
from fieldrig_devices.arp.language import files
from fieldrig_devices.arp.language.compiler import compile_text
from fieldrig_devices.arp.language.files import ObjectError
from fieldrig_devices.arp.parameters import Par

LOOP = "LOOP:\nV1 += 1\nGOTO LOOP"
SPEED = 7
AXIS_1 = 1


class FailingStore(MemoryStore):
    """Accepts a number of saves and then refuses."""

    def __init__(self, saves: int = 0) -> None:
        super().__init__()
        self.saves_left = saves

    def save(self, data: bytes) -> None:
        if self.saves_left == 0:
            raise StoreError(ENOSPC, "No space left on device")
        self.saves_left -= 1
        super().save(data)


def an_object(program: str, system: int = 1, name: str = "winder") -> bytes:
    return files.encode(compile_text(whole(program)), name, system)


def filled() -> MemoryStore:
    """The store of a card that was switched on before."""
    store = MemoryStore()
    CardBench(LOOP, {"axis1": {SPEED: 1234}}, store=store).run_for(20)
    return store


# ---- blank and good memory


@pytest.mark.manual("ARP-051")
def test_w04_at_the_first_start_only() -> None:
    store = MemoryStore()
    assert CardBench(LOOP, store=store).run_for(20).warning == 204
    assert CardBench(LOOP, store=store).run_for(20).warning == 0


def test_w04_is_cleared_like_any_other() -> None:
    bench = CardBench(LOOP, is_enabled=False).run_for(20)
    assert bench.warning == 204
    assert bench.drive("I108", True).run_for(20).warning == 0


@pytest.mark.manual("ARP-004")
def test_the_program_runs_after_power_off_without_its_file() -> None:
    store = filled()
    bench = CardBench(store=store).run_for(30)
    assert (bench.state, bench.access.program_name) == (CardState.RUN, "program")


@pytest.mark.manual("ARP-061")
def test_variables_last_over_power_off_reset_and_enable() -> None:
    store = MemoryStore()
    bench = CardBench("V1 == 12.5\nV1000 == H80000000\nV[V2] += 1\nLOOP:\nGOTO LOOP", store=store)
    bench.put_variable(2, 500)
    bench.run_for(20)
    for _ in range(2):
        bench.drive("I108", False).run_for(20).drive("I108", True).run_for(20)
    bench.access.reset()
    bench = CardBench(store=store)
    assert [bench.access.V[number] for number in (1, 1000, 500)] == [12_500, -(2**31), 3_000]


@pytest.mark.manual("ARP-063")
def test_flags_do_not_last() -> None:
    store = MemoryStore()
    assert CardBench("SET F1\nSET F217", store=store).run_for(20).access.F[217]
    bench = CardBench("V1 == 1", store=store).run_for(20)
    assert not any(bench.access.F[1:218])


# ---- parameters


@pytest.mark.manual("ARP-005", "ARP-006", "ARP-058")
def test_a_program_changes_the_copy_in_ram_only() -> None:
    program = "V1 == @PAR1[7]\n@PAR1[7] == 55.5\nV2 == @PAR1[7]\nV3 == @PAR2[25]\nV4 == @PAR[16]\nLOOP:\nGOTO LOOP"
    bench = CardBench(program, {"axis1": {SPEED: 1234.5}}).run_for(20)
    assert [bench.variable(number) for number in (1, 2, 3, 4)] == [1234.5, 55.5, 10, 10]
    assert bench.access.parameters.flash[AXIS_1][SPEED] == 1_234_500
    bench.drive("I108", False).run_for(10).drive("I108", True)
    bench.access.parameters.ram[AXIS_1][SPEED] = 0
    bench.run_for(20)
    assert bench.variable(1) == 1234.5


@pytest.mark.manual("ARP-006")
def test_ctrl_f2_and_run_load_parameters_from_flash() -> None:
    bench = CardBench("@PAR2[8] == 7\nLOOP:\nGOTO LOOP").run_for(20)
    assert bench.get("par2.8") == 7.0
    bench.access.reset()
    bench.access.run_program()
    assert bench.get("par2.8") == 100_000.0


RESETS: dict[str, Callable[[CardBench], object]] = {
    "Ctrl-F2": lambda bench: bench.access.reset(),
    "Enable opened": lambda bench: bench.drive("I108", False).run_for(20),
}


@pytest.mark.manual("ARP-006")
@pytest.mark.parametrize("reset", RESETS.values(), ids=RESETS)
def test_every_reset_reads_the_parameters_from_flash_at_once(reset: Callable[[CardBench], object]) -> None:
    """Manual 2.3: read again at every start and reset; 4.2.2: set each time the system is reset."""
    bench = CardBench("@PAR2[8] == 7\nLOOP:\nGOTO LOOP", {"axis1": {SPEED: 1234}}).run_for(20)
    assert bench.access.save_parameter(AXIS_1, SPEED, 777_000)
    assert bench.access.set_parameter(AXIS_1, SPEED, 5_000)
    assert bench.access.set_parameter(0, Par.DIAGNOSTIC_1_GAIN, 3_000)
    assert [bench.get(key) for key in ("par2.8", "par.11", "par1.7")] == [7.0, 3.0, 5.0]
    reset(bench)
    assert [bench.get(key) for key in ("par2.8", "par.11", "par1.7")] == [100_000.0, 1.0, 777.0]
    bench.access.set_parameter(AXIS_1, SPEED, 5_000)
    bench.access.reset()  # once more, while it is held
    assert bench.get("par1.7") == 777.0


@pytest.mark.manual("ARP-006")
def test_a_reset_reads_the_flash_itself() -> None:
    bench = CardBench(LOOP).run_for(20)
    other = CardBench(LOOP).run_for(20)
    assert other.access.save_parameter(AXIS_1, SPEED, 777_000)
    data = other.store.load()
    assert data is not None
    bench.store.save(data)
    bench.access.reset()
    assert bench.get("par1.7") == 777.0


@pytest.mark.manual("ARP-006")
def test_what_the_service_port_saves_lasts() -> None:
    store = filled()
    bench = CardBench(LOOP, {"axis1": {SPEED: 1234}}, store=store).run_for(20)
    assert bench.access.save_parameter(AXIS_1, SPEED, 777_000)
    assert bench.access.parameters.ram[AXIS_1][SPEED] == 777_000
    bench = CardBench(LOOP, {"axis1": {SPEED: 1234}}, store=store).run_for(20)
    assert bench.get("par1.7") == 777.0  # the rig file has not changed


def test_a_changed_value_in_the_rig_file_is_written_again() -> None:
    store = filled()
    CardBench(LOOP, {"axis1": {SPEED: 1234}}, store=store).access.save_parameter(AXIS_1, 8, 5_000)
    bench = CardBench(LOOP, {"axis1": {SPEED: 4321}}, store=store).run_for(20)
    assert (bench.get("par1.7"), bench.get("par1.8")) == (4321.0, 5.0)


@pytest.mark.parametrize(
    ("group", "number", "raw"), [(0, 1, 11_000), (0, 1, 1_500), (1, 4, 4_000), (1, 26, 0), (3, 1, 0)]
)
def test_a_parameter_out_of_range_is_refused_from_outside(group: int, number: int, raw: int) -> None:
    bench = CardBench(LOOP).run_for(20)
    before = [list(table) for table in bench.access.parameters.flash]
    assert not bench.access.set_parameter(group, number, raw)
    assert not bench.access.save_parameter(group, number, raw)
    assert bench.access.parameters.flash == before


@pytest.mark.manual("ARP-012", "ARP-026")
def test_reserved_parameters_are_kept_and_do_nothing() -> None:
    reserved: Groups = {"general": {7: 5, 9: -1.5}, "axis1": {9: 1, 17: 2, 18: 3}, "axis2": {9: -4, 17: 0.001, 18: 6}}
    bench, plain = (CardBench(LOOP, parameters).run_for(500) for parameters in (reserved, {}))
    for group, name in (("general", "par"), ("axis1", "par1"), ("axis2", "par2")):
        for number, value in reserved[group].items():
            assert (bench.get(f"{name}.{number}"), plain.get(f"{name}.{number}")) == (value, 0)
    assert (bench.state, bench.warning, bench.error) == (CardState.RUN, plain.warning, 0)
    assert bench.variable(1) == plain.variable(1) > 0


@pytest.mark.long
@pytest.mark.manual("ARP-007", "ARP-016")
def test_periods_are_taken_at_power_on_only() -> None:
    bench = CardBench(LOOP, {"general": {1: 4, 16: 40}}).run_for(100)
    cycles = int(bench.get("cycles"))
    assert cycles == 25
    assert bench.access.save_parameter(0, Par.CONTROL_PERIOD_MS, 1_000)
    bench.drive("I108", False).run_for(50).drive("I108", True).run_for(50)
    assert int(bench.get("cycles")) - cycles == 25
    again = CardBench(LOOP, {"general": {1: 4, 16: 40}}, store=bench.store).run_for(100)
    assert again.get("cycles") == 100


# ---- faults of the memory


@pytest.mark.manual("ARP-050")
def test_e03_if_the_store_takes_nothing_at_the_first_start() -> None:
    bench = CardBench(LOOP, store=FailingStore()).run_for(50)
    assert (bench.state, bench.error) == (CardState.BLOCKED, 103)


@pytest.mark.manual("ARP-050")
@pytest.mark.parametrize(
    "damage",
    [
        lambda data: b"",
        lambda data: data[:-30],
        lambda data: data.replace(b"1234000", b"-234000"),
        lambda data: b"\xff" * len(data),
        lambda data: data[:-1] + b"\n",
    ],
)
def test_e03_if_what_is_stored_is_damaged(damage: Callable[[bytes], bytes]) -> None:
    data = filled().load()
    assert data is not None
    store = MemoryStore(damage(data))
    bench = CardBench(LOOP, {"axis1": {SPEED: 1234}}, store=store).run_for(50)
    assert (bench.state, bench.error) == (CardState.BLOCKED, 103)
    assert store.load() == damage(data)  # it was not overwritten
    bench.drive("I108", False).run_for(20).drive("I108", True).run_for(20)
    assert (bench.state, bench.error) == (CardState.BLOCKED, 103)
    assert bench.access.save_parameter(AXIS_1, 8, 5_000)  # writes the complete content
    bench.drive("I108", False).run_for(20).drive("I108", True).run_for(20)
    assert (bench.state, bench.error) == (CardState.RUN, 0)


@pytest.mark.long
@given(st.binary(max_size=200))
@settings(max_examples=60, deadline=None)
def test_no_content_of_the_store_crashes_the_card(data: bytes) -> None:
    bench = CardBench(LOOP, store=MemoryStore(data)).run_for(30)
    assert (bench.state, bench.error) == (CardState.BLOCKED, 103)


@pytest.mark.parametrize(
    "body", [b"{}", b"[]", b"1", b'{"version": 1}', b'{"version": 1, "parameters": [[1], [], []]}']
)
def test_something_else_is_e03_too(body: bytes) -> None:
    assert CardBench(LOOP, store=MemoryStore(body)).run_for(30).error == 103


@pytest.mark.parametrize(
    "wrong", [{"parameters": []}, {"parameters": 2}, {"parameters": 4}, {"program": "\ud800"}], ids=str
)
def test_fields_that_no_card_writes_are_e03_too(wrong: dict[str, Any]) -> None:
    data = filled().load()
    assert data is not None
    fields = json.loads(data)
    if isinstance(groups := wrong.get("parameters"), int):
        wrong = {"parameters": [*fields["parameters"], fields["parameters"][-1]][:groups]}
    store = MemoryStore(json.dumps(fields | wrong).encode())
    assert CardBench(LOOP, store=store).run_for(30).error == 103


def test_a_damaged_flash_gives_the_version_before_it() -> None:
    bench = CardBench(LOOP).run_for(20)
    bench.access.save_parameter(AXIS_1, SPEED, 777_000)
    data = bench.store.load()
    assert data is not None
    bench.store.save(data.replace(b"777000", b"-77000"))  # beyond its limits
    again = CardBench(LOOP, store=bench.store).run_for(50)
    assert (again.state, again.error, again.get("par1.7")) == (CardState.RUN, 0, 777.0)


@pytest.mark.long
def test_what_was_refused_at_the_first_start_is_stored_when_there_is_room() -> None:
    store = FullStore()
    bench = CardBench(LOOP, {"axis1": {SPEED: 1234}}, store=store).run_for(50)
    assert bench.error == 103
    bench.drive("I108", False).run_for(20).drive("I108", True).run_for(50)
    assert (bench.state, bench.error, bench.get("par1.7")) == (CardState.RUN, 0, 1234.0)
    store.is_full = False
    bench.drive("I108", False).run_for(20)
    assert CardBench(store=store).run_for(50).get("par1.7") == 1234.0


def test_variables_last_again_after_a_reset_when_there_is_ram() -> None:
    store = FullStore()
    store.is_full = store.has_ram = False
    bench = CardBench(store=store).run_for(50)
    bench.put_variable(7, 12.5)
    bench.run_for(20)
    store.has_ram = True
    bench.drive("I108", False).run_for(20).drive("I108", True).run_for(50)
    bench.put_variable(8, 3.5)
    bench.run_for(20)
    again = CardBench(store=store).run_for(20)
    assert (again.variable(7), again.variable(8)) == (12.5, 3.5)


@pytest.mark.manual("ARP-050")
def test_e03_if_a_parameter_cannot_be_saved() -> None:
    bench = CardBench(LOOP, store=FailingStore(saves=1)).run_for(50)
    assert bench.state is CardState.RUN
    assert not bench.access.save_parameter(AXIS_1, SPEED, 777_000)
    assert (bench.state, bench.error) == (CardState.BLOCKED, 103)
    assert bench.access.parameters.flash[AXIS_1][SPEED] == 10_000_000
    bench.drive("I108", False).run_for(20).drive("I108", True).run_for(20)
    assert (bench.state, bench.error) == (CardState.RUN, 0)  # the stored data are readable


def test_a_read_error_of_the_store_is_e03(tmp_path: Path) -> None:
    path = tmp_path / "card1"
    path.mkdir()  # cannot be read as a file
    assert CardBench(LOOP, store=FileStore(path)).run_for(50).error == 103


def test_no_ram_at_all_is_e03_and_variables_last_until_power_off() -> None:
    store = FullStore()
    store.is_full = store.has_ram = False
    bench = CardBench(LOOP, store=store).run_for(50)
    assert (bench.state, bench.error) == (CardState.BLOCKED, 103)
    bench.drive("I108", False).run_for(20).drive("I108", True).run_for(50)
    assert (bench.state, bench.variable(1) > 0) == (CardState.RUN, True)


def test_ram_without_its_mark_is_e03_once_and_blank_afterwards() -> None:
    store = filled()
    words = store.buffered_ram(4004).cast("i")
    words[0], words[5] = 12345, 678
    bench = CardBench(LOOP, store=store).run_for(50)
    assert (bench.error, bench.access.V[5]) == (103, 0)
    assert CardBench(LOOP, store=store).run_for(50).error == 0


@pytest.mark.long
@given(st.binary(min_size=4000, max_size=4000))
@settings(max_examples=20, deadline=None)
def test_no_value_in_the_ram_crashes_the_card(content: bytes) -> None:
    store = filled()
    ram = store.buffered_ram(4004)
    ram.cast("i")[0] = MARK
    ram[4:] = content
    bench = CardBench("V10 == V1 + V2\nV11 == SQR(V3)\nPAC 1, V4\nPST 2, 1, V5\nV12 == V[V6]\n" + LOOP, store=store)
    assert bench.run_for(30).state is CardState.RUN
    assert -(2**31) <= min(bench.access.V) <= max(bench.access.V) < 2**31


# ---- programs


@pytest.mark.manual("ARP-117")
@pytest.mark.parametrize(
    "state", [CardState.RESET_ENABLE, CardState.RESET_COMMAND, CardState.STOPPED, CardState.BLOCKED]
)
def test_a_program_is_loaded_while_nothing_runs(state: CardState) -> None:
    bench = CardBench(LOOP if state is not CardState.BLOCKED else "").run_for(20)
    match state:
        case CardState.RESET_ENABLE:
            bench.drive("I108", False).run_for(20)
        case CardState.RESET_COMMAND:
            bench.access.reset()
        case CardState.STOPPED:
            bench.access.stop_program()
    assert bench.state is state
    bench.load(an_object("V7 == 7"))
    assert (bench.state, bench.access.program_name, bench.line) == (state, "winder", 2)
    bench.drive("I108", False).run_for(20).drive("I108", True).run_for(20)
    assert bench.variable(7) == 7


@pytest.mark.manual("ARP-117")
def test_a_program_that_runs_is_not_replaced() -> None:
    bench = CardBench(LOOP).run_for(20)
    with pytest.raises(RefusedError, match="is running"):
        bench.load(an_object("V7 == 7"))
    assert (bench.state, bench.access.program_name) == (CardState.RUN, "program")


@pytest.mark.manual("ARP-118")
@pytest.mark.parametrize("data", [b"", b"ARP OBJECT 1\n", an_object("V1 == 1", system=2), an_object("V1 == 1")[:-4]])
def test_what_is_no_object_of_this_card_leaves_the_old_program(data: bytes) -> None:
    bench = CardBench(LOOP).run_for(20)
    bench.access.stop_program()
    with pytest.raises(ObjectError):
        bench.load(data)
    assert (bench.access.program_name, bench.access.run_program()) == ("program", True)
    assert CardBench(store=bench.store).run_for(20).access.program_name == "program"


def test_a_program_that_cannot_be_saved_leaves_the_old_one() -> None:
    bench = CardBench(LOOP, store=FailingStore(saves=1)).run_for(20)
    bench.access.stop_program()
    with pytest.raises(RefusedError, match="E03"):
        bench.load(an_object("V7 == 7"))
    assert (bench.access.program_name, bench.error) == ("program", 103)


def test_what_was_downloaded_stays_until_the_file_changes() -> None:
    store = MemoryStore()
    bench = CardBench(LOOP, store=store).run_for(20)
    bench.access.stop_program()
    bench.load(an_object("V7 == 7"))
    assert CardBench(LOOP, store=store).run_for(20).access.program_name == "winder"
    assert CardBench(LOOP + "\nV9 == 9", store=store).run_for(20).access.program_name == "program"


@pytest.mark.manual("ARP-050")
def test_an_invalid_program_in_memory_is_e11_at_run() -> None:
    store = filled()
    bench = CardBench(LOOP, store=store).run_for(20)
    memory = bench.card.parts.memory
    memory.content.program = "ARP OBJECT 9"
    memory.write()
    bench = CardBench(LOOP, {"axis1": {SPEED: 1234}}, store=store, is_enabled=False).run_for(20)
    assert bench.error == 105
    bench.drive("I108", True).run_for(20)
    assert (bench.state, bench.error) == (CardState.BLOCKED, 111)


def test_a_section_lasts_beside_the_rest() -> None:
    bench = CardBench(LOOP).run_for(20)
    section = bench.card.parts.memory.section("another", bench.card.operation.on_memory_fault)
    assert section.load() is None
    section.save(b"\x00\xff")
    again = CardBench(LOOP, store=bench.store).run_for(20)
    assert again.card.parts.memory.section("another", lambda: None).load() == b"\x00\xff"
    assert again.access.program_name == "program"


def test_a_section_that_cannot_be_saved_is_e03() -> None:
    bench = CardBench(LOOP, store=FailingStore(saves=1)).run_for(20)
    section = bench.card.parts.memory.section("another", bench.card.operation.on_memory_fault)
    with pytest.raises(OSError, match="written"):
        section.save(b"1")
    assert bench.error == 103
    assert section.load() is None
