"""Projects with suites: what is read, what is compiled, and what is listed instead."""

from pathlib import Path

import pytest
from plc_project import HEAD, PROJECT, project
from tcunit_bench import SuiteBench, suite

from fieldrig.errors import UsageError
from fieldrig_devices.iec.imports.plcproj import read_plcproj
from fieldrig_devices.iec.imports.report import Report
from fieldrig_devices.iec.tcunit.bench import Bench
from fieldrig_devices.iec.tcunit.project import opened, projects_in
from fieldrig_devices.iec.testing.case import Limits, Verdict
from fieldrig_devices.iec.testing.reports.people import said
from fieldrig_devices.iec.testing.suites import sources_in


def pou(name: str, declaration: str, body: str = "") -> str:
    return (
        f'{HEAD}<TcPlcObject Version="1.1.0.1"><POU Name="{name}" Id="{{0}}">\n'
        f"<Declaration><![CDATA[{declaration}]]></Declaration>\n"
        f"<Implementation><ST><![CDATA[{body}]]></ST></Implementation>\n</POU></TcPlcObject>\n"
    )


def gvl(name: str, declaration: str) -> str:
    return (
        f'{HEAD}<TcPlcObject Version="1.1.0.1"><GVL Name="{name}" Id="{{0}}">\n'
        f"<Declaration><![CDATA[{declaration}]]></Declaration>\n</GVL></TcPlcObject>\n"
    )


def task(program: str, cycle_us: int) -> str:
    return (
        f'{HEAD}<TcPlcObject Version="1.1.0.1"><Task Name="PlcTask" Id="{{0}}"><CycleTime>{cycle_us}</CycleTime>'
        f"<Priority>20</Priority><PouCall><Name>{program}</Name></PouCall></Task></TcPlcObject>\n"
    )


SUITE = pou(
    "Pump_Test",
    "FUNCTION_BLOCK Pump_Test EXTENDS TcUnit.FB_TestSuite\nVAR pump : Pump; END_VAR",
    "TEST('runs');\npump(on := TRUE);\nAssertTrue(pump.runs, 'runs');\nTEST_FINISHED();",
)
PUMP = pou("Pump", "FUNCTION_BLOCK Pump\nVAR_INPUT on : BOOL; END_VAR\nVAR_OUTPUT runs : BOOL; END_VAR", "runs := on;")
MAIN = pou("PRG_TEST", "PROGRAM PRG_TEST\nVAR\n  t : Pump_Test;\nEND_VAR", "TcUnit.RUN();")
FILES = {
    "POUs\\Pump.TcPOU": PUMP,
    "Tests\\Pump_Test.TcPOU": SUITE,
    "Tests\\PRG_TEST.TcPOU": MAIN,
    "PlcTask.TcTTO": task("PRG_TEST", 1_000),
}


def test_a_project_runs_in_the_cycle_of_its_task(tmp_path: Path) -> None:
    bench = Bench(opened(project(tmp_path / "Plant", FILES)))
    bench.run()
    assert [suite.path for suite in bench.session.suites.values()] == ["PRG_TEST.t"]
    assert bench.interval_ns == 1_000_000
    assert not bench.session.parameters.is_extended
    assert bench.session.lines == []


def test_a_file_that_is_not_there_is_named_and_one_of_another_kind_is_left_alone(tmp_path: Path) -> None:
    path = project(tmp_path / "Plant", FILES)
    text = (
        path.read_text()
        .replace("PlcTask.TcTTO", "Other.TcTTO")
        .replace("</ItemGroup>", '<None Include="x.tmc"/></ItemGroup>', 1)
    )
    path.write_text(text)
    assert opened(path).absent == ["the file Other.TcTTO"]


@pytest.mark.parametrize("text", ["", "no project", "<Project", "<Solution/>", "<!DOCTYPE a><Project/>"])
def test_what_is_no_project_is_refused(tmp_path: Path, text: str) -> None:
    path = tmp_path / "x.plcproj"
    path.write_text(text)
    with pytest.raises(UsageError, match="cannot be read"):
        opened(path)


