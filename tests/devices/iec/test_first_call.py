"""A routine that is not made in advance becomes Python when it is first called; the program does the same."""

from pathlib import Path

import pytest
from iec_program import ENOUGH_NS, PlainHost

from fieldrig_devices.iec.compiler import Compiled, compile_project
from fieldrig_devices.iec.dialect import CODESYS
from fieldrig_devices.iec.runtime import Runtime
from fieldrig_devices.iec.tasks.task import WorkState
from fieldrig_devices.iec.thread import Fault
from fieldrig_devices.languages.source_file import SourceFile

PROGRAMS = [
    file for file in sorted((Path(__file__).parent / "programs").glob("*.st")) if "codesys" in file.read_text()[:80]
]
BRANCHES = """
FUNCTION Often : INT VAR_INPUT a : INT; END_VAR
WHILE a > Often DO Often := Often + 1; END_WHILE Often := Often + 1; END_FUNCTION
FUNCTION Never : INT VAR_INPUT a : INT; END_VAR
WHILE a < Never DO Never := Never - 1; END_WHILE END_FUNCTION
PROGRAM PLC_PRG VAR n : INT; END_VAR IF n < 0 THEN n := Never(n); ELSE n := Often(n); END_IF; END_PROGRAM
"""


def cycled(compiled: Compiled, cycles: int = 3) -> tuple[Fault | None, str]:
    """Return the fault of the main program after some cycles, and all values of its memory as a text."""
    host = PlainHost()
    runtime = Runtime(compiled, host)
    thread = runtime.thread(compiled.program.pous[CODESYS.key("PLC_PRG")])
    for cycle in range(cycles):
        host.ms = 10 * cycle
        thread.start()
        while thread.state is WorkState.READY:
            thread.run(ENOUGH_NS)
    return thread.fault, repr(runtime.contents.cells)


def made(compiled: Compiled) -> set[str]:
    return {name for name, routine in compiled.code.routines.items() if routine.fast}


@pytest.mark.parametrize("file", PROGRAMS, ids=lambda file: file.stem)
def test_a_program_does_the_same_without(file: Path) -> None:
    text = file.read_text(encoding="ascii")
    in_advance, later = (
        compile_project([SourceFile("a.st", text)], PlainHost(), CODESYS, in_advance=ready) for ready in (True, False)
    )
    assert cycled(later) == cycled(in_advance)


def test_only_what_is_called_is_made_and_stays_for_the_next_run_time() -> None:
    compiled = compile_project([SourceFile("a.st", BRANCHES)], PlainHost(), CODESYS, in_advance=False)
    assert not made(compiled)
    first = cycled(compiled)
    assert made(compiled) == {"plc_prg", "often"}
    codes = [routine.fast for routine in compiled.code.routines.values()]
    assert cycled(compiled) == first
    again = [routine.fast for routine in compiled.code.routines.values()]
    assert all(now is before for now, before in zip(again, codes, strict=True)), "nothing was made again"
