"""The standard function blocks against the timing diagrams of IEC 61131-3 and the descriptions of util.lib.

A row is a call: its time in ms, the inputs that change before it, and the outputs after it.
"""

import math
import re
from collections.abc import Callable, Mapping

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from library_bench import Bench

from fieldrig_devices.iec.dialect import CODESYS, EDITION_3, EPAS_4, Dialect
from fieldrig_devices.iec.elementary import Elementary
from fieldrig_devices.iec.library.sources import sources
from fieldrig_devices.iec.types import Value

Row = tuple[int, Mapping[str, Value], Mapping[str, Value]]

TIMES: list[tuple[str, list[Row]]] = [
    (
        "TON",
        [
            (0, {"IN": False, "PT": 500}, {"Q": False, "ET": 0}),
            (100, {"IN": True}, {"Q": False, "ET": 0}),
            (300, {}, {"Q": False, "ET": 200}),
            (599, {}, {"Q": False, "ET": 499}),
            (600, {}, {"Q": True, "ET": 500}),
            (900, {}, {"Q": True, "ET": 500}),
            (901, {"IN": False}, {"Q": False, "ET": 0}),
            (1000, {"IN": True}, {"Q": False, "ET": 0}),
            (1300, {}, {"Q": False, "ET": 300}),
            (1301, {"IN": False}, {"Q": False, "ET": 0}),  # too short
            (1400, {"IN": True}, {"Q": False, "ET": 0}),
            (9999, {}, {"Q": True, "ET": 500}),
        ],
    ),
    ("TON", [(5, {"IN": True, "PT": 0}, {"Q": True, "ET": 0})]),
    (
        "TOF",
        [
            (0, {"IN": False, "PT": 500}, {"Q": False, "ET": 0}),
            (100, {"IN": True}, {"Q": True, "ET": 0}),
            (400, {}, {"Q": True, "ET": 0}),
            (500, {"IN": False}, {"Q": True, "ET": 0}),
            (999, {}, {"Q": True, "ET": 499}),
            (1000, {}, {"Q": False, "ET": 500}),
            (2000, {}, {"Q": False, "ET": 500}),
            (2100, {"IN": True}, {"Q": True, "ET": 0}),
            (2200, {"IN": False}, {"Q": True, "ET": 0}),
            (2500, {}, {"Q": True, "ET": 300}),
            (2600, {"IN": True}, {"Q": True, "ET": 0}),  # on again before the delay has passed
            (2700, {"IN": False}, {"Q": True, "ET": 0}),
            (3199, {}, {"Q": True, "ET": 499}),
            (3200, {}, {"Q": False, "ET": 500}),
        ],
    ),
    (
        "TP",
        [
            (0, {"IN": False, "PT": 500}, {"Q": False, "ET": 0}),
            (100, {"IN": True}, {"Q": True, "ET": 0}),
            (599, {}, {"Q": True, "ET": 499}),
            (600, {}, {"Q": False, "ET": 500}),
            (900, {}, {"Q": False, "ET": 500}),
            (901, {"IN": False}, {"Q": False, "ET": 0}),
            (1000, {"IN": True}, {"Q": True, "ET": 0}),
            (1100, {"IN": False}, {"Q": True, "ET": 100}),  # the pulse goes on
            (1200, {"IN": True}, {"Q": True, "ET": 200}),  # and a second edge does not make it longer
            (1300, {"IN": False}, {"Q": True, "ET": 300}),
            (1500, {}, {"Q": False, "ET": 0}),
            (1501, {"IN": True}, {"Q": True, "ET": 0}),
        ],
    ),
    (
        "RTC",
        [
            (0, {"EN": False, "PDT": 887_379_600}, {"Q": False, "CDT": 0}),
            (500, {"EN": True}, {"Q": True, "CDT": 887_379_600}),
            (1499, {}, {"Q": True, "CDT": 887_379_600}),
            (1500, {}, {"Q": True, "CDT": 887_379_601}),
            (1900, {}, {"Q": True, "CDT": 887_379_601}),
            (62_500, {}, {"Q": True, "CDT": 887_379_662}),
            (63_000, {"EN": False}, {"Q": False, "CDT": 0}),
        ],
    ),
    (
        "BLINK",
        [
            (0, {"ENABLE": False, "TIMELOW": 100, "TIMEHIGH": 300}, {"OUT": False}),
            (10, {"ENABLE": True}, {"OUT": True}),
            (309, {}, {"OUT": True}),
            (310, {}, {"OUT": False}),
            (409, {}, {"OUT": False}),
            (415, {}, {"OUT": True}),
            (709, {}, {"OUT": True}),
            (710, {}, {"OUT": False}),  # a late call does not move the edges
            (720, {"ENABLE": False}, {"OUT": False}),
            (999, {}, {"OUT": False}),
        ],
    ),
]