def test_a_path_cannot_lead_to_files_of_others(tmp_path: Path) -> None:
    (tmp_path / "secret.TcPOU").write_text(PUMP)
    report = Report("p")
    text = PROJECT.format(name="p", title="", references="", files='<Compile Include="..\\..\\..\\..\\etc\\x.TcPOU"/>')
    found = read_plcproj(tmp_path / "a" / "p.plcproj", text, report)
    assert found is not None
    assert (found.files, found.missing) == ([], ["..\\..\\..\\..\\etc\\x.TcPOU"])


def test_a_library_is_found_by_its_name_in_the_folders_around(tmp_path: Path) -> None:
    library = {
        "Pump.TcPOU": PUMP.replace("runs := on;", "runs := on OR Limits.always;"),
        "Limits.TcGVL": gvl("Limits", "VAR_GLOBAL CONSTANT\nalways : BOOL := FALSE;\nEND_VAR"),
    }
    project(tmp_path / "libs" / "Pumps", library, title="My pumps")
    files = {name: text for name, text in FILES.items() if "POUs" not in name}
    setting = '<Parameters><Parameter ListName="LIMITS"><Key>ALWAYS</Key><Value>1</Value></Parameter></Parameters>'
    path = project(
        tmp_path / "tests" / "PumpTests",
        files
        | {
            "Tests\\Pump_Test.TcPOU": SUITE.replace("on := TRUE", "on := FALSE").replace(
                "pump : Pump;", "pump : Pumps.Pump;"
            )
        },
        f'<PlaceholderReference Include="My pumps"><Namespace>Pumps</Namespace>{setting}</PlaceholderReference>',
    )
    bench = Bench(opened(path))
    bench.run()
    assert (bench.program.left_out, bench.session.lines) == ([], [])


def test_only_what_suites_reach_is_compiled_and_the_rest_never_read() -> None:
    broken = "FUNCTION_BLOCK Unused VAR x : Missing; END_VAR END_FUNCTION_BLOCK"
    bench = SuiteBench.ran(suite("TEST('t'); TEST_FINISHED();"), broken)
    assert bench.program.reached == 2
    assert bench.test("t").is_finished


def test_a_unit_that_does_not_compile_stops_only_the_suites_that_need_it() -> None:
    texts = [
        "FUNCTION_BLOCK Drive VAR x : ARRAY[1..MOST] OF INT; END_VAR END_FUNCTION_BLOCK",
        "FUNCTION_BLOCK One EXTENDS FB_TestSuite VAR d : Drive; END_VAR TEST('one');\nEND_FUNCTION_BLOCK",
        "FUNCTION_BLOCK Two EXTENDS FB_TestSuite TEST('two'); TEST_FINISHED(); END_FUNCTION_BLOCK",
        "PROGRAM PRG_TEST VAR a : One; b : Two; END_VAR RUN(); END_PROGRAM",
    ]
    bench = SuiteBench(*texts)
    bench.run()
    assert [(one.name, one.is_suite, one.reason.what) for one in bench.program.left_out] == [
        ("Drive", False, "MOST is not declared"),
        ("One", True, "the type Drive is not declared"),
    ]
    assert [list(suite.tests) for suite in bench.suites] == [[], ["two"]]


# ---- as tests of the runner


def test_the_runner_lists_and_runs_the_tests_of_a_project(tmp_path: Path) -> None:
    path = project(tmp_path / "Plant", FILES)
    (source,) = sources_in(tmp_path)
    (case,) = source.cases()
    assert (case.name, case.suite, case.file.name, case.line) == ("runs", "PRG_TEST.t", "Pump_Test.TcPOU", 5)
    (outcome,) = source.run([case], Limits())
    assert (outcome.verdict, outcome.asserts, outcome.duration_ns) == (Verdict.PASSED, 1, 0)
    assert path in source.files()


