"""The result of `fieldrig replay` for people and for build servers."""

from collections.abc import Sequence

import typer

from fieldrig.clock import S
from fieldrig.text.junit import Case, Failed, junit
from fieldrig_devices.replay.replay_result import MOST_KEPT, Difference, ReplayResult
from fieldrig_devices.replay.words import time_words

MOST_SHOWN = 200


def show(result: ReplayResult) -> None:
    """Print what is not compared, the differences, the notes, and a summary."""
    for text in result.left_out:
        typer.echo(f"left out: {text}")
    for each in result.differences[:MOST_SHOWN]:
        typer.echo(str(each))
    if result.count > MOST_SHOWN:
        typer.echo(f"and {result.count - MOST_SHOWN} more; --json and --junit have up to {MOST_KEPT}")
    for note in result.notes:
        typer.echo(f"note: {note}")
    shift = f"; the rig answered {time_words(result.shift_ns)} later in all" if result.shift_ns else ""
    typer.echo(f"{result.summary} in {result.duration_ns / S:.3f} s{shift}")


def to_junit(result: ReplayResult, log: str, rig: str) -> bytes:
    """Return a JUnit report: a case for each object, PDO or register of each node, with its differences."""
    cases: dict[tuple[str, str, str], list[Difference]] = {key: [] for key in result.by_subject}
    for each in result.differences:
        cases.setdefault(_case_of(each, cases), []).append(each)
    rows = [_junit_case(*key, differences) for key, differences in cases.items()]
    told = [*result.left_out, *result.notes]
    notes = [Case("notes", result.duration_ns / S, output="\n".join(told))] if told else []
    return junit(f"{log} played to {rig}", {log: [*rows, *notes]})


def _junit_case(bus: str, node: str, subject: str, differences: Sequence[Difference]) -> Case:
    failures = [Failed(str(differences[0]), "\n".join(map(str, differences)))] if differences else []
    return Case(f"{node} {subject}".strip(), failures=failures, classname=f"replay.{bus}")


def _case_of(each: Difference, cases: dict[tuple[str, str, str], list[Difference]]) -> tuple[str, str, str]:
    """Return the case that a difference belongs to: that of its object, or else one of its own."""
    exact = (each.bus, each.node, each.subject)
    if exact in cases:
        return exact
    return next((key for key in cases if key[:2] == exact[:2] and key[2] in each.words), exact)
