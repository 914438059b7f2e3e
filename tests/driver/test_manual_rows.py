"""`@pytest.mark.manual` and its report, in pytest runs of their own."""

from pathlib import Path

import pytest
from manual_rows import FILE, Row, RowList, spans

pytest_plugins = ["pytester"]

ROWS = """
[rows]
ARP = ["1-3", "5-6"]
PD = ["10"]

[aside]
ARP-003 = "reserved"
"""


@pytest.fixture
def project(pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch) -> pytest.Pytester:
    # Every inner run imports its plugins again; with more than it needs, it would take a second.
    monkeypatch.setenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD", "1")
    monkeypatch.setenv("PYTEST_ADDOPTS", "-p manual_rows --manual-rows-file=rows.toml")
    pytester.makefile(".toml", rows=ROWS)
    pytester.makeini("[pytest]\nmarkers = manual(row): a row of a manual")
    return pytester


def make_tests(project: pytest.Pytester, body: str) -> None:
    project.makepyfile(f"import pytest\nmanual = pytest.mark.manual\n{body}")


@pytest.mark.long
def test_rows_shown_not_shown_and_set_aside_are_distinguished(project: pytest.Pytester) -> None:
    make_tests(
        project,
        """
@manual("ARP-001")
def test_passes(): pass

@manual("ARP-002")
def test_fails(): assert False

@manual("ARP-002")
def test_passes_for_the_same_row(): pass

@manual("ARP-005")
def test_is_skipped(): pytest.skip("not here")

@manual("ARP-006", "PD-010")
def test_shows_two(): pass
""",
    )
    result = project.runpytest("--manual-rows")
    result.stdout.fnmatch_lines(
        [
            "ARP: 5 rows, 2 shown, 2 not shown, 1 set aside",
            "  shown:     001, 006",
            "  not shown: 002, 005",
            "  set aside: 003 reserved",
            "PD: 1 rows, 1 shown, 0 not shown, 0 set aside",
            "  shown:     010",
        ]
    )


@pytest.mark.parametrize("text", ["ARP-004", "ARP-7", "XY-001", "arp-001"])
def test_unknown_row_is_an_error_at_collection(project: pytest.Pytester, text: str) -> None:
    make_tests(project, f"@manual({text!r})\ndef test_shows_it(): pass")
    result = project.runpytest("--collect-only")
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    result.stderr.fnmatch_lines([f"*test_shows_it: *{text}*"])


def test_without_the_option_nothing_is_reported(project: pytest.Pytester) -> None:
    make_tests(project, "@manual('ARP-001')\ndef test_shows_it(): pass")
    result = project.runpytest()
    result.assert_outcomes(passed=1)
    result.stdout.no_fnmatch_line("*rows of the manuals*")


def test_that_no_test_shows_a_row_is_a_report_and_no_failure(project: pytest.Pytester) -> None:
    make_tests(project, "def test_shows_none(): pass")
    outcome = project.runpytest("--manual-rows", "-m", "manual")
    outcome.stdout.fnmatch_lines(["*not shown*"])
    assert outcome.ret == pytest.ExitCode.OK


@pytest.mark.long
def test_a_row_shown_in_a_worker_of_xdist_counts(project: pytest.Pytester) -> None:
    make_tests(project, "@manual('PD-010')\ndef test_shows_it(): pass")
    result = project.runpytest("-pxdist", "-n1", "--manual-rows")
    result.stdout.fnmatch_lines(["PD: 1 rows, 1 shown, 0 not shown, 0 set aside"])


def test_row_list_reads_numbers_and_spans(tmp_path: Path) -> None:
    path = tmp_path / "rows.toml"
    path.write_text(ROWS)
    row_list = RowList.load(path)
    assert row_list.rows == {Row("ARP", 1), Row("ARP", 2), Row("ARP", 3), Row("ARP", 5), Row("ARP", 6), Row("PD", 10)}
    assert row_list.aside == {Row("ARP", 3): "reserved"}


@pytest.mark.parametrize(
    ("aside", "reason"),
    [
        ('ARP-004 = "reserved"', "set aside, but not among the rows: ARP-004"),
        ('ARP-002 = ""', "without a reason: ARP-002"),
    ],
)
def test_row_list_that_contradicts_itself_is_refused(tmp_path: Path, aside: str, reason: str) -> None:
    path = tmp_path / "rows.toml"
    path.write_text(f"{ROWS}{aside}\n")
    with pytest.raises(ValueError, match=reason):
        RowList.load(path)


def test_spans_join_neighbours() -> None:
    assert spans([Row("PD", number) for number in (400, 3, 1, 2, 9, 10)]) == "001-003, 009-010, 400"


def test_the_rows_of_our_manuals(request: pytest.FixtureRequest) -> None:
    row_list = RowList.load(request.config.rootpath / FILE)
    counts = {
        manual: sum(row.manual == manual for row in row_list.rows) for manual in ("ARP", "PD", "PAML", "PAMS", "SCU")
    }
    assert counts == {"ARP": 122, "PD": 285, "PAML": 317, "PAMS": 112, "SCU": 100}