def test_a_test_may_have_the_name_of_its_method(tmp_path: Path) -> None:
    method = "METHOD Fills\nTEST(__POUNAME()); AssertTrue(TRUE, 'm'); TEST_FINISHED();\nEND_METHOD"
    (tmp_path / "a.st").write_text(suite("Fills();", methods=method))
    (source,) = sources_in(tmp_path)
    (case,) = source.cases()
    (outcome,) = source.run([case], Limits())
    assert (case.name, outcome.verdict) == ("Suite.Fills", Verdict.PASSED)


def test_the_runner_gets_failures_skips_faults_and_tests_without_an_end(tmp_path: Path) -> None:
    body = """
    TEST('fails'); AssertEquals_INT(1, 2, 'm'); TEST_FINISHED();
    TEST('disabled_later');
    TEST('hangs');
    """
    fault = """
    FUNCTION_BLOCK Bad EXTENDS FB_TestSuite VAR n : INT; END_VAR
    TEST('faults'); n := 1 / n; TEST_FINISHED();
    TEST('never'); TEST_FINISHED();
    END_FUNCTION_BLOCK
    """
    lost = "FUNCTION_BLOCK Lost EXTENDS FB_TestSuite VAR d : Drive; END_VAR TEST('x'); END_FUNCTION_BLOCK"
    main = "PROGRAM PRG_TEST VAR s : Suite; b : Bad; l : Lost; END_VAR RUN(); END_PROGRAM"
    texts = [suite(body).partition("PROGRAM")[0], fault, lost, main]
    for number, text in enumerate(texts):
        (tmp_path / f"part{number}.st").write_text(text)
    (source,) = sources_in(tmp_path)
    outcomes = {outcome.case.name: outcome for outcome in source.run(source.cases(), Limits(longest_ns=100_000_000))}
    assert {name: outcome.verdict for name, outcome in outcomes.items()} == {
        "fails": Verdict.FAILED,
        "disabled_later": Verdict.SKIPPED,
        "hangs": Verdict.ERROR,
        "faults": Verdict.ERROR,
        "never": Verdict.SKIPPED,
        "the suite compiles": Verdict.ERROR,
    }
    (failure,) = outcomes["fails"].failures
    assert (failure.kind, failure.expected, failure.actual, failure.message) == ("INT", "1", "2", "m")
    assert "a division by zero" in outcomes["faults"].failures[0].actual


@pytest.mark.parametrize(
    ("declarations", "kind", "said_of_it"),
    [
        ('a : WSTRING := "Grüße"; b : WSTRING := "日本";', "WSTRING", "m: expected Grüße, got 日本"),
        ('a : WSTRING := "Grüße"; b : WSTRING;', "WSTRING", "m: expected Grüße, got ''"),
        ("a : STRING; b : STRING := 'x';", "STRING", "m: expected '', got x"),
    ],
)
def test_a_failure_shows_both_texts(tmp_path: Path, declarations: str, kind: str, said_of_it: str) -> None:
    text = f"""FUNCTION_BLOCK S EXTENDS FB_TestSuite VAR {declarations} END_VAR
    TEST('t'); AssertEquals_{kind}(a, b, 'm'); TEST_FINISHED();
    END_FUNCTION_BLOCK
    PROGRAM PRG_TEST VAR s : S; END_VAR RUN(); END_PROGRAM"""
    (tmp_path / "s.st").write_text(text, encoding="utf-8")
    (source,) = sources_in(tmp_path)
    (outcome,) = source.run(source.cases(), Limits(longest_ns=100_000_000))
    assert [said(failure) for failure in outcome.failures] == [said_of_it]


def test_a_folder_without_projects_is_one_and_one_without_suites_is_none(tmp_path: Path) -> None:
    (tmp_path / "a.st").write_text("PROGRAM PLC_PRG END_PROGRAM")
    assert sources_in(tmp_path) == []
    assert projects_in(tmp_path) == [tmp_path]
    (tmp_path / "b.TcPOU").write_text(
        SUITE.replace("pump(on := TRUE);", "").replace("pump : Pump;", "").replace("pump.runs", "TRUE")
    )
    (source,) = sources_in(tmp_path)
    assert [outcome.verdict for outcome in source.run(source.cases(), Limits())] == [Verdict.PASSED]


