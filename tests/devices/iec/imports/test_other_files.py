"""A drawing may use what any file of the project declares: a result that is kept has the type that a text gives it."""

from typing import Final, NamedTuple

import pytest
from exchange_documents import block, pou, sink, source, tc6
from iec_program import IecBench, PlainHost

from fieldrig_devices.iec.dialect import DIALECTS
from fieldrig_devices.iec.host import Library
from fieldrig_devices.languages.source_file import SourceFile

LIST: Final = """<TcPlcObject Version="1.1.0.1"><GVL Name="GVL"><Declaration><![CDATA[VAR_GLOBAL
    amount : UINT := 40000;
END_VAR]]></Declaration></GVL></TcPlcObject>"""
BLOCK: Final = "FUNCTION_BLOCK Base VAR_OUTPUT amount : UINT := 40000; END_VAR ; END_FUNCTION_BLOCK "
ALL: Final = tuple(DIALECTS)
TASK: Final = """CONFIGURATION C TASK T1(INTERVAL := T#10ms, PRIORITY := 1); PROGRAM I WITH T1 : P;
END_CONFIGURATION"""
TODAY: Final = ("codesys",)


class Case(NamedTuple):
    declared: str
    operand: str
    dialects: tuple[str, ...] = ALL
    own: str = "INT"
    """The type of the variable `own` of the drawn program."""


CASES: Final = {
    "a global variable": Case("VAR_GLOBAL amount : UINT := 40000; END_VAR", "amount"),
    "a structure": Case(
        "TYPE Box : STRUCT amount : UINT := 40000; END_STRUCT; END_TYPE VAR_GLOBAL crate : Box; END_VAR", "crate.amount"
    ),
    "an array": Case("VAR_GLOBAL row : ARRAY[1..2] OF UINT := [0, 40000]; END_VAR", "row[2]", ("edition-3", "codesys")),
    "another name of a type": Case("TYPE Amount : UINT := 40000; END_TYPE", "own", own="Amount"),
    "an output of a block": Case(BLOCK, "own.amount", own="Base"),
    "a variable of a program": Case(
        "PROGRAM Other VAR_OUTPUT amount : UINT := 40000; END_VAR ; END_PROGRAM " + TASK,
        "Other.amount", ("epas-4", "codesys"),
    ),
    "a function": Case("FUNCTION Amount : UINT Amount := 40000; END_FUNCTION", "Amount()", TODAY),
    "a list of global variables": Case(LIST, "GVL.amount", TODAY),
    "an output of a block that is extended": Case(
        BLOCK + "FUNCTION_BLOCK More EXTENDS Base ; END_FUNCTION_BLOCK", "own.amount", TODAY, "More"
    ),
    "a property": Case(
        "FUNCTION_BLOCK Base PROPERTY Amount : UINT GET Amount := 40000; END_GET END_PROPERTY END_FUNCTION_BLOCK",
        "own.Amount", TODAY, "Base",
    ),
    "a method": Case(
        "FUNCTION_BLOCK Base METHOD Amount : UINT Amount := 40000; END_METHOD END_FUNCTION_BLOCK",
        "own.Amount()", TODAY, "Base",
    ),
    "a pointer": Case(
        "TYPE Link : POINTER TO UINT; END_TYPE VAR_GLOBAL held : UINT := 40000; link : Link := ADR(held); END_VAR",
        "link^", TODAY,
    ),
    "a reference": Case(
        "VAR_GLOBAL held : UINT := 40000; link : REFERENCE TO UINT := held; END_VAR", "link", TODAY
    ),
}  # fmt: skip


def drawn(operand: str, own: str) -> str:
    """Return a program that adds 1 to the operand and compares the sum twice, so that it needs a variable."""
    body = source("o", operand) + source("one", "1") + block("f", "ADD", {"IN1": "o", "IN2": "one"})
    body += source("limit", "40001")
    for name in ("x", "y"):
        body += block(f"g{name}", "EQ", {"IN1": "f.OUT", "IN2": "limit"}) + sink(f"s{name}", name, f"g{name}.OUT")
    of = own if own in ("INT", "UINT") else f'<derived name="{own}"/>'
    return tc6(pou(f"<FBD>{body}</FBD>", variables={"own": of, "x": "BOOL", "y": "BOOL"}))


def run(document: str, others: list[SourceFile], dialect: str, host: PlainHost | None = None) -> tuple[object, object]:
    bench = IecBench(document, DIALECTS[dialect], host, main="P", others=others)
    bench.cycle()
    return bench["x"], bench["y"]


@pytest.mark.parametrize(
    ("case", "dialect"),
    [pytest.param(case, dialect, id=f"{name} {dialect}") for name, case in CASES.items() for dialect in case.dialects],
)
def test_an_operand_has_the_type_that_another_file_declares(case: Case, dialect: str) -> None:
    document = drawn(case.operand, case.own)
    assert run(document, [SourceFile("others.st", case.declared)], dialect) == (True, True)


def test_one_drawing_uses_what_another_one_declares() -> None:
    body = source("o", "40000") + sink("s", "Other", "o")
    function = tc6(
        '<pous><pou name="Other" pouType="function"><interface><returnType><UINT/></returnType></interface>'
        f"<body><FBD>{body}</FBD></body></pou></pous>"
    )
    user = drawn("Other()", "INT")
    assert run(user, [SourceFile("other.xml", function)], "codesys") == (True, True)


def test_an_operand_has_the_type_that_a_library_of_the_controller_declares() -> None:
    host = PlainHost([Library("amounts", BLOCK, {}, {})])
    assert run(drawn("own.amount", "Base"), [], "epas-4", host) == (True, True)


def test_the_own_file_hides_what_another_one_declares() -> None:
    other = [SourceFile("others.st", "VAR_GLOBAL own : BOOL; END_VAR")]
    document = drawn("own", "UINT").replace("<type><UINT/></type>", "<type><UINT/></type><initialValue><simpleValue"
    ' value="40000"/></initialValue>')  # fmt: skip
    assert run(document, other, "codesys") == (True, True)
