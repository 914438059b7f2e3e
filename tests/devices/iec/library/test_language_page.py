"""The pages docs/programs/iec-*.md agree with the code, and their examples run.

A comment (* = 127 *) behind an assignment is the value of the variable after one cycle.
"""

import re
from collections.abc import Iterator
from dataclasses import fields

import pytest
from doc_pages import Block, Row, blocks, code_in, page_named, prose, rows
from library_bench import Bench

from fieldrig_devices.iec.dialect import CODESYS, DIALECTS, EDITION_3, EPAS_4
from fieldrig_devices.iec.elementary import Elementary
from fieldrig_devices.iec.instructions import BRACKETS, CONDITIONAL, NEGATABLE, SPELLINGS
from fieldrig_devices.iec.library.conversions import convert
from fieldrig_devices.iec.library.intrinsics import OPERATORS, formal_names, is_standard
from fieldrig_devices.iec.library.sources import sources
from fieldrig_devices.iec.library.timed import TIMED
from fieldrig_devices.iec.parser.sections import QUALIFIERS
from fieldrig_devices.iec.tasks.task import WorkState
from fieldrig_devices.iec.types import StringType

PAGES = [page_named(f"iec-{name}.md") for name in ("language", "dialects", "types", "functions", "charts", "objects")]
EXAMPLES = [block for page in PAGES for block in blocks(page) if block.info[0] == "iecst"]
TEXT = "".join(page.read_text(encoding="utf-8") for page in PAGES)
WORDS = {word for page in PAGES for word in code_in(prose(page))}
VALUE = re.compile(r"^\s*(?:ST\s+)?(\w+)(?: := .*;)?\s*\(\* = (.+) \*\)$", re.MULTILINE)
SHORT_CIRCUIT = {"AND_THEN", "OR_ELSE"}


def rows_of(heading: str, column: str) -> Iterator[Row]:
    return (row for page in PAGES for row in rows(page) if row.heading == heading and row.columns[0] == column)


@pytest.mark.parametrize("block", EXAMPLES, ids=lambda block: block.info[-1])
def test_example_runs_and_its_values_are_those_in_its_comments(block: Block) -> None:
    bench = Bench(block.text, EDITION_3 if block.info[-1].endswith("-edition-3.st") else EPAS_4)
    bench.call(0)
    for name, value in VALUE.findall(block.text):
        assert bench.read(f"PLC_PRG.{name}") == bench_constant(bench, name, value), f"{block.place}: {name}"


def bench_constant(bench: Bench, name: str, text: str) -> object:
    """The value of a constant in the notation of the language, which a program of its own computes."""
    kind = bench.type_of(f"PLC_PRG.{name}")
    other = Bench(f"PROGRAM PLC_PRG\nVAR x : {kind}; END_VAR\nx := {text};\nEND_PROGRAM\n")
    other.call(0)
    value = other.read("PLC_PRG.x")
    return pytest.approx(value, rel=1e-6) if isinstance(value, float) else value


def test_every_example_with_a_result_is_read() -> None:
    explained = 1  # in the words about these comments
    assert sum(len(VALUE.findall(block.text)) for block in EXAMPLES) == TEXT.count("(* = ") - explained


def test_table_of_types_is_complete_and_right() -> None:
    said = {code_in(row.cells[0])[0]: row.cells[1:4] for row in rows_of("Types", "type")}
    assert said == {
        kind.name: (str(kind.size), str(kind.low), str(kind.high))
        for kind in Elementary
        if not kind.is_real and kind not in (Elementary.SIGNED_TIME, Elementary.UNSIGNED_LDATE, Elementary.UNSIGNED_LDT)
    }


def test_functions_are_known_with_these_names_of_their_inputs() -> None:
    found = set()
    for row in rows_of("Standard functions", "function"):
        for name, arguments in re.findall(r"(\w+)\(([\w, ]*)\)", row.cells[0]):
            names = tuple(argument for argument in arguments.split(", ") if argument)
            assert is_standard(name), name
            assert formal_names(name, len(names)) == names, name
            found.add(name)
    assert {*OPERATORS, "SQRT", "TRUNC", "LEN"} - SHORT_CIRCUIT <= found | WORDS


def test_functions_of_edition_3_are_known() -> None:
    names = {name for name in WORDS if re.fullmatch(r"(ADD|SUB|MUL|DIV|CONCAT)_[A-Z_]+", name)}
    texts = dict(sources(EDITION_3.name))
    parts = texts["dates_edition_3.st"] + texts["dates_ldate.st"]
    dates = set(re.findall(r"^FUNCTION (\w+)", parts, re.MULTILINE))
    assert dates <= {word.partition("(")[0] for word in WORDS}
    assert {name for name in TIMED if re.search(r"_(TIME|DATE_DATE|TOD_TOD|DT_DT)$", name)} <= names | WORDS
    assert all(map(is_standard, names - dates))


def pins(dialect: str) -> dict[str, dict[str, set[str]]]:
    """The pins of all blocks in the source text, by kind."""
    found: dict[str, dict[str, set[str]]] = {}
    for _, text in sources(dialect):
        for name, body in re.findall(r"^FUNCTION_BLOCK (\w+)$(.*?)^END_FUNCTION_BLOCK", text, re.MULTILINE | re.DOTALL):
            kinds = found.setdefault(name, {"in": set(), "out": set()})
            for kind, declared in re.findall(
                r"^VAR_(INPUT|IN_OUT|OUTPUT)$(.*?)^END_VAR", body, re.MULTILINE | re.DOTALL
            ):
                names = re.findall(r"^    (\w+) :", declared, re.MULTILINE)
                kinds["out" if kind == "OUTPUT" else "in"].update(names)
    return found


