"""The part of TwinCAT's libraries that programs get without a machine.

Expected values are those of the public descriptions, and of the calendar of Python.
"""

from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from iec_program import IecBench, PlainHost, program
from st_tests import one

from fieldrig_devices.iec.dialect import CODESYS
from fieldrig_devices.iec.testing.case import Verdict

DATES = program(
    "in : ULINT; s : TIMESTRUCT; back, dc : ULINT; text : STRING(29); d : DT;",
    "s := FILETIME64_TO_SYSTEMTIME(in); back := SYSTEMTIME_TO_FILETIME64(s); text := SYSTEMTIME_TO_STRING(s);"
    "dc := FILETIME64_TO_DCTIME64(in); d := SYSTEMTIME_TO_DT(s);",
)
EPOCH = datetime(1601, 1, 1, tzinfo=UTC)


@pytest.fixture(scope="module")
def dates() -> IecBench:
    return IecBench(DATES, CODESYS)


@settings(max_examples=60, deadline=None)
@given(st.datetimes(datetime(1970, 1, 1), datetime(2100, 12, 31)))  # noqa: DTZ001
def test_dates_are_those_of_the_calendar(dates: IecBench, moment: datetime) -> None:
    moment = moment.replace(tzinfo=UTC)
    ticks = (moment - EPOCH) // timedelta(microseconds=1) * 10
    dates["in"] = ticks
    dates.cycle()
    assert dates["text"] == f"{moment:%Y-%m-%d-%H:%M:%S}.{moment.microsecond // 1000:03}"
    assert dates["back"] == ticks // 10_000 * 10_000
    assert dates["s.wDayOfWeek"] == moment.isoweekday() % 7
    assert dates["d"] == int(moment.timestamp())


def ran(declarations: str, body: str, before: str = "") -> IecBench:
    bench = IecBench(before + program(declarations, body), CODESYS)
    bench.cycle()
    return bench


def test_the_time_of_the_system_begins_in_2026_and_goes_on_with_the_program() -> None:
    host = PlainHost()
    text = program(
        "t : STRING(29); f : FB_LocalSystemTime; y : WORD;",
        "t := DCTIME64_TO_STRING(F_GetCurDcTaskTime64()); f(bEnable := TRUE); y := f.systemTime.wYear;",
    )
    bench = IecBench(text, CODESYS, host)
    bench.cycle()
    assert (bench["t"], bench["y"]) == ("2026-01-01-00:00:00.000000000", 2026)
    host.ms = 61_005
    bench.cycle()
    assert bench["t"] == "2026-01-01-00:01:01.005000000"


@pytest.mark.parametrize(
    ("form", "expected"),
    [
        ("%s", "abc"),
        ("<%5s>", "<  abc>"),
        ("<%-5s>", "<abc  >"),
        ("%.2s", "ab"),
        ("100%%", "100%"),
    ],
)
def test_formats_of_texts(form: str, expected: str) -> None:
    bench = ran(
        "f : FB_FormatString; s : STRING := 'abc'; o : STRING;",
        f"f(sFormat := '{form}', arg1 := F_STRING(s)); o := f.sOut;",
    )
    assert bench["o"] == expected


@pytest.mark.parametrize(
    ("kind", "value", "form", "expected"),
    [
        ("INT", "-5", "%d", "-5"),
        ("INT", "-5", "%05d", "000-5"),
        ("UDINT", "7", "%03d", "007"),
        ("LINT", "-9", "%d", "-9"),
        ("WORD", "16#AB", "%04X", "00AB"),
        ("DWORD", "16#AB", "%x", "ab"),
        ("LREAL", "3.14159", "%.2f", "3.14"),
        ("REAL", "-0.5", "%.1f", "-0.5"),
        ("BOOL", "TRUE", "%b", "TRUE"),
    ],
)
def test_formats_of_numbers(kind: str, value: str, form: str, expected: str) -> None:
    body = f"f(sFormat := '{form}', arg1 := F_{kind}(v)); o := f.sOut;"
    assert ran(f"f : FB_FormatString; v : {kind} := {value}; o : STRING;", body)["o"] == expected


