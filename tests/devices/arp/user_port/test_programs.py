"""Programs through the USER port: run, stop, reset, download, upload."""

import struct
import zlib

import pytest
from arp_bench import CardBench
from arp_user_port import PortBench, an_object

OK, LENGTH, RANGE, REFUSED, ORDER, DAMAGED, OBJECT, NO_PROGRAM = 0, 3, 4, 5, 6, 7, 8, 9
RUN, STOP, RESET = 0x03, 0x04, 0x05
BEGIN, BLOCK, COMMIT, ABORT, UP_BEGIN, UP_BLOCK = 0x30, 0x31, 0x32, 0x33, 0x34, 0x35
COUNT = "L:\nV1 += 1\nWAIT 0.01\nGOTO L"
OTHER = an_object("L:\nV2 += 1\nWAIT 0.01\nGOTO L", name="OTHER")


def announced(data: bytes) -> bytes:
    return struct.pack("<II", len(data), zlib.crc32(data))


def does_the_old_program_run(bench: PortBench) -> bool:
    """Load a program that counts in V1; OTHER counts in V2."""
    bench.enable(False)
    bench.enable()
    before = bench.access.V[1:3]
    bench.run_for(100)
    return bench.access.V[1] > before[0] and bench.access.V[2] == before[1]


@pytest.mark.manual("ARP-044")
def test_ctrl_f2_puts_the_card_in_reset_without_an_error() -> None:
    bench = PortBench(f"SET O101\nPVC 1, 10\n{COUNT}", parameters={"axis1": {4: 1}}, is_enabled=True)
    moving = bench.access.position(1)
    bench.run_for(10)
    assert (bench.last_sent("O101"), bench.condition()[:3], bench.access.position(1) > moving) == (
        True,
        (3, 2, 0),
        True,
    )
    assert bench.condition()[5] > 3  # in the loop
    bench.ok(RESET)
    bench.run_for(2)
    still = bench.access.position(1)
    bench.run_for(100)
    assert (bench.last_sent("O101"), bench.access.position(1)) == (False, still)
    assert bench.condition()[:6] == (2, 1, 0, 0, 0, 2)  # no error; held at its first instruction, on line 2


@pytest.mark.manual("ARP-044")
def test_run_leaves_the_reset_state_at_the_first_instruction() -> None:
    bench = PortBench(f"V3 += 1\n{COUNT}", is_enabled=True)
    bench.ok(RESET)
    bench.ok(RUN)
    bench.run_for(50)
    assert (bench.condition()[:2], bench.access.V[3]) == ((3, 2), 2_000)


@pytest.mark.manual("ARP-049")
def test_ctrl_f2_clears_errors_and_warnings() -> None:
    bench = PortBench("V1 == 1 / 0\nPST 1, 1, V1\nL:\nGOTO L", is_enabled=True)
    assert bench.condition()[2:5] == (113, 1, 201)
    bench.ok(RESET)
    assert bench.condition()[:5] == (2, 1, 0, 0, 0)


@pytest.mark.manual("ARP-049")
def test_opening_and_closing_enable_clears_errors_and_warnings() -> None:
    bench = PortBench("IF V9 = 0, V1 == 1 / 0\nIF V9 = 0, PST 1, 1, V1\nL:\nGOTO L", is_enabled=True)
    assert bench.condition()[2:5] == (113, 1, 201)
    bench.access.set_variables(9, [1_000])
    bench.enable(False)
    assert bench.condition()[:3] == (1, 1, 105)
    bench.enable()
    assert bench.condition()[:5] == (3, 2, 0, 0, 0)


def test_run_and_stop_say_why_not() -> None:
    bench = PortBench(COUNT)
    assert bench.ask(RUN) == (REFUSED, b"Enable (I108) is open: close it to run the program")
    assert bench.ask(STOP)[0] == REFUSED
    bench.enable()
    assert bench.ask(RUN) == (REFUSED, b"the program is already running")
    bench.ok(STOP)
    assert bench.condition()[:2] == (4, 3)
    assert bench.ask(STOP) == (REFUSED, b"no program is running")
    assert PortBench().ask(RUN)[0] == NO_PROGRAM
    assert bench.ask(RUN, b"x")[0] == LENGTH


# ---- download


@pytest.mark.manual("ARP-117")
def test_a_program_is_downloaded_while_stopped_and_run_from_the_pc_or_by_enable() -> None:
    bench = PortBench(COUNT, is_enabled=True)
    bench.ok(STOP)
    assert bench.ok(BEGIN, announced(OTHER)) == bytes.fromhex("F0 00")  # the maximum number of octets in a block
    assert bench.downloaded(OTHER) == (OK, b"")
    assert bench.access.program_name == "OTHER"
    bench.run_for(50)
    assert bench.access.V[2] == 0  # held until it is started
    bench.ok(RUN)
    bench.run_for(50)
    assert bench.access.V[2] > 0
    assert not does_the_old_program_run(bench)