STEPS: list[tuple[str, list[tuple[Mapping[str, Value], Mapping[str, Value]]]]] = [
    (
        "R_TRIG",
        [
            ({"CLK": False}, {"Q": False}),
            ({"CLK": True}, {"Q": True}),
            ({}, {"Q": False}),
            ({"CLK": False}, {"Q": False}),
            ({"CLK": True}, {"Q": True}),
        ],
    ),
    (
        "F_TRIG",
        [
            ({"CLK": True}, {"Q": False}),
            ({"CLK": False}, {"Q": True}),
            ({}, {"Q": False}),
            ({"CLK": True}, {"Q": False}),
            ({"CLK": False}, {"Q": True}),
        ],
    ),
    ("F_TRIG", [({"CLK": False}, {"Q": True}), ({}, {"Q": False})]),  # the first call of all, as in the standard
    (
        "SEMA",
        [
            ({"CLAIM": True}, {"BUSY": False}),
            ({}, {"BUSY": True}),
            ({"CLAIM": False}, {"BUSY": True}),
            ({"RELEASE": True}, {"BUSY": False}),
            ({"RELEASE": False}, {"BUSY": False}),
        ],
    ),
    (
        "HYSTERESIS",
        [
            ({"IN": 50, "LOW": 20, "HIGH": 80}, {"OUT": False}),
            ({"IN": 20}, {"OUT": False}),
            ({"IN": 19}, {"OUT": True}),
            ({"IN": 80}, {"OUT": True}),
            ({"IN": 81}, {"OUT": False}),
            ({"IN": 50}, {"OUT": False}),
        ],
    ),
    (
        "LIMITALARM",
        [
            ({"IN": 50, "LOW": 20, "HIGH": 80}, {"O": False, "U": False, "IL": True}),
            ({"IN": 81}, {"O": True, "U": False, "IL": False}),
            ({"IN": 19}, {"O": False, "U": True, "IL": False}),
        ],
    ),
    (
        "STATISTICS_INT",
        [
            ({"IN": 10}, {"MN": 10, "MX": 10, "AVG": 10}),
            ({"IN": -20}, {"MN": -20, "MX": 10, "AVG": -5}),
            ({"IN": 40}, {"MN": -20, "MX": 40, "AVG": 10}),
            ({"RESET": True}, {"MN": 32767, "MX": -32768, "AVG": 0}),
        ],
    ),
    (
        "STATISTICS_REAL",
        [
            ({"IN": 1.0}, {"MN": 1.0, "MX": 1.0, "AVG": 1.0}),
            ({"IN": 2.0}, {"MN": 1.0, "MX": 2.0, "AVG": 1.5}),
            ({"IN": 6.0}, {"MN": 1.0, "MX": 6.0, "AVG": 3.0}),
        ],
    ),
    ("VARIANCE", [({"IN": 2.0}, {"OUT": 0.0}), ({"IN": 4.0}, {"OUT": 1.0}), ({"IN": 6.0}, {"OUT": 8 / 3})]),
    (
        "UNPACK",
        [({"B": 0b1000_0101}, {"B0": True, "B1": False, "B2": True, "B3": False, "B6": False, "B7": True})],
    ),
    (
        "RAMP_INT",
        [
            ({"IN": 25, "ASCEND": 10, "DESCEND": 20}, {"OUT": 10}),
            ({}, {"OUT": 20}),
            ({}, {"OUT": 25}),
            ({"IN": -5}, {"OUT": 5}),
            ({}, {"OUT": -5}),
            ({"RESET": True}, {"OUT": 0}),
        ],
    ),
    (
        "LIN_TRAFO",
        [
            (
                {"IN": 5.0, "IN_MIN": 0.0, "IN_MAX": 10.0, "OUT_MIN": 100.0, "OUT_MAX": 200.0},
                {"OUT": 150.0, "ERROR": False},
            ),
            ({"IN": 11.0}, {"OUT": 150.0, "ERROR": True}),
            ({"IN": 10.0}, {"OUT": 200.0, "ERROR": False}),
            ({"IN_MIN": 10.0}, {"OUT": 200.0, "ERROR": True}),
        ],
    ),
]