def test_texts_of_any_size_by_their_address() -> None:
    bench = ran(
        "a : STRING(300) := 'Hello '; b : STRING := 'World'; c : STRING(300); n, at_ : UDINT; ok, cut : BOOL;"
        "d : STRING(4);",
        "ok := CONCAT2(ADR(a), ADR(b), ADR(c), SIZEOF(c)); n := LEN2(ADR(c)); at_ := FIND2(ADR(c), ADR(b), TRUE);"
        "cut := NOT STRNCPY(ADR(d), ADR(c), SIZEOF(d));",
    )
    assert [bench[name] for name in ("c", "n", "at_", "ok", "cut", "d")] == ["Hello World", 11, 7, True, True, "Hell"]


def test_texts_of_any_length_are_put_together_by_their_addresses() -> None:
    """The examples of the descriptions; then a place behind the end, too little room, and a text in its own place."""
    bench = ran(
        "a : STRING(300) := 'SUSI'; b : STRING := 'XY'; c, d, e, f, g : STRING(300); small : STRING(4);"
        "own : STRING(20) := 'abcdef'; cut : BOOL; ok : ARRAY[0..5] OF BOOL; size : UDINT := SIZEOF(STRING(300));",
        "ok[0] := INSERT2(ADR(a), ADR(b), ADR(c), size, 2); ok[1] := DELETE2(ADR(c), ADR(d), size, 2, 3);"
        "ok[2] := REPLACE2(ADR(a), ADR(b), ADR(e), size, 2, 2); ok[3] := INSERT2(ADR(a), ADR(b), ADR(f), size, 99);"
        "ok[4] := DELETE2(ADR(a), ADR(g), size, 99, 2); cut := INSERT2(ADR(a), ADR(b), ADR(small), SIZEOF(small), 1);"
        "ok[5] := INSERT2(ADR(own), ADR(b), ADR(own), SIZEOF(own), 3); DELETE2(ADR(own), ADR(own), SIZEOF(own), 1, 1);",
    )
    texts = ["SUXYSI", "SUSI", "SXYI", "SUSIXY", "S", "SXYU", "bcXYdef"]
    assert [bench[name] for name in ("c", "d", "e", "f", "g", "small", "own")] == texts
    assert [bench[f"ok[{number}]"] for number in range(6)] == [True] * 6
    assert bench["cut"] is False


def test_numbers_are_asked_whether_they_are_finite() -> None:
    bench = ran(
        "x : LREAL; r : REAL; a, b, c, d, e : BOOL;",
        "x := LOG(-1.0); r := LREAL_TO_REAL(x); a := LrealIsNaN(x) AND RealIsNaN(r) AND FLOATIsNaN(x);"
        "b := LrealIsFinite(x) OR RealIsFinite(r); x := 1.0E308; c := LrealIsFinite(x) AND NOT LrealIsNaN(x);"
        "x := x * 10.0; d := LrealIsFinite(x) OR FLOATIsFinite(x); e := LrealIsNaN(x);",
    )
    assert [bench[name] for name in "abcde"] == [True, False, True, False, False]


def test_constants_of_a_library_have_its_name_in_front_or_that_of_its_list() -> None:
    bench = ran(
        "pi : LREAL; a, b, c : TIME; same : BOOL;",
        "pi := Tc2_System.PI; a := Tc2_System.Global_Variables.DEFAULT_ADS_TIMEOUT;"
        "b := Global_Variables.DEFAULT_ADS_TIMEOUT; c := Tc2_System.DEFAULT_ADS_TIMEOUT;"
        "same := a = b AND b = c AND c = T#5s;",
    )
    assert (bench["pi"], bench["same"]) == (3.141592653589793, True)


