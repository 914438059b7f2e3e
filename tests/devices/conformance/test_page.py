"""The results in the documentation are those of the suite."""

import pytest
from conformance_page import CASES_PAGE, PAGE, case_table, columns, family_table, table_in

HINT = "python tests/support/conformance_page.py updates it"


@pytest.mark.long
def test_tables_are_those_of_a_run() -> None:
    assert table_in(PAGE) == family_table(), HINT
    assert table_in(CASES_PAGE) == case_table(), HINT


@pytest.mark.long
def test_published_figures_of_canopennode_add_up() -> None:
    verdicts = list(columns()["CANopenNode"].values())
    counts = [verdicts.count(verdict) for verdict in ("passed", "skipped", "failed", "warning")]
    assert counts == [85, 36, 5, 1]