# The same rows with the names of CoDeSys and with those of edition 3.
NAMES = {EPAS_4.name: {}, EDITION_3.name: {"RESET": "R", "LOAD": "LD", "SET1": "S1", "SET": "S", "RESET1": "R1"}}
COUNTS: list[tuple[str, list[tuple[Mapping[str, Value], Mapping[str, Value]]]]] = [
    (
        "CTU",
        [
            ({"PV": 2}, {"Q": False, "CV": 0}),
            ({"CU": True}, {"Q": False, "CV": 1}),
            ({}, {"Q": False, "CV": 1}),
            ({"CU": False}, {"Q": False, "CV": 1}),
            ({"CU": True}, {"Q": True, "CV": 2}),
            ({"CU": False}, {"Q": True, "CV": 2}),
            ({"CU": True}, {"Q": True, "CV": 3}),
            ({"RESET": True}, {"Q": False, "CV": 0}),
            ({"RESET": False}, {"Q": False, "CV": 0}),
        ],
    ),
    (
        "CTD",
        [
            ({"PV": 2, "LOAD": True}, {"Q": False, "CV": 2}),
            ({"LOAD": False, "CD": True}, {"Q": False, "CV": 1}),
            ({}, {"Q": False, "CV": 1}),
            ({"CD": False}, {"Q": False, "CV": 1}),
            ({"CD": True}, {"Q": True, "CV": 0}),
            ({"CD": False}, {"Q": True, "CV": 0}),
            ({"CD": True}, {"Q": True, "CV": 0}),
        ],
    ),
    (
        "CTUD",
        [
            ({"PV": 2}, {"QU": False, "QD": True, "CV": 0}),
            ({"CU": True}, {"QU": False, "QD": False, "CV": 1}),
            ({"CU": False}, {"QU": False, "QD": False, "CV": 1}),
            ({"CU": True}, {"QU": True, "QD": False, "CV": 2}),
            ({"CD": True}, {"QU": False, "QD": False, "CV": 1}),
            ({"CU": False, "CD": False}, {"CV": 1}),
            ({"CU": True, "CD": True}, {"CV": 1}),
            ({"LOAD": True}, {"QU": True, "CV": 2}),
            ({"RESET": True}, {"QD": True, "CV": 0}),
        ],
    ),
    (
        "SR",
        [
            ({}, {"Q1": False}),
            ({"SET1": True}, {"Q1": True}),
            ({"RESET": True}, {"Q1": True}),
            ({"SET1": False}, {"Q1": False}),
            ({"RESET": False}, {"Q1": False}),
        ],
    ),
    (
        "RS",
        [
            ({}, {"Q1": False}),
            ({"SET": True}, {"Q1": True}),
            ({"RESET1": True}, {"Q1": False}),
            ({"RESET1": False}, {"Q1": True}),
            ({"SET": False}, {"Q1": True}),
            ({"RESET1": True}, {"Q1": False}),
        ],
    ),
]


def bench_for(block: str, dialect: Dialect = EPAS_4) -> Bench:
    return Bench(f"PROGRAM PLC_PRG\nVAR\n    b : {block};\nEND_VAR\nb();\nEND_PROGRAM\n", dialect)


def check(bench: Bench, at_ms: int, inputs: Mapping[str, Value], outputs: Mapping[str, Value]) -> None:
    for name, value in inputs.items():
        bench.write(f"PLC_PRG.b.{name}", value)
    bench.call(at_ms)
    found = {name: bench.read(f"PLC_PRG.b.{name}") for name in outputs}
    assert found == pytest.approx(dict(outputs), rel=1e-6), f"at {at_ms} ms"


@pytest.mark.manual("PD-200")
@pytest.mark.parametrize(("block", "table"), TIMES, ids=lambda part: part if isinstance(part, str) else "")
def test_timing_diagram(block: str, table: list[Row]) -> None:
    bench = bench_for(block)
    for at_ms, inputs, outputs in table:
        check(bench, at_ms, inputs, outputs)


@pytest.mark.parametrize(("block", "table"), STEPS, ids=lambda part: part if isinstance(part, str) else "")
def test_calls_one_after_the_other(block: str, table: list[tuple[Mapping[str, Value], Mapping[str, Value]]]) -> None:
    bench = bench_for(block)
    for number, (inputs, outputs) in enumerate(table):
        check(bench, number * 10, inputs, outputs)