def test_memory_of_a_manager_and_a_buffer() -> None:
    bench = ran(
        "m : FB_DynMem_Manager2; b : FB_DynMem_Buffer(ipMemMan := m); p : POINTER TO LREAL; x : LREAL;ok, none : BOOL;",
        "ok := b.CreateBuffer(80, TRUE); p := b.pBuffer; p[9] := 2.5; ok := ok AND b.Resize(160, TRUE, TRUE);"
        "p := b.pBuffer; x := p[9]; b.DeleteBuffer(); none := NOT b.bAvailable;",
    )
    assert [bench[name] for name in ("ok", "x", "none")] == [True, 2.5, True]


def test_numbers_by_chance_are_the_same_for_a_seed_and_even() -> None:
    bench = ran(
        "a, b : DRAND; n : INT; sum : LREAL; differ : BOOL;",
        "FOR n := 1 TO 1000 DO a(Seed := 7); b(Seed := 7);"
        "differ := differ OR a.Num <> b.Num; sum := sum + a.Num; END_FOR;",
    )
    assert bench["differ"] is False
    assert 450 < float(bench["sum"]) < 550


@pytest.mark.parametrize(
    ("expression", "expected"),
    [
        ("DT_TO_STRING(DT#1970-01-01-00:00:00)", "DT#1970-01-01-00:00:00"),
        ("REAL_TO_STRING(1.5E20)", "1.5E20"),
        ("TIME_TO_STRING(T#15d10s)", "T#15d10s"),
        ("TO_STRING(T#1h5ms)", "T#1h5ms"),
        ("TIME_TO_STRING(T#0s)", "T#0ms"),
        ("LREAL_TO_STRING(2E-7)", "2.0E-7"),
        ("F_RTrim('ab  ')", "ab"),
        ("F_LTrim('  ab')", "ab"),
        ("F_ToUCase('aZ1')", "AZ1"),
        ("DWORD_TO_HEXSTR(16#1F, 4, FALSE)", "001F"),
        ("LREAL_TO_FMTSTR(2.345, 1, TRUE)", "2.3"),
    ],
)
def test_texts(expression: str, expected: str) -> None:
    assert ran("s : STRING;", f"s := {expression};")["s"] == expected


def test_bytes_are_copied_within_one_area() -> None:
    bench = ran(
        "a, b : ARRAY[0..3] OF INT := [1, 2, 3, 4];",
        "MEMCPY(ADR(a[1]), ADR(a[0]), 6); MEMMOVE(ADR(b[0]), ADR(b[1]), 6);",
    )
    assert [bench[f"a[{n}]"] for n in range(4)] == [1, 1, 2, 3]
    assert [bench[f"b[{n}]"] for n in range(4)] == [2, 3, 4, 4]


def test_addresses_of_ads_and_what_pointers_point_to() -> None:
    bench = ran(
        "n : T_AmsNetIdArr; s : T_AmsNetId; r : REAL := 2.5; x : REAL; t : STRING := 'ab'; u : STRING; a : UXINT;",
        "n := F_ScanAmsNetIds('192.168.1.2.1.1'); s := F_CreateAmsNetId(n); x := PREAL_TO_REAL(ADR(r));"
        "u := PSTRING_TO_STRING(ADR(t)); a := SIZEOF(a);",
    )
    assert [bench["n[0]"], bench["n[5]"], bench["s"], bench["x"]] == [192, 1, "192.168.1.2.1.1", 2.5]
    assert [bench["u"], bench["a"]] == ["ab", 4]


def test_parts_of_texts_are_replaced_as_long_as_there_is_room() -> None:
    bench = ran(
        "s : STRING := 'a-b-c'; dash : STRING := '-'; plus : STRING := '++'; all, none : STRING; few : STRING(3);"
        "fits, deleted, cut : BOOL;",
        "fits := FindAndReplace(ADR(s), ADR(dash), ADR(plus), ADR(all), SIZEOF(all));"
        "deleted := FindAndDelete(ADR(s), ADR(dash), ADR(none), SIZEOF(none));"
        "cut := NOT FindAndReplace(ADR(s), ADR(dash), ADR(plus), ADR(few), SIZEOF(few));",
    )
    assert [bench[name] for name in ("all", "none", "few")] == ["a++b++c", "abc", "a++"]
    assert [bench[name] for name in ("fits", "deleted", "cut")] == [True, True, True]


