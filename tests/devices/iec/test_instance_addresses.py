"""AT %I* and AT %Q* in a function block whose instances have different addresses in VAR_CONFIG."""

from iec_program import IecBench

TEXT = """
TYPE Pair : STRUCT a : BYTE; b : WORD; END_STRUCT END_TYPE

FUNCTION_BLOCK Valve
VAR
    closed AT %I* : BOOL;
    open AT %Q* : BOOL := TRUE;
    count AT %M* : WORD;
    pair AT %M* : Pair;
END_VAR
VAR_OUTPUT calls : INT; END_VAR
calls := calls + 1;
open := NOT closed;
count := count + 1;
pair.b := pair.a + 1;
END_FUNCTION_BLOCK

FUNCTION_BLOCK Station
VAR inner : Valve; END_VAR
inner();
END_FUNCTION_BLOCK

VAR_CONFIG
    PLC_PRG.first.closed AT %IX1.0 : BOOL;
    PLC_PRG.first.open AT %QX2.0 : BOOL;
    PLC_PRG.first.count AT %MW10 : WORD;
    PLC_PRG.first.pair AT %MB40 : Pair;
    PLC_PRG.station.inner.closed AT %IX1.1 : BOOL;
    PLC_PRG.station.inner.open AT %QX2.9 : BOOL;
    PLC_PRG.station.inner.count AT %MW11 : WORD;
    PLC_PRG.station.inner.pair AT %MB50 : Pair;
END_VAR

PROGRAM PLC_PRG
VAR first : Valve; station : Station; END_VAR
first();
station();
END_PROGRAM
"""


def test_each_instance_reads_and_writes_its_own_address() -> None:
    bench = IecBench(TEXT)
    bench.host.inputs[2] = 0b10
    markers = bench.runtime.markers
    markers[20:24], markers[40], markers[50] = bytes([5, 0, 7, 0]), 8, 9
    bench.cycle()
    assert bytes(bench.host.outputs[4:6]) == bytes([1, 0])
    assert bytes(markers[20:24]) == bytes([6, 0, 8, 0])
    assert (markers[41], markers[51]) == (9, 10)
    bench.host.inputs[2] = 0b01
    bench.cycle()
    assert bytes(bench.host.outputs[4:6]) == bytes([0, 2])
    assert bytes(markers[20:24]) == bytes([7, 0, 9, 0])
    assert (bench["first.closed"], bench["station.inner.closed"]) == (True, False)


def test_an_output_is_reported_only_when_it_changes() -> None:
    bench = IecBench(TEXT)
    bench.cycle(3)
    assert bench.host.written == [4, 5]


def test_an_online_change_takes_the_new_addresses() -> None:
    bench = IecBench(TEXT)
    bench.cycle(2)
    bench.runtime.change(bench.compile(TEXT.replace("%MW10", "%MW30"), bench.compiled))
    bench.runtime.markers[60] = 100
    bench.cycle()
    assert (bench.runtime.markers[20], bench.runtime.markers[60], bench["first.calls"]) == (2, 101, 3)


def test_a_start_value_of_a_marker_reaches_the_address_of_each_instance() -> None:
    bench = IecBench(TEXT.replace("count AT %M* : WORD;", "count AT %M* : WORD := 300;"))
    bench.cycle()
    assert bytes(bench.runtime.markers[20:24]) == (301).to_bytes(2, "little") * 2


def test_structures_and_arrays_at_addresses_have_their_start_values() -> None:
    text = """
    TYPE Kind : (low := 3, high); Tank : STRUCT level : INT := -2; full : BOOL := TRUE; END_STRUCT END_TYPE
    PROGRAM PLC_PRG
    VAR
        tank AT %MB4 : Tank;
        list AT %QB8 : ARRAY[1..3] OF SINT := [1, -1, 0];
        flags AT %MB20 : ARRAY[0..1] OF BOOL := [2(TRUE)];
        kind AT %MW12 : Kind;
        free AT %QW10 : INT;
    END_VAR
    END_PROGRAM
    """
    bench = IecBench(text)
    assert bytes(bench.runtime.markers[4:7]) == bytes.fromhex("fe ff 01")
    assert bytes(bench.runtime.markers[20:26]) == bytes.fromhex("01 01 00 00 03 00")
    assert bytes(bench.host.outputs[8:12]) == bytes.fromhex("01 ff 00 00")
    assert set(bench.host.written) == {8, 9, 10}