@pytest.mark.parametrize("dialect", [EPAS_4, EDITION_3], ids=lambda dialect: dialect.name)
@pytest.mark.parametrize(("block", "table"), COUNTS, ids=lambda part: part if isinstance(part, str) else "")
def test_counters_and_bistables(
    block: str, table: list[tuple[Mapping[str, Value], Mapping[str, Value]]], dialect: Dialect
) -> None:
    bench = bench_for(block, dialect)
    for number, (inputs, outputs) in enumerate(table):
        named = {NAMES[dialect.name].get(name, name): value for name, value in inputs.items()}
        check(bench, number * 10, named, outputs)


@pytest.mark.parametrize(
    ("dialect", "block", "greatest"),
    [
        (EPAS_4, "CTU", 65_535),
        (EDITION_3, "CTU", 32_767),
        (EDITION_3, "CTU_DINT", 2**31 - 1),
        (EDITION_3, "CTUD_UDINT", 2**32 - 1),
        (EDITION_3, "CTU_LINT", 2**63 - 1),
        (EDITION_3, "CTUD_ULINT", 2**64 - 1),
    ],
)
def test_a_counter_stops_at_the_end_of_its_type(dialect: Dialect, block: str, greatest: int) -> None:
    bench = bench_for(block, dialect)
    bench.write("PLC_PRG.b.CV", greatest - 1)
    for number in range(4):
        check(bench, number, {"CU": True}, {})
        check(bench, number, {"CU": False}, {})
    assert bench.read("PLC_PRG.b.CV") == greatest


def test_a_timer_runs_over_the_end_of_the_clock() -> None:
    bench = bench_for("TON")
    check(bench, 2**32 - 100, {"IN": True, "PT": 500}, {"Q": False, "ET": 0})
    check(bench, 2**32 + 399, {}, {"Q": False, "ET": 499})
    check(bench, 2**32 + 400, {}, {"Q": True, "ET": 500})


DAY_MS = 86_400_000
MS_NS = 1_000_000


@pytest.mark.parametrize(("dialect", "form"), [(EDITION_3, "{}_LTIME"), (CODESYS, "L{}")], ids=["edition-3", "codesys"])
def test_timers_for_ltime_count_nanoseconds_for_any_number_of_days(dialect: Dialect, form: str) -> None:
    pt = 60 * DAY_MS * MS_NS
    on, off, pulse = (bench_for(form.format(block), dialect) for block in ("TON", "TOF", "TP"))
    check(on, 10, {"IN": True, "PT": pt}, {"Q": False, "ET": 0})
    check(on, 10 + 50 * DAY_MS, {}, {"Q": False, "ET": 50 * DAY_MS * MS_NS})
    check(on, 10 + 60 * DAY_MS, {}, {"Q": True, "ET": pt})
    check(off, 10, {"IN": True, "PT": pt}, {"Q": True, "ET": 0})
    check(off, 20, {"IN": False}, {"Q": True, "ET": 0})
    check(off, 20 + 60 * DAY_MS - 1, {}, {"Q": True, "ET": pt - MS_NS})
    check(off, 20 + 60 * DAY_MS, {}, {"Q": False, "ET": pt})
    check(pulse, 10, {"IN": True, "PT": pt}, {"Q": True, "ET": 0})
    check(pulse, 10 + 60 * DAY_MS, {"IN": False}, {"Q": False, "ET": 0})


def test_edition_3_names_timers_by_their_type_too() -> None:
    bench = bench_for("TON_TIME", EDITION_3)
    check(bench, 0, {"IN": True, "PT": 500}, {"Q": False, "ET": 0})
    check(bench, 500, {}, {"Q": True, "ET": 500})


# ---- util.lib

PERIOD_MS = 1_000
FORMS: list[tuple[int, Callable[[float], float]]] = [
    (0, lambda phase: 1 - 4 * abs((phase + 0.25) % 1 - 0.5)),
    (1, lambda phase: 1 - 2 * abs(phase - 0.5)),
    (2, lambda phase: 2 * phase - 1),
    (3, lambda phase: 1 - 2 * phase),
    (4, lambda phase: 1 if phase < 0.5 else -1),
    (5, lambda phase: math.sin(2 * math.pi * phase)),
    (6, lambda phase: math.cos(2 * math.pi * phase)),
]