def test_halves_of_numbers_of_64_bits() -> None:
    bench = ran(
        "a : T_ULARGE_INTEGER := (dwLowPart := 1, dwHighPart := 1); b : T_ULARGE_INTEGER := (dwLowPart := 2);"
        "d, e : T_ULARGE_INTEGER; x : LREAL; c : DINT; bytes : ARRAY[0..255] OF BYTE; s : T_MaxString;",
        "d := UInt64Sub64(a, b); e := UInt64Add64(d, b); x := UINT64_TO_LREAL(a); c := UInt64Cmp64(b, a);"
        "bytes := MAXSTRING_TO_BYTEARR('ab'); s := BYTEARR_TO_MAXSTRING(bytes);",
    )
    assert [bench["d.dwLowPart"], bench["d.dwHighPart"]] == [0xFFFFFFFF, 0]
    assert [bench["e.dwLowPart"], bench["e.dwHighPart"], bench["x"], bench["c"]] == [1, 1, 4294967297.0, -1]
    assert [bench["bytes[1]"], bench["s"]] == [0x62, "ab"]


@pytest.mark.parametrize(
    ("block", "given", "busy", "error", "number"),
    [
        ("ADSREAD", "READ", "BUSY", "ERR", "ERRID"),
        ("ADSWRITE", "WRITE", "BUSY", "ERR", "ERRID"),
        ("ADSRDWRT", "WRTRD", "BUSY", "ERR", "ERRID"),
        *((f"FB_Ec{name}", "bExecute", "bBusy", "bError", "nErrId") for name in (
            "GetSlaveState", "SetSlaveState", "ReqSlaveState", "GetMasterState", "CoESdoRead", "CoESdoWrite"
        )),
    ],
)  # fmt: skip
def test_a_question_by_ads_finds_no_machine(block: str, given: str, busy: str, error: str, number: str) -> None:
    text = program(
        f"f : {block}; ask, b, e : BOOL; n : UDINT;", f"f({given} := ask, {busy} => b, {error} => e, {number} => n);"
    )
    bench = IecBench(text, CODESYS)
    seen = []
    for ask in (False, True, True, True, False, True, False):
        bench["ask"] = ask
        bench.cycle()
        seen.append((bench["b"], bench["e"], bench["n"]))
    idle, working, wrong = (False, False, 0), (True, False, 0), (False, True, 7)
    assert seen == [idle, working, wrong, wrong, idle, working, wrong]


@pytest.mark.parametrize("kind", ["BYTE", "WORD", "DWORD", "LWORD"])
@pytest.mark.parametrize(
    ("name", "form"), [("BIN", "b"), ("OCT", "o"), ("DEC", "d"), ("HEX", "X")]
)  # those of Python are the same
def test_digits_of_bit_strings_have_zeros_in_front_up_to_the_precision(kind: str, name: str, form: str) -> None:
    case = ", bLoCase := FALSE" if name == "HEX" else ""
    text = program(
        f"in : {kind}; s, t, none : STRING(80);",
        f"s := {kind}_TO_{name}STR(in := in, iPrecision := 12{case});"
        f"t := {kind}_TO_{name}STR(in := in, iPrecision := 1{case});"
        f"none := {kind}_TO_{name}STR(in := 0, iPrecision := 0{case});",
    )
    bench = IecBench(text, CODESYS)
    size = {"BYTE": 8, "WORD": 16, "DWORD": 32, "LWORD": 64}[kind]
    for value in (0, 1, 171, 2**size - 1):
        bench["in"] = value
        bench.cycle()
        assert (bench["s"], bench["t"], bench["none"]) == (f"{value:012{form}}", f"{value:{form}}", "")


