"""Outputs that a TwinCAT project links with inputs of the same program, as suites move blocks."""

from pathlib import Path

import pytest
from plc_project import project
from typer.testing import CliRunner

from fieldrig_devices.iec.commands import app
from fieldrig_devices.iec.imports.io_links import links_of
from fieldrig_devices.iec.imports.report import Report

TSPROJ = """<?xml version="1.0"?>
<TcSmProject TcSmVersion="1.0"><Project/><Mappings>
<OwnerA Name="TIPC^Plc^Plc Instance">
<OwnerB Name="TIPC^Plc^Plc Instance">
<Link VarA="PlcTask Inputs^MAIN.suite.gauge.raw" VarB="PlcTask Outputs^MAIN.suite.volts"/>
<Link VarA="PlcTask Outputs^MAIN.suite.volts" VarB="PlcTask Inputs^MAIN.suite.second.raw"/>
<Link VarA="PlcTask Outputs^MAIN.suite.volts" VarB="PlcTask Inputs^MAIN.suite.gone.raw"/>
</OwnerB>
<OwnerB Name="TIID^Device 1^Box 2">
<Link VarA="PlcTask Outputs^MAIN.suite.volts" VarB="Channel 1^Inputs^Value"/>
</OwnerB>
</OwnerA></Mappings></TcSmProject>
"""
SOURCE = """FUNCTION_BLOCK Gauge
VAR raw AT %I* : INT; END_VAR
VAR_OUTPUT pressure : INT; END_VAR
pressure := 2 * raw;
END_FUNCTION_BLOCK
FUNCTION_BLOCK GaugeTest EXTENDS TcUnit.FB_TestSuite
VAR volts AT %Q* : INT; gauge, second : Gauge; cycles : INT; END_VAR
cycles := cycles + 1;
volts := 10 * cycles;
gauge(); second();
TEST('an output gets to the input in the next cycle');
IF cycles = 3 THEN
    AssertEquals_INT(40, gauge.pressure, 'what was put out in cycle 2');
    AssertEquals_INT(40, second.pressure, 'at both inputs');
    TEST_FINISHED();
END_IF
END_FUNCTION_BLOCK
PROGRAM MAIN
VAR suite : GaugeTest; END_VAR
TcUnit.RUN();
END_PROGRAM
"""


def test_a_suite_moves_inputs_by_its_own_outputs(tmp_path: Path) -> None:
    (tmp_path / "Plc.tsproj").write_text(TSPROJ)
    done = CliRunner().invoke(app, ["test", str(project(tmp_path / "Plc", {"Gauge.st": SOURCE}))])
    assert done.exit_code == 0, done.output
    assert "1 test: 1 passed" in done.output


@pytest.mark.parametrize(
    ("text", "count"), [(TSPROJ, 3), (TSPROJ.replace("OwnerB", "OwnerC"), 0), ("<TcSmProject>", 0), ("", 0)]
)
def test_only_links_of_the_program_with_itself_count(text: str, count: int) -> None:
    assert len(links_of(text, Report("Plc.tsproj"))) == count
