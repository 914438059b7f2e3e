"""The tables of conformance.md and conformance-cases.md: `python tests/support/conformance_page.py` writes them again.

The I/O node's column comes from a run in virtual time, LocalNode's from what the tests in tests/real hold it to, and
CANopenNode's from the log that its authors published (CTT 3.0.3.10; Apache-2.0).
"""

from collections import Counter
from collections.abc import Iterator, Mapping
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path

from conform_bench import conformed
from conform_peers import LOCAL_NODE_FAILS, LOCAL_NODE_LACKS, UNSTABLE
from doc_pages import page_named

from fieldrig_devices.conformance.case import Case
from fieldrig_devices.conformance.run import choose

PAGE, CASES_PAGE = page_named("conformance.md"), page_named("conformance-cases.md")
BEGIN, END = "<!-- table -->\n", "<!-- end of table -->\n"
PASSED, FAILED, NOT_APPLICABLE = "passed", "failed", "not applicable"

SKIPPED_BY_CANOPENNODE = {
    "SDO": {"2.4", "2.11", "2.14", "2.20", "2.24", "2.27", "2.29", "2.30"},
    "PDO": {"3.3", "3.8", "3.9", "3.14", "3.15", "3.20", "3.24", "3.27", "3.31"},
    "OD": {"4.4", "4.5", "4.6"},
    "Guarding": {"7.1", "7.2", "7.3", "7.4", "7.5", "7.6"},
    "Heartbeat versus guarding": {"7.202", "7.203", "7.204", "7.205", "7.206", "7.207"},
    "Testing other": {"8.1", "8.2", "8.9", "8.10"},
}
FAILED_BY_CANOPENNODE = {"3.7", "3.22", "4.2", "4.8", "5.6"}
WARNED_BY_CANOPENNODE = {"1.0"}

Column = Mapping[str, str]
"""Verdicts, by number."""


def columns() -> dict[str, Column]:
    cases = choose(())
    return {
        "I/O node": {result.case.number: result.verdict.value for result in conformed().results},
        "LocalNode": {case.number: _local_node(case) for case in cases},
        "CANopenNode": {case.number: _canopennode(case) for case in cases},
    }


def family_table() -> str:
    return "\n".join(_by_family(columns())) + "\n"


def case_table() -> str:
    return "\n".join(_by_case(columns())) + "\n"


def table_in(page: Path) -> str:
    """The one between the marks, without the line on when it was made."""
    marked = page.read_text(encoding="utf-8").partition(BEGIN)[2].partition(END)[0]
    return marked.strip().partition("\n\n")[2] + "\n"


def write(page: Path, table: str) -> None:
    """Put a new table between the marks, with when and with what it was made."""
    made = f"{datetime.now(UTC).date().isoformat()}, fieldrig {version('fieldrig')}, canopen {version('canopen')}."
    before, _, rest = page.read_text(encoding="utf-8").partition(BEGIN)
    page.write_text(f"{before}{BEGIN}\n{made}\n\n{table}\n{END}{rest.partition(END)[2]}", encoding="utf-8")


def _by_family(nodes: Mapping[str, Column]) -> Iterator[str]:
    yield f"| family | cases | {' | '.join(nodes)} |"
    yield f"|---|---|{'---|' * len(nodes)}"
    families: dict[str, list[str]] = {}
    for case in choose(()):
        families.setdefault(case.family, []).append(case.number)
    families["**all**"] = [case.number for case in choose(())]
    for family, numbers in families.items():
        counts = [_counted(Counter(column[number] for number in numbers)) for column in nodes.values()]
        yield f"| {family} | {len(numbers)} | {' | '.join(counts)} |"


def _by_case(nodes: Mapping[str, Column]) -> Iterator[str]:
    yield f"| case | | requirement | clause | {' | '.join(nodes)} |"
    yield f"|---|---|---|---|{'---|' * len(nodes)}"
    for case in choose(()):
        verdicts = " | ".join(_emphasised(column[case.number]) for column in nodes.values())
        yield f"| {case.number} | {case.name} | {case.requirement} | {case.clause} | {verdicts} |"


def _counted(counts: Counter[str]) -> str:
    return ", ".join(f"{count} {verdict}" for verdict, count in sorted(counts.items(), key=lambda item: _rank(item[0])))


def _rank(verdict: str) -> int:
    return (PASSED, "warning", FAILED, NOT_APPLICABLE, "skipped").index(verdict)


def _emphasised(verdict: str) -> str:
    return f"**{verdict}**" if verdict == FAILED else verdict


def _local_node(case: Case) -> str:
    if case.number in LOCAL_NODE_FAILS.get(case.family, ()) or case.number in UNSTABLE:
        return FAILED
    return NOT_APPLICABLE if case.number in LOCAL_NODE_LACKS else PASSED


def _canopennode(case: Case) -> str:
    if case.number in SKIPPED_BY_CANOPENNODE.get(case.family, ()):
        return "skipped"
    if case.number in WARNED_BY_CANOPENNODE:
        return "warning"
    return FAILED if case.number in FAILED_BY_CANOPENNODE else PASSED


if __name__ == "__main__":
    write(PAGE, family_table())
    write(CASES_PAGE, case_table())