def test_table_of_blocks_has_every_block_with_its_pins() -> None:
    ours, standard = pins(EPAS_4.name), pins(EDITION_3.name)
    said = list(rows_of("Standard function blocks", "block"))
    large = {name for name in standard if re.fullmatch(r"CT\w+_(U?[DL]INT)", name)}
    timers = {f"{name}_{kind}" for name in ("TON", "TOF", "TP") for kind in ("TIME", "LTIME")}
    assert {name for row in said for name in code_in(row.cells[0])} == set(ours) == set(standard) - large - timers
    assert timers <= set(standard)
    assert {"LTON", "LTOF", "LTP"} <= set(pins(CODESYS.name))
    assert large == {f"{name}_{kind}" for name in ("CTU", "CTD", "CTUD") for kind in ("DINT", "UDINT", "LINT", "ULINT")}
    for row in said:
        inputs = [code_in(part) for part in row.cells[1].split(",")]
        for name in code_in(row.cells[0]):
            assert {pair[0] for pair in inputs} == ours[name]["in"], name
            assert {pair[-1] for pair in inputs} == standard[name]["in"], name
            assert set(code_in(row.cells[2])) == ours[name]["out"], name


def test_table_of_dialects_has_a_row_for_each_difference() -> None:
    said = [row.cells[1:] for row in rows_of("Dialects", "permission")]
    names = [field.name for field in fields(EPAS_4) if field.name != "name"]
    assert said == [tuple(_word(getattr(dialect, name)) for dialect in DIALECTS.values()) for name in names]


def _word(value: bool | int) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    return str(value) if value else "all"


CHOICES = [
    (0.5, Elementary.LREAL, Elementary.INT, 0), (2.5, Elementary.LREAL, Elementary.INT, 2),
    (65_000, Elementary.TIME, StringType(), "T#1m5s"), (3_605_000, Elementary.TIME, StringType(), "T#1h0m5s"),
    (51_600_000, Elementary.TOD, StringType(), "TOD#14:20"), (1.0, Elementary.REAL, StringType(), "1.0"),
    (1e10, Elementary.REAL, StringType(), "1e+10"), ("12x", StringType(), Elementary.INT, 0),
]  # fmt: skip


@pytest.mark.parametrize(("value", "source", "target", "result"), CHOICES)
def test_choices_of_the_last_table(
    value: float | str, source: Elementary | StringType, target: Elementary | StringType, result: object
) -> None:
    assert convert(value, source, target) == result
    if isinstance(result, str):
        assert f"`{result}`" in TEXT


def test_chart_of_the_page_goes_from_step_to_step() -> None:
    (chart,) = (block for block in EXAMPLES if block.info[-1] == "chart.st")
    bench = Bench(chart.text)
    found = []
    for at_ms, is_full in (
        (0, False),
        (10, False),
        (20, False),
        (30, True),
        (40, True),
        (50, False),
        (150, False),
        (160, False),
    ):
        bench.write("PLC_PRG.Full", is_full)
        bench.call(at_ms)
        found.append(tuple(bench.read(f"PLC_PRG.{name}") for name in ("Pump", "Valve", "Fills")))
    assert found == [
        (False, False, 0),  # Wait, whose transition holds
        (True, False, 1),  # Fill: the action Count runs once
        (True, False, 1),
        (True, False, 1),  # full: the transition holds at the end of this cycle
        (False, True, 1),  # Drain, with its entry action
        (False, True, 1),
        (False, False, 1),  # after more than 100 ms: the exit action
        (False, False, 1),  # Wait again
    ]


def test_table_of_instructions_is_complete() -> None:
    said = {word for row in rows_of("Instruction List", "operator") for word in code_in(row.cells[0])} - {")"}
    assert said == {*(operator for operator, _, _ in SPELLINGS.values()), "&"}
    for row in rows_of("Instruction List", "operator"):
        for word in set(code_in(row.cells[0])) - {")", "&"}:
            marks = {"N"} if word in NEGATABLE else {"C", "CN"} if word in CONDITIONAL else set()
            assert set(code_in(row.cells[1])) == marks | ({"("} if word in BRACKETS else set()), word


def test_table_of_qualifiers_is_complete() -> None:
    said = {word for row in rows_of("Sequential Function Charts", "qualifier") for word in code_in(row.cells[0])}
    assert said == QUALIFIERS


FAULTS = [
    ("a : INT; b : INT := 1;", "b := b / a;"),
    ("a : INT; b : INT := 1;", "b := b MOD a;"),
    ("a : REAL; b : REAL := 1.0;", "b := b / a;"),
    ("a : INT; b : ARRAY[1..3] OF INT;", "b[a] := 1;"),
    ("a : INT; b : INT(1..3) := 1;", "b := a;"),
    ("a : INT := 7; b : Color;", "b := a;"),
    ("a : INT; b : POINTER TO INT;", "a := b^;"),
    ("a : INT;", "a := Deep(a);"),
]
AROUND = """TYPE Color : (red, green); END_TYPE

FUNCTION Deep : INT
VAR_INPUT x : INT; END_VAR
Deep := Deep(x);
END_FUNCTION
"""


@pytest.mark.parametrize(("variables", "statement"), FAULTS)
def test_faults_that_stop_a_task(variables: str, statement: str) -> None:
    bench = Bench(f"{AROUND}PROGRAM PLC_PRG\nVAR {variables} END_VAR\n{statement}\nEND_PROGRAM\n")
    assert bench.run(0) is WorkState.FAULTED