@pytest.mark.parametrize(("mode", "form"), FORMS)
def test_generator_by_time(mode: int, form: Callable[[float], float]) -> None:
    bench = bench_for("GEN")
    for name, value in {"MODE": mode, "BASE": True, "PERIOD": PERIOD_MS, "AMPLITUDE": 1000}.items():
        bench.write(f"PLC_PRG.b.{name}", value)
    for at_ms in range(0, 2_500, 50):
        bench.call(7 + at_ms)
        assert bench.read("PLC_PRG.b.OUT") == pytest.approx(1000 * form(at_ms % PERIOD_MS / PERIOD_MS), abs=1.01)


def test_generator_by_calls() -> None:
    bench = bench_for("GEN")
    for name, value in {"MODE": 2, "BASE": False, "CYCLES": 4, "AMPLITUDE": 100}.items():
        bench.write(f"PLC_PRG.b.{name}", value)
    outputs = []
    for _ in range(6):
        bench.call(0)
        outputs.append(bench.read("PLC_PRG.b.OUT"))
    assert outputs == [-100, -50, 0, 50, -100, -50]


def test_integral_of_a_straight_line_is_exact() -> None:
    bench = bench_for("INTEGRAL")
    bench.write("PLC_PRG.b.TM", 100)
    for number in range(21):
        bench.write("PLC_PRG.b.IN", 3.0 * number / 10)  # 3 per second
        bench.call(number * 100)
    assert bench.read("PLC_PRG.b.OUT") == pytest.approx(3 * 2.0**2 / 2, rel=1e-6)
    assert bench.read("PLC_PRG.b.OVERFLOW") is False


def test_integral_stops_when_it_overflows() -> None:
    bench = bench_for("INTEGRAL")
    check(bench, 0, {"IN": 3e38, "TM": 5_000}, {"OUT": 0.0, "OVERFLOW": False})
    check(bench, 0, {}, {"OVERFLOW": True})
    check(bench, 0, {"IN": 0.0}, {"OUT": 0.0, "OVERFLOW": True})
    check(bench, 0, {"RESET": True}, {"OUT": 0.0, "OVERFLOW": False})


def test_derivative_of_a_straight_line_is_its_slope() -> None:
    bench = bench_for("DERIVATIVE")
    bench.write("PLC_PRG.b.TM", 20)
    for number in range(6):
        bench.write("PLC_PRG.b.IN", 5.0 - 0.1 * number)
        bench.call(number * 20)
    assert bench.read("PLC_PRG.b.OUT") == pytest.approx(-5.0, rel=1e-5)


def test_ramp_by_time() -> None:
    bench = bench_for("RAMP_REAL")
    settings: dict[str, Value] = {"IN": 100.0, "ASCEND": 10.0, "DESCEND": 50.0, "TIMEBASE": 1_000}
    check(bench, 0, settings, {"OUT": 0.0})
    check(bench, 500, {}, {"OUT": 5.0})
    check(bench, 2_000, {}, {"OUT": 20.0})
    check(bench, 2_100, {"IN": 0.0}, {"OUT": 15.0})
    check(bench, 9_999, {}, {"OUT": 0.0})


@pytest.mark.manual("PD-210")
def test_pid_step_response_is_the_formula() -> None:
    bench = bench_for("PID")
    settings: dict[str, Value] = {"KP": 2.0, "TN": 4.0, "TV": 0.0, "SET_POINT": 10.0, "ACTUAL": 7.0, "Y_OFFSET": 1.0}
    check(bench, 0, settings, {"Y": 1.0 + 2.0 * 3.0, "LIMITS_ACTIVE": False})
    check(bench, 1_000, {}, {"Y": 1.0 + 2.0 * (3.0 + 3.0 * 1.0 / 4.0)})
    check(bench, 3_000, {}, {"Y": 1.0 + 2.0 * (3.0 + 3.0 * 3.0 / 4.0)})


def test_pid_holds_its_integral_at_the_limit() -> None:
    bench = bench_for("PID")
    settings: dict[str, Value] = {"KP": 1.0, "TN": 1.0, "SET_POINT": 10.0, "Y_MIN": -5.0, "Y_MAX": 5.0}
    check(bench, 0, settings, {"Y": 5.0, "LIMITS_ACTIVE": True})
    check(bench, 60_000, {}, {"Y": 5.0, "LIMITS_ACTIVE": True})
    check(bench, 60_001, {"ACTUAL": 8.0}, {"Y": 2.0, "LIMITS_ACTIVE": False})
    check(bench, 60_002, {"MANUAL": True, "Y_MANUAL": 3.0}, {"Y": 3.0})
    check(bench, 60_003, {"MANUAL": False, "RESET": True, "Y_OFFSET": -1.0}, {"Y": -1.0})