@pytest.mark.manual("ARP-004", "ARP-117")
def test_what_was_downloaded_is_permanent() -> None:
    bench = PortBench(COUNT)
    assert bench.downloaded(OTHER)[0] == OK
    again = CardBench(store=bench.store)
    again.run_for(100)
    assert (again.access.program_name, again.access.V[2] > 0) == ("OTHER", True)


@pytest.mark.manual("ARP-117")
def test_a_download_is_refused_while_the_program_runs() -> None:
    bench = PortBench(COUNT, is_enabled=True)
    assert bench.ask(BEGIN, announced(OTHER))[0] == REFUSED
    assert bench.ask(BLOCK, bytes(4) + OTHER[:240])[0] == ORDER
    assert bench.commit()[0] == ORDER
    assert does_the_old_program_run(bench)


def test_a_program_that_was_started_meanwhile_is_not_replaced() -> None:
    bench = PortBench(COUNT)
    bench.ok(BEGIN, announced(OTHER))
    bench.ok(BLOCK, bytes(4) + OTHER)
    bench.enable()
    assert bench.commit()[0] == REFUSED
    assert does_the_old_program_run(bench)


@pytest.mark.parametrize(
    ("data", "status"),
    [
        (b"nonsense", OBJECT),
        (OTHER[:-1], OK),  # the final line end is missing
        (OTHER[:-3], OBJECT),
        (OTHER.replace(b"V2", b"V3"), OBJECT),  # with its own CRC
        (an_object("V1 == 1", number=2), OBJECT),  # for another card
    ],
)
def test_what_is_no_program_for_this_card_leaves_the_old_one(data: bytes, status: int) -> None:
    bench = PortBench(COUNT)
    assert bench.downloaded(data)[0] == status
    assert does_the_old_program_run(bench) is (status != OK)


def test_an_incomplete_or_damaged_download_leaves_the_old_program() -> None:
    bench = PortBench(COUNT)
    bench.ok(BEGIN, announced(OTHER))
    bench.ok(BLOCK, bytes(4) + OTHER[:-10])
    assert bench.commit()[0] == DAMAGED
    assert bench.commit()[0] == ORDER
    bench.ok(BEGIN, announced(OTHER))
    bench.ok(BLOCK, bytes(4) + OTHER.replace(b"V2", b"V3"))
    assert bench.commit()[0] == DAMAGED
    assert does_the_old_program_run(bench)


def test_a_new_beginning_an_abort_and_a_hello_drop_half_a_download() -> None:
    bench = PortBench(COUNT)
    for command, data in ((BEGIN, announced(OTHER)), (ABORT, b""), (0x01, b"")):
        bench.ok(BEGIN, announced(OTHER))
        bench.ok(BLOCK, bytes(4) + OTHER[:100])
        bench.ok(command, data)
        assert bench.ask(BLOCK, struct.pack("<I", 100) + OTHER[100:])[0] == ORDER
    assert does_the_old_program_run(bench)


def test_blocks_come_in_order_and_none_is_too_many() -> None:
    bench = PortBench()
    bench.ok(BEGIN, announced(b"x" * 300))
    assert bench.ask(BLOCK, struct.pack("<I", 5) + b"x") == (ORDER, b"the next block begins at 0")
    assert bench.ask(BLOCK, bytes(4))[0] == LENGTH
    assert bench.ask(BLOCK, bytes(4) + b"x" * 241)[0] == LENGTH
    bench.ok(BLOCK, bytes(4) + b"x" * 240)
    assert bench.ask(BLOCK, bytes(4) + b"x" * 240)[0] == ORDER
    assert bench.ask(BLOCK, struct.pack("<I", 240) + b"x" * 61)[0] == LENGTH


@pytest.mark.parametrize("length", [0, 1_000_001, 0xFFFF_FFFF])
def test_the_length_of_an_object_is_bounded(length: int) -> None:
    assert PortBench().ask(BEGIN, struct.pack("<II", length, 0))[0] == RANGE


# ---- upload


@pytest.mark.long
def test_the_program_comes_back_as_it_was_downloaded() -> None:
    long = an_object("\n".join(f"V{number} == {number}.5 * V1 + SQR(V2)" for number in range(1, 200)), name="LONG")
    bench = PortBench()
    assert bench.downloaded(long)[0] == OK
    length, crc = struct.unpack("<II", bench.ok(UP_BEGIN))
    back = b"".join(bench.ok(UP_BLOCK, struct.pack("<I", offset)) for offset in range(0, length, 240))
    assert (back, zlib.crc32(back)) == (long, crc)


def test_an_upload_of_nothing() -> None:
    bench = PortBench()
    assert bench.ask(UP_BEGIN)[0] == NO_PROGRAM
    assert bench.ask(UP_BLOCK, bytes(4))[0] == ORDER
    bench = PortBench(COUNT)
    length, _ = struct.unpack("<II", bench.ok(UP_BEGIN))
    assert bench.ask(UP_BLOCK, struct.pack("<I", length))[0] == RANGE