@pytest.mark.parametrize(
    ("digit", "value"), [("0", 0), ("9", 9), ("A", 10), ("f", 15), ("G", 255), ("/", 255), ("`", 255)]
)
def test_hexadecimal_digits_have_values(tmp_path: Path, digit: str, value: int) -> None:
    body = (
        f"ASSERT_EQ(HEXCHRNIBBLE_TO_BYTE('{digit}'), {value}); ASSERT_EQ(HEXASCNIBBLE_TO_BYTE({ord(digit)}), {value});"
    )
    assert one(tmp_path, body, dialect="codesys").verdict is Verdict.PASSED


def test_persistent_data_are_written_in_one_call(tmp_path: Path) -> None:
    body = """VAR w : WritePersistentData; END_VAR
w(START := TRUE); ASSERT_TRUE(w.BUSY); w(START := TRUE); ASSERT_FALSE(w.BUSY OR w.ERR);"""
    assert one(tmp_path, body, dialect="codesys").verdict is Verdict.PASSED


PID = program(
    "pid : FB_BasicPID; w, y, cycle : LREAL := 0.1; kp : LREAL := 2; tn, tv, td : LREAL; reset : BOOL; fault : UINT;",
    "pid(fSetpointValue := w, fActualValue := 0, bReset := reset, fCtrlCycleTime := cycle, fKp := kp, fTn := tn,"
    " fTv := tv, fTd := td, fCtrlOutput => y, nErrorStatus => fault);",
)


def pid(steps: int = 1, **inputs: float | bool) -> IecBench:
    bench = IecBench(PID, CODESYS)
    for name, value in {"w": 1.0, **inputs}.items():
        bench[name] = value
    for _ in range(steps):
        bench.cycle()
    return bench


@pytest.mark.parametrize(
    ("inputs", "steps", "expected"),
    [
        ({}, 5, 2.0),  # only P
        ({"tn": 4.0}, 100, 2.0 + 2.0 * 100 * 0.1 / 4.0),  # a ramp of Kp * t / Tn
        ({"tv": 0.5}, 1, 2.0 + 2.0 * 0.5 / 0.1),  # the whole step within one cycle
        ({"tv": 0.5}, 2, 2.0),
        ({"tv": 0.5, "td": 0.1}, 1, 2.0 + 2.0 * 0.5 / 0.2),
        ({"tv": 0.5, "td": 0.1}, 200, 2.0),
        ({"kp": 0.0, "tn": 1.0, "tv": 1.0}, 9, 0.0),
    ],
)
def test_the_controller_answers_a_step_as_its_transfer_function(
    inputs: dict[str, float], steps: int, expected: float
) -> None:
    bench = pid(steps, **inputs)
    assert float(bench["y"]) == pytest.approx(expected)
    assert bench["fault"] == 0


@pytest.mark.parametrize(
    ("inputs", "fault"),
    [
        ({"tn": -1.0}, 1),
        ({"tv": -0.1}, 1),
        ({"td": -0.1}, 1),
        ({"cycle": 0.0}, 2),
        ({"cycle": -1.0}, 2),
    ],
)
def test_the_controller_names_a_wrong_setting_and_begins_again(inputs: dict[str, float], fault: int) -> None:
    bench = pid(3, tn=1.0)
    assert float(bench["y"]) > 2.0
    for name, value in inputs.items():
        bench[name] = value
    bench.cycle()
    assert (bench["y"], bench["fault"]) == (0.0, fault)
    for name in inputs:
        bench[name] = {"cycle": 0.1, "tn": 1.0}.get(name, 0.0)
    bench.cycle()
    assert float(bench["y"]) == pytest.approx(2.2)
    assert bench["fault"] == 0


def test_the_controller_begins_again_at_a_reset() -> None:
    bench = pid(50, tn=1.0)
    bench["reset"] = True
    bench.cycle()
    assert bench["y"] == 0.0
    bench["reset"] = False
    bench.cycle()
    assert float(bench["y"]) == pytest.approx(2.2)
