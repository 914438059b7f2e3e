"""`fieldrig iec test`: choice, reports, exit codes, parallel processes."""

import json
from pathlib import Path
from xml.etree import ElementTree as ET

import pytest
from st_tests import MOTOR, as_json, iec_test, written

from fieldrig_devices.iec.testing.gathered import has_tests

TESTS = """\
TEST 'good' ASSERT_EQ(Step(2), 2); END_TEST
TEST 'bad <&> "x"'
VAR m : Motor; END_VAR
PRINT('before');
m(start := TRUE);
ADVANCE_TIME(T#2s);
m(start := FALSE);
ASSERT_TRUE(m.run, 'runs $'on$' & on');
END_TEST
TEST 'later' SKIP 'not <yet>' END_TEST
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return written(tmp_path, motor=MOTOR, motor_test=TESTS, other_test="TEST 'other good' ASSERT_TRUE(TRUE); END_TEST")


def test_a_person_sees_source_values_and_signals(folder: Path) -> None:
    done = iec_test(folder)
    assert done.exit_code == 1
    shown = done.stdout.split('FAILED  bad <&> "x"')[1].splitlines()
    file = folder / "motor_test.st"
    assert [line.rstrip() for line in shown if file.name in line or line.startswith("    ")][:7] == [
        f'FAILED {file}: bad <&> "x"',
        "    | before",
        f"  {file}:8",
        "    ASSERT_TRUE(m.run, 'runs $'on$' & on');",
        "    runs 'on' & on: expected TRUE, got FALSE",
        "    assertion 1 at T#2s",
        "      m.run  " + "▁" * 48,
    ]
    assert shown[-1].startswith("4 tests: 2 passed, 1 failed, 1 skipped in ")


def test_junit_counts_and_escapes_everything(folder: Path, tmp_path: Path) -> None:
    report = tmp_path / "report.xml"
    assert iec_test(folder, "--junit", report).exit_code == 1
    root = ET.parse(report).getroot()
    counts = ("tests", "failures", "errors", "skipped")
    assert [root.get(key) for key in counts] == ["4", "1", "0", "1"]
    assert [[suite.get(key) for key in counts] for suite in root] == [["3", "1", "0", "1"], ["1", "0", "0", "0"]]
    case = root.find('.//testcase[@line="2"]')
    assert case is not None
    assert (case.get("name"), case.get("file")) == ('bad <&> "x"', str(folder / "motor_test.st"))
    failure = case.find("failure")
    assert failure is not None
    assert failure.get("message") == "runs 'on' & on: expected TRUE, got FALSE"
    assert (failure.text or "").startswith(f"{folder / 'motor_test.st'}:8\nASSERT_TRUE")
    assert [node.get("message") for node in root.iter("skipped")] == ["not <yet>"]


def test_a_mistake_has_the_same_words_in_junit(tmp_path: Path) -> None:
    written(tmp_path, a_test="TEST 'a' ASSERT_TRUE(5); END_TEST")
    report = tmp_path / "report.xml"
    assert iec_test(tmp_path, "--junit", report).exit_code == 2
    (error,) = ET.parse(report).getroot().iter("error")
    assert error.get("message") == "the number 5 is no BOOL; expected BOOL; write TRUE or FALSE, or compare: x <> 0"


def test_control_characters_do_not_break_the_report(tmp_path: Path) -> None:
    written(tmp_path, a_test="TEST 'a' PRINT('$01$0B'); ASSERT_EQ('$00x', '$1F'); END_TEST")
    report = tmp_path / "report.xml"
    iec_test(tmp_path, "--junit", report)
    assert ET.parse(report).getroot().get("failures") == "1"


def test_json_has_all_facts(folder: Path) -> None:
    tests = as_json(folder)
    assert [one["verdict"] for one in tests] == ["passed", "failed", "skipped", "passed"]
    bad = tests[1]
    assert (bad["line"], bad["asserts"], bad["duration_ns"], bad["output"]) == (2, 1, 2_000_000_000, ["before"])
    assert [(one["kind"], one["line"], one["at_ns"]) for one in bad["failures"]] == [("ASSERT_TRUE", 8, 2_000_000_000)]


def test_the_list_has_places(folder: Path) -> None:
    done = iec_test(folder, "--list", "-k", "good")
    assert done.stdout.splitlines() == [
        f"{folder}/motor_test.st:1: good",
        f"{folder}/other_test.st:1: other good",
    ]
    cases = json.loads(iec_test(folder, "--list", "--json").stdout)
    assert [case["id"].rpartition("::")[2] for case in cases] == ["good", 'bad <&> "x"', "later", "other good"]


@pytest.mark.parametrize(
    ("arguments", "names"),
    [
        (["-k", "GOOD"], ["good", "other good"]),
        (["-k", "other*good"], ["other good"]),
        (["-k", "later", "-k", "other"], ["later", "other good"]),
        (["::good"], ["good"]),
        (["::*good"], ["good", "other good"]),
        (["/motor_test.st::l*"], ["later"]),
    ],
)
def test_tests_are_chosen_by_name(folder: Path, arguments: list[str], names: list[str]) -> None:
    path = folder
    if arguments[0].startswith(("::", "/")):
        path, arguments = Path(f"{folder}{arguments[0]}"), arguments[1:]
    assert [one["name"] for one in as_json(path, *arguments)] == names


@pytest.mark.parametrize("arguments", [["-k", "nothing"], ["::nothing"]])
def test_a_name_of_no_test_is_wrong_usage(folder: Path, arguments: list[str]) -> None:
    path = f"{folder}{arguments[0]}" if len(arguments) == 1 else folder
    done = iec_test(path, *(arguments if len(arguments) > 1 else []))
    assert "no test has such a name: nothing" in str(done.exception)


def test_a_folder_without_tests_of_st_names_a_file_of_pytest_in_it(tmp_path: Path) -> None:
    assert "expected TEST 'name' ... END_TEST" in str(iec_test(tmp_path).exception)
    (tmp_path / "test_lab.py").write_text("def test_it(): pass")
    said = str(iec_test(tmp_path).exception)
    assert f"name a file of pytest itself, such as {tmp_path / 'test_lab.py'}" in said


NAMED = """
TEST 'opens the lid' END_TEST
TEST 'closes the lid' END_TEST
"""


@pytest.mark.parametrize(
    ("words", "answer"),
    [
        (["{}::open the lid"], "open the lid\n  did you mean opens the lid?"),
        (["{}::opens the lid", "{}::close the lid"], "close the lid\n  did you mean closes the lid?"),
        (["{}", "-k", "opns the lid"], "opns the lid\n  did you mean opens the lid?"),
        (["{}", "-k", "opens", "-k", "zzz"], "zzz\n  `fieldrig iec test PATH --list` shows all names"),
        (["{}::opens the lid", "-k", "closes"], "no test has such names together"),
    ],
)
def test_each_name_is_looked_up_and_answered_with_the_nearest_one(
    tmp_path: Path, words: list[str], answer: str
) -> None:
    file = tmp_path / "lid_test.st"
    file.write_text(NAMED)
    done = iec_test(*(word.format(file) for word in words))
    assert answer in str(done.exception)


@pytest.mark.system
@pytest.mark.long
def test_processes_give_the_same_outcomes_in_the_same_order(folder: Path) -> None:
    facts = [(one["id"], one["verdict"], one["duration_ns"]) for one in as_json(folder)]
    assert [(one["id"], one["verdict"], one["duration_ns"]) for one in as_json(folder, "-j", "2")] == facts


PROJECT = """\
<Project xmlns="http://schemas.microsoft.com/developer/msbuild/2003"><PropertyGroup><Name>Plant</Name></PropertyGroup>
<ItemGroup><Compile Include="Suite.st"/></ItemGroup></Project>
"""
SUITE = """\
FUNCTION_BLOCK Suite EXTENDS TcUnit.FB_TestSuite
TEST('runs'); AssertTrue(TRUE, 'Timeout in test'); (* TEST 'x' *) TEST_FINISHED();
END_FUNCTION_BLOCK
"""


@pytest.mark.parametrize("path", [".", "Plant", "Plant/Plant.plcproj", "Plant/../Plant", "link"])
def test_suites_are_found_by_any_form_of_a_path(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, path: str) -> None:
    (tmp_path / "Plant").mkdir()
    written(tmp_path / "Plant", Suite=SUITE)
    (tmp_path / "Plant" / "Plant.plcproj").write_text(PROJECT)
    (tmp_path / "link").symlink_to(tmp_path / "Plant", target_is_directory=True)
    monkeypatch.chdir(tmp_path)
    assert [one["name"] for one in as_json(Path(path))] == ["runs"]


@pytest.mark.parametrize(
    ("text", "is_test"),
    [
        ("TEST 'a' END_TEST", True),
        ("VAR_GLOBAL s : STRING := 'it$'s a test'; END_VAR TEST 'a' END_TEST", True),
        ("(* it's old *) TEST 'a' END_TEST", True),
        ("// don't\nTEST\n'a' END_TEST", True),
        ("VAR_GLOBAL s : STRING := 'Timeout in test'; END_VAR", False),
        ("VAR_GLOBAL s : STRING := 'a $' test'; t : STRING := 'test'; END_VAR", False),
        ('VAR_GLOBAL s : WSTRING := "a test"; END_VAR', False),
        ("(* TEST 'a' *) // TEST 'a'\n", False),
    ],
)
def test_the_word_in_a_text_or_comment_begins_no_test(tmp_path: Path, text: str, is_test: bool) -> None:
    written(tmp_path, a=text)
    assert has_tests(tmp_path / "a.st") is is_test


def test_a_report_in_the_folder_of_the_tests_is_no_test_file(folder: Path) -> None:
    for _ in range(2):
        done = iec_test(folder, "--junit", folder / "report.xml")
        assert done.stdout.splitlines()[-1].startswith("4 tests: 2 passed, 1 failed, 1 skipped in ")
