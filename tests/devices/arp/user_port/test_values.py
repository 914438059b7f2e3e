"""Values through the USER port: variables, flags, inputs, outputs, watchable quantities, and parameters."""

import struct

import pytest
from arp_user_port import PortBench

OK, COMMAND, LENGTH, RANGE, REFUSED = 0, 2, 3, 4, 5
READ, READ_MANY, WRITE_V, WRITE_BITS, READ_PAR, WRITE_PAR = 0x10, 0x11, 0x12, 0x13, 0x20, 0x21
FOR_EVER = "L:\nGOTO L"


@pytest.fixture
def bench() -> PortBench:
    return PortBench()


def test_variables_are_raw_and_little_endian(bench: PortBench) -> None:
    bench.access.set_variables(999, [1, -2])
    assert bench.ok(READ, bytes.fromhex("56 e7 03 02 00")) == bytes.fromhex("01 00 00 00 fe ff ff ff")
    assert bench.ok(WRITE_V, bytes.fromhex("01 00 c4 09 00 00 ff ff ff ff")) == b""
    assert bench.access.V[1:4] == [2_500, -1, 0]


def test_bits_are_packed_from_bit_0_of_the_first_octet(bench: PortBench) -> None:
    assert bench.ok(WRITE_BITS, bytes.fromhex("46 01 00 0a 00 05 02")) == b""
    assert bench.access.F[1:12] == [1, 0, 1, 0, 0, 0, 0, 0, 0, 1, 0]
    assert bench.ok(READ, bytes.fromhex("46 01 00 20 00")) == bytes.fromhex("05 02 00 00")
    assert bench.ok(READ, bytes.fromhex("46 01 00 40 01")) == bytes.fromhex("05 02") + bytes(38)  # all 320
    bench.drive("I103", True)
    bench.run_for(5)
    assert bench.ok(READ, bytes.fromhex("49 65 00 08 00")) == bytes.fromhex("04")


def test_outputs_while_the_card_runs() -> None:
    bench = PortBench(FOR_EVER, is_enabled=True)
    assert bench.ok(WRITE_BITS, bytes.fromhex("4f 66 00 01 00 01")) == b""
    bench.run_for(2)
    assert bench.last_sent("O102") is True


@pytest.mark.parametrize(
    ("command", "data", "status"),
    [
        (READ, "56 00 00 01 00", RANGE),  # V0
        (READ, "56 e8 03 02 00", RANGE),  # V1001
        (READ, "56 01 00 3d 00", LENGTH),  # 61 variables
        (READ, "56 01 00 00 00", LENGTH),
        (READ, "56 01 00 ff ff", LENGTH),
        (READ, "46 40 01 02 00", RANGE),  # F321
        (READ, "49 84 00 02 00", RANGE),  # I133
        (READ, "5a 01 00 01 00", RANGE),  # unknown letter
        (READ, "56 01 00 01", LENGTH),
        (READ, "", LENGTH),
        (READ_MANY, "", LENGTH),
        (READ_MANY, "50 01", LENGTH),
        (READ_MANY, "50 03 00", RANGE),  # axis 3
        (READ_MANY, "00 00 00", RANGE),
        (READ_MANY, "50 01 00" * 61, LENGTH),
        (WRITE_V, "01 00", LENGTH),
        (WRITE_V, "01 00 00 00 00", LENGTH),
        (WRITE_V, "e8 03 00 00 00 00 00 00 00 00", RANGE),
        (WRITE_V, "", LENGTH),
        (WRITE_BITS, "46 01 00 09 00 ff", LENGTH),
        (WRITE_BITS, "46 01 00 08 00 ff 00", LENGTH),
        (WRITE_BITS, "49 65 00 01 00 01", REFUSED),  # an input
        (WRITE_BITS, "56 01 00 01 00 01", REFUSED),
        (WRITE_BITS, "46 04 01 01 00 01", REFUSED),  # F260, axis arrived
        (WRITE_BITS, "4f 65 00 01 00 01", REFUSED),  # outputs are held at 0
        (READ_PAR, "02 00 01 01", RANGE),
        (READ_PAR, "00 03 01 01", RANGE),
        (READ_PAR, "00 00 00 01", RANGE),
        (READ_PAR, "00 00 01 00", RANGE),
        (READ_PAR, "00 00 10 02", RANGE),  # 17
        (READ_PAR, "01 02 19 01 00", LENGTH),
        (WRITE_PAR, "00 01 1a 00 00 00 00", RANGE),
        (WRITE_PAR, "00 00 01 f8 2a 00 00", RANGE),  # @Par[1] of 11 ms
        (WRITE_PAR, "00 00 01 f8 2a 00", LENGTH),
        (0x5F, "", COMMAND),
        (0x00, "", COMMAND),
    ],
)
def test_what_can_not_be_is_refused_and_changes_nothing(bench: PortBench, command: int, data: str, status: int) -> None:
    before = (list(bench.access.V), list(bench.access.F), bench.access.parameters.ram[0][:])
    assert bench.ask(command, bytes.fromhex(data))[0] == status
    assert (bench.access.V, bench.access.F, bench.access.parameters.ram[0]) == before