def test_a_variable_with_the_attribute_instance_path_has_the_path_of_its_instance() -> None:
    named = """FUNCTION_BLOCK Named
VAR
    {attribute 'instance-path'}
    {attribute 'noinit'}
    path : STRING;
    {attribute 'instance-path'}
    short : STRING(3);
END_VAR
END_FUNCTION_BLOCK
FUNCTION_BLOCK Derived EXTENDS Named END_FUNCTION_BLOCK
"""
    body = """TEST('t');
AssertEquals('tests Instance.tests.PRG_TEST.s.ones[2]', ones[2].path, 'element');
AssertEquals('tests Instance.tests.PRG_TEST.s.one', one.path, 'derived');
AssertEquals('tes', one.short, 'cut');
AssertEquals('tests', TwinCAT_SystemInfoVarList._AppInfo.ProjectName, 'project');
TEST_FINISHED();"""
    bench = SuiteBench.ran(named, suite(body, "ones : ARRAY[1..2] OF Named; one : Derived;"))
    assert not bench.test("t").failures, bench.lines


def test_the_program_that_is_made_has_a_name_of_its_own(tmp_path: Path) -> None:
    # A library may bring its own tests, with a program of the usual name.
    project(tmp_path / "libs" / "Pumps", {"Pump.TcPOU": PUMP, "PRG_TEST.TcPOU": pou("PRG_TEST", "PROGRAM PRG_TEST")})
    path = project(
        tmp_path / "tests" / "PumpTests",
        {"Tests\\Pump_Test.TcPOU": SUITE},
        '<PlaceholderReference Include="Pumps"><Namespace>Pumps</Namespace></PlaceholderReference>',
    )
    bench = Bench(opened(path))
    bench.run()
    assert [suite.path for suite in bench.session.suites.values()] == ["PRG_TEST_.Pump_Test_"]
    assert [test.has_failed for suite in bench.session.suites.values() for test in suite.tests.values()] == [False]


BROKEN = """
FUNCTION_BLOCK Broken
VAR n : INT; END_VAR
METHOD FB_init : BOOL VAR_INPUT bInitRetains : BOOL; bInCopyCode : BOOL; END_VAR n := 1 / n; END_METHOD
END_FUNCTION_BLOCK
"""
NAMED = """
FUNCTION_BLOCK {name} EXTENDS TcUnit.FB_TestSuite
{variables}
TEST('{name}'); TEST_FINISHED();
END_FUNCTION_BLOCK
"""


def test_a_suite_behind_a_fault_at_the_start_is_an_error_and_not_left_out(tmp_path: Path) -> None:
    path = tmp_path / "all.st"
    second = NAMED.format(name="Second", variables="VAR b : Broken; END_VAR")
    path.write_text(
        BROKEN + NAMED.format(name="First", variables="") + second + NAMED.format(name="Third", variables="")
    )
    (source,) = sources_in(path)
    found = {one.case.name: one for one in source.run(source.cases(), Limits(30.0))}
    assert {name: one.verdict for name, one in found.items()} == {
        "First": Verdict.PASSED,
        "Second": Verdict.ERROR,
        "Third": Verdict.ERROR,
    }
    assert found["Third"].failures[0].actual.startswith("the suite has not begun: a division by zero in Broken.FB_init")


