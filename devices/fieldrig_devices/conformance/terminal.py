"""The report on a terminal: a line per case while it runs, then the failures with their frames, then the totals."""

from rich.console import Console
from rich.table import Table
from rich.text import Text

from fieldrig_devices.conformance.report import Report, shown_frames
from fieldrig_devices.conformance.suite import Result, Verdict

STYLES = {Verdict.PASSED: "green", Verdict.WARNING: "yellow", Verdict.FAILED: "bold red", Verdict.NOT_APPLICABLE: "dim"}
MOST_FRAMES = 20
WIDTH = 10_000
"""Width of the output to a file, where no line is cut."""


def console() -> Console:
    made = Console(highlight=False, markup=False)
    if not made.is_terminal:
        made.width = WIDTH
    return made


def show_result(out: Console, result: Result) -> None:
    name = f"{result.case.number:>6} {result.case.name}".ljust(38)
    about = result.reason or result.case.requirement
    out.print(Text.assemble(name, (result.verdict.value.ljust(15), STYLES[result.verdict]), about), soft_wrap=True)
    for note in (*result.notes, *result.remarks):
        out.print(Text(f"{'':38}{note}", style="yellow"), soft_wrap=True)


def show_report(out: Console, report: Report) -> None:
    for result in report.of(Verdict.FAILED):
        _show_failure(out, result)
    out.print()
    out.print(_sums(report))
    for note in report.notes:
        out.print(note, soft_wrap=True)
    style = "bold red" if report.count(Verdict.FAILED) else "bold green"
    out.print(Text(f"\nnode {report.node_id}: {report.summary}", style=style), soft_wrap=True)


def _show_failure(out: Console, result: Result) -> None:
    case = result.case
    out.print(Text(f"\n{case.number} {case.name} failed", style="bold red"))
    for line in (case.requirement, case.clause, f"expected  {result.expected}", f"came      {result.came}"):
        out.print(f"  {line}", soft_wrap=True)
    for line in shown_frames(result, MOST_FRAMES):
        out.print(Text(f"    {line}", style="dim"), soft_wrap=True)


def _sums(report: Report) -> Table:
    table = Table("family", *(verdict.value for verdict in Verdict), box=None, pad_edge=False, header_style="bold")
    for family in report.families:
        counts = [report.count(verdict, family) for verdict in Verdict]
        table.add_row(family, *(str(count) if count else "" for count in counts))
    return table
