"""Names that several libraries have: each library means its own, and `Library.Name` is the object of that library."""

from pathlib import Path

import pytest
from plc_project import HEAD, project

from fieldrig_devices.iec.tcunit.bench import Bench
from fieldrig_devices.iec.tcunit.namespaces import Space, separate
from fieldrig_devices.iec.tcunit.project import opened
from fieldrig_devices.languages.source_file import SourceFile


def unit(kind: str, name: str, declaration: str, body: str = "") -> str:
    inside = f"<Implementation><ST><![CDATA[{body}]]></ST></Implementation>" if kind == "POU" else ""
    return (
        f'{HEAD}<TcPlcObject Version="1.1.0.1"><{kind} Name="{name}" Id="{{0}}">\n'
        f"<Declaration><![CDATA[{declaration}]]></Declaration>\n{inside}\n</{kind}></TcPlcObject>\n"
    )


def library(number: int) -> dict[str, str]:
    """Return a library whose objects have the names of those of the others."""
    limits = f"{{attribute 'qualified_only'}}\nVAR_GLOBAL CONSTANT\n  Most : INT := {number * 10};\nEND_VAR"
    counter = "FUNCTION_BLOCK Counter\nVAR_OUTPUT n : INT; END_VAR\nVAR s : State; END_VAR"
    return {
        "Helper.TcPOU": unit("POU", "Helper", "FUNCTION INTERNAL Helper : INT", f"Helper := {number} + Limits.Most;"),
        "Limits.TcGVL": unit("GVL", "Limits", limits),
        "State.TcDUT": unit("DUT", "State", f"TYPE State : (idle := {number}, busy); END_TYPE"),
        f"Use{number}.TcPOU": unit("POU", f"Use{number}", f"FUNCTION Use{number} : INT", f"Use{number} := Helper();"),
        "Counter.TcPOU": unit("POU", "Counter", counter, "s := State.busy;\nn := n + s;"),
    }


def reference(name: str, namespace: str, parameters: str = "") -> str:
    return (
        f'<PlaceholderReference Include="{name}"><Namespace>{namespace}</Namespace>{parameters}</PlaceholderReference>'
    )


def suite(declarations: str, checks: str) -> dict[str, str]:
    head = f"FUNCTION_BLOCK All_Test EXTENDS TcUnit.FB_TestSuite\nVAR {declarations} END_VAR"
    main = "PROGRAM PRG_TEST\nVAR t : All_Test; END_VAR"
    return {
        "All_Test.TcPOU": unit("POU", "All_Test", head, f"TEST('all');\n{checks}\nTEST_FINISHED();"),
        "PRG_TEST.TcPOU": unit("POU", "PRG_TEST", main, "TcUnit.RUN();"),
    }


def equal(expected: int, actual: str) -> str:
    return f"AssertEquals_INT({expected}, {actual}, '{actual}');\n"


OWN = {"Helper.TcPOU": unit("POU", "Helper", "FUNCTION Helper : INT", "Helper := 7;")}
CHECKS = {
    "each library calls its own": equal(11, "Use1()") + equal(22, "Use2()"),
    "the project's own is the one without a namespace": equal(7, "Helper()"),
    "a namespace chooses": equal(11, "One.Helper()") + equal(22, "Two.Helper()") + equal(22, "two . helper()"),
    "lists of global variables": equal(10, "One.Limits.Most") + equal(20, "Two.Limits.Most"),
    "enumerations": equal(2, "One.State.busy") + equal(3, "Two.State.busy"),
    "blocks": "a();\nb();\n" + equal(2, "a.n") + equal(3, "b.n"),
    "what only libraries have is that of the first": equal(10, "Limits.Most"),
}


@pytest.mark.parametrize("checks", CHECKS.values(), ids=CHECKS)
def test_libraries_with_the_same_names(tmp_path: Path, checks: str) -> None:
    project(tmp_path / "One", library(1))
    project(tmp_path / "Two", library(2))
    files = suite("a : One.Counter; b : Two.Counter;", checks) | OWN
    path = project(tmp_path / "Tests", files, reference("One", "One"), reference("Two", "Two"))
    bench = Bench(opened(path))
    bench.run()
    assert (bench.program.left_out, bench.session.lines) == ([], [])


def test_a_library_names_another_by_a_namespace_of_its_own(tmp_path: Path) -> None:
    project(tmp_path / "One", library(1))
    third = {"Use3.TcPOU": unit("POU", "Use3", "FUNCTION Use3 : INT", "Use3 := Base.Helper() * 2;")} | OWN
    project(tmp_path / "Three", third, reference("One", "Base"))
    files = suite("", equal(22, "Use3()") + equal(11, "One.Helper()") + equal(7, "Three.Helper()"))
    path = project(tmp_path / "Tests", files, reference("Three", "Three"), reference("One", "One"))
    bench = Bench(opened(path))
    bench.run()
    assert (bench.program.left_out, bench.session.lines) == ([], [])


def test_a_parameter_is_set_in_the_library_that_it_is_given_for(tmp_path: Path) -> None:
    project(tmp_path / "One", library(1))
    project(tmp_path / "Two", library(2))
    given = '<Parameters><Parameter ListName="LIMITS"><Key>MOST</Key><Value>90</Value></Parameter></Parameters>'
    files = suite("", equal(11, "Use1()") + equal(92, "Use2()"))
    path = project(tmp_path / "Tests", files, reference("One", "One"), reference("Two", "Two", given))
    bench = Bench(opened(path))
    bench.run()
    assert (bench.program.left_out, bench.session.lines) == ([], [])


def changed(body: str) -> str:
    """Return a body of a second library in which the object Helper has another name."""
    one = Space("One", [SourceFile("1", unit("POU", "Helper", "FUNCTION Helper : INT"))])
    files = [
        SourceFile("2", unit("POU", "Helper", "FUNCTION Helper : INT")),
        SourceFile("3", unit("POU", "Use", "", body)),
    ]
    two = Space("Two", files, named=[("One", one)])
    separate([one, two])
    return two.files[1].text.split("CDATA[")[2].split("]]>")[0]


@pytest.mark.parametrize(
    ("body", "wanted"),
    [
        ("x := Helper();", "x := Helper_of_Two();"),
        ("x := HELPER();", "x := Helper_of_Two();"),
        ("x := One.Helper();", "x := One.Helper();"),
        ("x := y.Helper;", "x := y.Helper;"),
        ("x := y^.Helper + z[1].Helper;", "x := y^.Helper + z[1].Helper;"),
        ("F(Helper := 1, x => Helper);", "F(Helper := 1, x => Helper_of_Two);"),
        ("x := 'Helper'; (* Helper *) // Helper", "x := 'Helper'; (* Helper *) // Helper"),
        ("Helpers := Helper1;", "Helpers := Helper1;"),
        ("{attribute 'x' := 'Helper'}", "{attribute 'x' := 'Helper'}"),
    ],
)
def test_where_a_name_is_meant(body: str, wanted: str) -> None:
    assert changed(body) == wanted


def test_a_variable_of_the_same_name_stays() -> None:
    one = Space("One", [SourceFile("1", unit("POU", "Helper", "FUNCTION Helper : INT"))])
    use = unit("POU", "Use", "FUNCTION Use : INT\nVAR a, Helper : INT; END_VAR", "Use := Helper;")
    two = Space("Two", [SourceFile("2", unit("POU", "Helper", "FUNCTION Helper : INT")), SourceFile("3", use)])
    separate([one, two])
    assert two.files[1].text == use