def test_of_several_bits_none_is_written_if_one_is_refused(bench: PortBench) -> None:
    assert bench.access.set_flag(255, 1)
    assert bench.ask(WRITE_BITS, bytes.fromhex("46 fe 00 04 00 0f"))[0] == REFUSED  # F254 to F257
    assert bench.access.F[254:258] == [0, 1, 0, 0]


def test_one_request_reads_whatever_can_be_watched() -> None:
    bench = PortBench(
        "@POS1 == 12.5\n@POS2 == -3\nDAC 1, 2.5\nV7 == 0.007\nSET F2\nSET O101\nL:\nGOTO L", is_enabled=True
    )
    bench.drive("adc3", 1.5)
    bench.run_for(5)
    asked = [
        ("V", 7), ("F", 2), ("I", 108), ("O", 101), ("P", 1), ("P", 2), ("S", 1), ("E", 1), ("A", 3), ("D", 1),
        ("C", 0), ("C", 1), ("C", 2), ("C", 3), ("G", 1), ("X", 4), ("Y", 2), ("f", 1), ("i", 1), ("o", 1),
    ]  # fmt: skip
    data = b"".join(struct.pack("<BH", ord(kind), number) for kind, number in asked)
    found = struct.unpack(f"<{len(asked)}i", bench.ok(READ_MANY, data))
    assert found == (
        7, 1, 1, 1, 12_500, -3_000, 0, 0, 1_500, 2_500,
        3, 0, 0, 204, 1_000, 0, 4_000_000, 2, 128, 1,
    )  # fmt: skip


@pytest.mark.manual("ARP-006")
def test_parameters_in_ram_are_volatile_and_those_in_flash_stay(bench: PortBench) -> None:
    kp, ki = bytes.fromhex("01 0b"), bytes.fromhex("01 0c")  # @Par1[11], [12]
    bench.ok(WRITE_PAR, b"\x00" + kp + struct.pack("<i", 7_000))
    bench.ok(WRITE_PAR, b"\x01" + ki + struct.pack("<i", 3_000))
    assert bench.ok(READ_PAR, bytes.fromhex("00 01 0b 02")) == struct.pack("<2i", 7_000, 3_000)
    assert bench.ok(READ_PAR, bytes.fromhex("01 01 0b 02")) == struct.pack("<2i", 1_000, 3_000)
    again = PortBench(store=bench.store)
    assert again.ok(READ_PAR, bytes.fromhex("00 01 0b 02")) == struct.pack("<2i", 1_000, 3_000)


def test_all_parameters_of_an_axis_fit_into_one_answer(bench: PortBench) -> None:
    assert bench.ok(READ_PAR, bytes.fromhex("00 02 01 19")) == struct.pack("<25i", *bench.access.parameters.ram[2][1:])