def test_a_suite_that_no_program_gets_to_is_an_error(tmp_path: Path) -> None:
    path = tmp_path / "all.st"
    main = "PROGRAM PRG_TEST VAR s : Only; n : INT; END_VAR {body} END_PROGRAM"
    suite_text = NAMED.format(name="Only", variables="")
    for body, why in (
        ("n := 1 / n; TcUnit.RUN();", "a division by zero in PRG_TEST"),
        ("IF n > 0 THEN TcUnit.RUN(); END_IF", "no program has called RUN"),
    ):
        path.write_text(suite_text + main.format(body=body))
        (source,) = sources_in(path)
        (found,) = source.run(source.cases(), Limits(30.0))
        assert (found.verdict, why in found.failures[0].actual) == (Verdict.ERROR, True)


def test_a_fault_beside_the_suites_is_told(tmp_path: Path) -> None:
    path = tmp_path / "all.st"
    main = "PROGRAM PRG_TEST VAR s : Only; n : INT; END_VAR TcUnit.RUN(); n := 1 / n; END_PROGRAM"
    path.write_text(NAMED.format(name="Only", variables="") + main)
    (source,) = sources_in(path)
    (found,) = source.run(source.cases(), Limits(30.0))
    assert found.verdict is Verdict.PASSED
    assert found.output[-1].startswith("beside the suites: a division by zero in PRG_TEST")


TYPES = (
    HEAD
    + """<TcSmProject><DataTypes>
<DataType><Name GUID="{1}">Gap</Name><SubItem><Name>width</Name><Type>INT</Type></SubItem></DataType>
<DataType><Name GUID="{2}">Gap</Name>
  <SubItem><Name>width</Name><Type>REAL</Type></SubItem>
  <SubItem><Name>steps</Name><Type>INT</Type>
    <ArrayInfo><LBound>1</LBound><Elements>3</Elements></ArrayInfo></SubItem>
  <Hides><Hide GUID="{1}"/></Hides></DataType>
<DataType><Name RemovableEnumPrefix="GRADE_">Grade</Name><BaseType>INT</BaseType>
  <EnumInfo><Text>GRADE_Low</Text><Enum>2</Enum></EnumInfo>
  <EnumInfo><Text>GRADE_High</Text><Enum>5</Enum></EnumInfo></DataType>
<DataType><Name>Pumped</Name><SubItem><Name>x</Name><Type>no; type</Type></SubItem></DataType>
<DataType><Name>Lengths</Name><BaseType>LREAL</BaseType>
  <ArrayInfo><LBound>0</LBound><Elements>2</Elements></ArrayInfo></DataType>
</DataTypes></TcSmProject>
"""
)


def test_the_types_of_the_twincat_project_are_known(tmp_path: Path) -> None:
    declared = (
        "FUNCTION_BLOCK T EXTENDS TcUnit.FB_TestSuite\nVAR g : Gap; l : Lengths; e : Grade := Grade.High; END_VAR"
    )
    body = "g.width := 0.5; l[1] := 2;\nTEST('t'); AssertEquals_DINT(5 + 1, e + TRUNC(g.width * l[1]), '');"
    body += "\nAssertEquals_DINT(3, UPPER(g.steps), ''); TEST_FINISHED();"
    upper = pou(
        "UPPER", "FUNCTION UPPER : DINT\nVAR_IN_OUT a : ARRAY[*] OF INT; END_VAR", "UPPER := UPPER_BOUND(a, 1);"
    )
    path = project(tmp_path / "Machine" / "Plc", {"T.TcPOU": pou("T", declared, body), "UPPER.TcPOU": upper})
    (tmp_path / "Machine" / "Machine.tsproj").write_text(TYPES)
    bench = Bench(opened(path))
    bench.run()
    assert (bench.program.left_out, bench.session.lines, bench.faults) == ([], [], [])
    assert bench.session.is_over


@pytest.mark.parametrize("text", ["", "<TcSmProject", "<Other/>", "<TcSmProject/>", "<!DOCTYPE a><TcSmProject/>"])
def test_a_project_without_types_changes_nothing(tmp_path: Path, text: str) -> None:
    path = project(tmp_path / "Machine" / "Plc", FILES)
    (tmp_path / "Machine" / "Machine.tsproj").write_text(text)
    assert opened(path).library_files == []
