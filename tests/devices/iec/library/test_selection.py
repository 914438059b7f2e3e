"""A project gets the part of the libraries that it names, and its own declarations come first."""

import pytest
from library_bench import Bench

from fieldrig_devices.iec.dialect import EPAS_4
from fieldrig_devices.iec.library.selection import needed
from fieldrig_devices.iec.library.sources import sources
from fieldrig_devices.iec.parser import parse
from fieldrig_devices.iec.tree import Pou, TypeDeclaration

LIBRARIES = [parse(text, name)[0] for name, text in sources(EPAS_4.name)]


def names(text: str) -> set[str]:
    found = needed(LIBRARIES, [parse(text, "own.st")[0]], [text])
    return {node.name for unit in found for node in unit.declarations if isinstance(node, Pou | TypeDeclaration)}


@pytest.mark.parametrize(
    ("text", "used"),
    [
        ("VAR_GLOBAL x : BOOL; END_VAR", set()),
        ("VAR_GLOBAL x : Ton; END_VAR", {"TON"}),
        ("VAR_GLOBAL x : PID; END_VAR", {"PID", "DERIVATIVE", "INTEGRAL"}),
        ("VAR_GLOBAL x : RAMP_INT; END_VAR", {"RAMP_INT", "RAMP_REAL"}),
        ("VAR_GLOBAL x : CHARCURVE; END_VAR", {"CHARCURVE", "POINT"}),
        ("TYPE Point : STRUCT a : INT; END_STRUCT; END_TYPE", set()),
    ],
)
def test_what_is_named_and_what_that_needs(text: str, used: set[str]) -> None:
    assert names(text) == used | {"R_TRIG", "F_TRIG"}


def test_a_block_of_the_project_takes_the_place_of_one_of_the_library() -> None:
    bench = Bench(
        "FUNCTION_BLOCK TON\nVAR_OUTPUT Q : INT; END_VAR\nQ := Q + 3;\nEND_FUNCTION_BLOCK\n"
        "PROGRAM PLC_PRG\nVAR a : TON; b : TOF; END_VAR\na();\nb(IN := TRUE);\nEND_PROGRAM\n"
    )
    bench.call(0)
    assert bench.read("PLC_PRG.a.Q") == 3
    assert bench.read("PLC_PRG.b.Q") is True


def test_names_of_unused_blocks_are_free() -> None:
    bench = Bench(
        "TYPE Signal : (SINUS, RECTANGLE); END_TYPE\nVAR_GLOBAL blink : INT; END_VAR\n"
        "PROGRAM PLC_PRG\nVAR kind : Signal; END_VAR\nkind := RECTANGLE;\nblink := kind;\nEND_PROGRAM\n"
    )
    bench.call(0)
    assert bench.read("blink") == 1


def test_a_library_of_the_controller_may_have_a_name_of_the_standard_library() -> None:
    own = parse("TYPE Ton : (low, high); END_TYPE", "controller")[0]
    found = needed([*LIBRARIES, own], [parse("VAR_GLOBAL x : TON; END_VAR", "own.st")[0]], ["x : TON"])
    assert [
        (unit.file, node) for unit in found for node in unit.declarations if getattr(node, "name", "") in ("TON", "Ton")
    ] == [("controller", own.declarations[0])]
