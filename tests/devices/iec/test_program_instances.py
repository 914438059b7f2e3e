"""Several instances of one PROGRAM in a configuration (IEC 61131-3:2013, 6.8.1: each has variables of its own)."""

import pytest

from fieldrig.clock import MS, VirtualClock
from fieldrig_devices.iec.compiler import compile_project
from fieldrig_devices.iec.dialect import CODESYS, EDITION_3, EPAS_4, Dialect
from fieldrig_devices.iec.solo import Solo
from fieldrig_devices.iec.standalone import StandaloneHost
from fieldrig_devices.languages.source_file import SourceFile

COUNT = "PROGRAM Count VAR n : INT; END_VAR n := n + 1; all := all + 1; END_PROGRAM\nVAR_GLOBAL all : INT; END_VAR\n"


def values(instances: str, dialect: Dialect, *names: str, others: str = "") -> list[object]:
    """Return variables after 100 ms of two tasks, with 10 cycles of Fast and 5 of Slow."""
    tasks = "TASK Fast(INTERVAL := T#10ms, PRIORITY := 1); TASK Slow(INTERVAL := T#20ms, PRIORITY := 2);"
    text = f"{COUNT}{others}CONFIGURATION C\nRESOURCE R ON PLC\n{tasks}\n{instances}\nEND_RESOURCE\nEND_CONFIGURATION\n"
    clock = VirtualClock()
    host = StandaloneHost(clock)
    solo = Solo(clock, host, compile_project([SourceFile("a.st", text)], host, dialect))
    solo.start()
    solo.run_until(99 * MS)
    runtime = solo.program.runtime
    return [runtime.read(runtime.find(name)) for name in names]


THREE = "PROGRAM a WITH Fast : Count; PROGRAM b WITH Slow : Count; PROGRAM c WITH Slow : Count;"


def test_each_instance_has_its_own_variables() -> None:
    assert values(THREE, EDITION_3, "Count.n", "b.n", "c.n", "all") == [10, 5, 5, 20]


def test_the_same_instance_twice_is_one() -> None:
    assert values("PROGRAM a WITH Fast : Count; PROGRAM a WITH Slow : Count;", EDITION_3, "Count.n") == [15]


@pytest.mark.parametrize("dialect", [EPAS_4, CODESYS])
def test_elsewhere_a_program_exists_once(dialect: Dialect) -> None:
    assert values(THREE, dialect, "Count.n", "all") == [20, 20]


def test_a_name_that_is_taken_makes_no_instance() -> None:
    for others in ("FUNCTION b : INT b := 1; END_FUNCTION\n", "VAR_GLOBAL b : INT; END_VAR\n"):
        assert values(THREE, EDITION_3, "Count.n", "c.n", others=others) == [15, 5]
