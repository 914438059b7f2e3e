"""Paths and start values of instances in VAR_CONFIG: IEC 61131-3:2013, table 62, and the conformance cases of truST."""

import pytest

from fieldrig.clock import MS, VirtualClock
from fieldrig_devices.iec.compiler import compile_project
from fieldrig_devices.iec.dialect import DIALECTS, EDITION_3, Dialect
from fieldrig_devices.iec.solo import Solo
from fieldrig_devices.iec.standalone import StandaloneHost
from fieldrig_devices.languages.mistakes import CompileError
from fieldrig_devices.languages.source_file import SourceFile

COUNT = """\
TYPE Scale : STRUCT gain : INT; offset : INT := 2; END_STRUCT; END_TYPE
FUNCTION_BLOCK Sum
VAR_INPUT step : INT; scale : Scale; END_VAR
VAR_OUTPUT total : INT; END_VAR
VAR lamp AT %Q* : WORD; END_VAR
total := total + step * scale.gain + scale.offset;
lamp := 5;
END_FUNCTION_BLOCK
PROGRAM Count
VAR n : INT := 1; sum : Sum; marker AT %M* : WORD; END_VAR
n := n + 1;
sum();
marker := 3;
END_PROGRAM
"""
ADDRESSES = "P1.sum.lamp AT %QW2 : WORD; P1.marker AT %MW4 : WORD;"


def resource(name: str, instances: str) -> str:
    task = "TASK Fast(INTERVAL := T#10ms, PRIORITY := 1);"
    return f"RESOURCE {name} ON PLC {task} {instances} END_RESOURCE "


def values(config: str, dialect: Dialect, *names: str, resources: str = "", chosen: str = "") -> list[object]:
    """Return variables after one cycle."""
    inside = resources or resource("Station", "PROGRAM P1 WITH Fast : Count;")
    text = f"{COUNT}CONFIGURATION Plant {inside} VAR_CONFIG {config} END_VAR END_CONFIGURATION"
    clock = VirtualClock()
    host = StandaloneHost(clock)
    solo = Solo(clock, host, compile_project([SourceFile("a.st", text)], host, dialect, resource=chosen))
    solo.start()
    solo.run_until(9 * MS)
    runtime = solo.program.runtime
    return [runtime.read(runtime.find(name)) for name in names]


@pytest.mark.parametrize("dialect", DIALECTS.values(), ids=DIALECTS)
@pytest.mark.parametrize("path", ["Count", "P1", "Station.P1", "Plant.Station.P1", "station.count"])
def test_a_path_begins_with_a_program_its_instance_or_their_resource(path: str, dialect: Dialect) -> None:
    config = ADDRESSES.replace("P1", path)
    assert values(config, dialect, "Count.sum.lamp", "Count.marker") == [5, 3]


@pytest.mark.parametrize("dialect", DIALECTS.values(), ids=DIALECTS)
def test_an_instance_has_start_values_of_its_own(dialect: Dialect) -> None:
    config = (
        "P1.n : INT := 5; Station.P1.sum : Sum := (step := 3); P1.sum.scale.gain : INT := 10; P1.sum.total : INT := 4;"
    )
    found = values(config + ADDRESSES, dialect, "Count.n", "Count.sum.step", "Count.sum.total", "Count.sum.scale.gain")
    assert found == [6, 3, 36, 10]


def test_two_instances_of_one_program_differ() -> None:
    instances = resource("Station", "PROGRAM P1 WITH Fast : Count; PROGRAM P2 WITH Fast : Count;")
    config = (
        f"{ADDRESSES}{ADDRESSES.replace('P1', 'P2').replace('QW2', 'QW4').replace('MW4', 'MW6')} P2.n : INT := 100;"
    )
    assert values(config, EDITION_3, "Count.n", "P2.n", resources=instances) == [2, 101]


@pytest.mark.parametrize(("chosen", "n"), [("One", 11), ("Two", 21)])
def test_a_resource_that_does_not_run_gives_nothing(chosen: str, n: int) -> None:
    resources = resource("One", "PROGRAM P1 WITH Fast : Count;") + resource("Two", "PROGRAM P1 WITH Fast : Count;")
    config = f"{ADDRESSES} One.P1.n : INT := 10; Two.P1.n : INT := 20; One.P1.marker AT %MW9 : WORD;"
    config = config if chosen == "Two" else config.replace("One.P1.marker AT %MW9 : WORD;", "")
    assert values(config, EDITION_3, "Count.n", resources=resources, chosen=chosen) == [n]


def test_a_variable_that_does_not_exist_is_named() -> None:
    with pytest.raises(CompileError) as refused:
        values(f"{ADDRESSES} P1.missing : INT := 1;", EDITION_3)
    assert "there is no variable Count.missing" in str(refused.value.mistakes[0])