def test_pd_follows_the_slope() -> None:
    bench = bench_for("PD")
    settings: dict[str, Value] = {"KP": 2.0, "TV": 0.5}
    for number in range(6):
        bench.write("PLC_PRG.b.SET_POINT", 4.0 * number / 10)  # 4 per second
        for name, value in settings.items():
            bench.write(f"PLC_PRG.b.{name}", value)
        bench.call(number * 100)
    assert bench.read("PLC_PRG.b.Y") == pytest.approx(2.0 * (2.0 + 0.5 * 4.0), rel=1e-5)


CURVE = """PROGRAM PLC_PRG
VAR
    b : CHARCURVE;
    P : ARRAY[0..10] OF POINT := (X := -100, Y := 0), (X := 0, Y := 50), (X := 100, Y := 250), 8((X := 0, Y := 0));
END_VAR
b(P := P);
END_PROGRAM
"""


@pytest.mark.parametrize(
    ("value", "count", "out", "error"),
    [
        (-100, 3, 0, 0),
        (-50, 3, 25, 0),
        (0, 3, 50, 0),
        (30, 3, 110, 0),
        (100, 3, 250, 0),
        (101, 3, 250, 2),
        (-101, 3, 0, 2),
        (0, 1, 0, 4),
        (0, 12, 0, 4),
        (0, 5, 0, 1),
    ],
)
def test_curve(value: int, count: int, out: int, error: int) -> None:
    bench = Bench(CURVE)
    bench.write("PLC_PRG.b.IN", value)
    bench.write("PLC_PRG.b.N", count)
    bench.call(0)
    assert (bench.read("PLC_PRG.b.OUT"), bench.read("PLC_PRG.b.ERR")) == (out, error)


# ---- every block with every input


def _pins(text: str) -> dict[str, list[tuple[str, str]]]:
    """Names and types of the inputs of each block in a source text."""
    found = {}
    for name, body in re.findall(r"^FUNCTION_BLOCK (\w+)$(.*?)^END_FUNCTION_BLOCK", text, re.MULTILINE | re.DOTALL):
        (inputs,) = re.findall(r"^VAR_INPUT$(.*?)^END_VAR", body, re.MULTILINE | re.DOTALL)
        found[name] = re.findall(r"^    (\w+) : (\w+)", inputs, re.MULTILINE)
    return found


PINS = {name: pins for _, text in sources(EPAS_4.name) for name, pins in _pins(text).items()}
VALUES: dict[str, st.SearchStrategy[Value]] = {
    "BOOL": st.booleans(),
    "REAL": st.floats(width=32) | st.sampled_from([0.0, 1.0, -1.0]),
    "GEN_MODE": st.integers(0, 6),
    **{
        name: st.integers(Elementary[name].low, Elementary[name].high) | st.integers(0, 3)
        for name in ("INT", "WORD", "BYTE", "DWORD", "TIME", "DT")
    },
}
ALL = "".join(
    [
        "PROGRAM PLC_PRG\nVAR\n    P : ARRAY[0..10] OF POINT;\n",
        *(f"    b_{name} : {name};\n" for name in PINS),
        "END_VAR\n",
        *(f"b_{name}({'P := P' if name == 'CHARCURVE' else ''});\n" for name in PINS),
        "END_PROGRAM\n",
    ]
)


@pytest.fixture(scope="module")
def all_blocks() -> Bench:
    return Bench(ALL)


@pytest.mark.long
@settings(max_examples=300)
@given(st.data())
def test_no_input_of_a_block_is_a_fault(all_blocks: Bench, data: st.DataObject) -> None:
    name = data.draw(st.sampled_from(sorted(PINS)))
    for pin, kind in PINS[name]:
        all_blocks.write(f"PLC_PRG.b_{name}.{pin}", data.draw(VALUES[kind]))
    all_blocks.write("PLC_PRG.P[1].X", data.draw(VALUES["INT"]))
    all_blocks.call_after(data.draw(st.integers(0, 10_000)))
    all_blocks.call_after(0)


def test_times_between_values_do_not_wrap_around() -> None:
    bench = bench_for("DERIVATIVE")
    for at_ms, milliseconds in enumerate((1, 1, 2**31, 2**30, 2**31)):  # 3, 4 and 3 times the last three
        check(bench, at_ms, {"IN": 1.0 * at_ms, "TM": milliseconds}, {})
