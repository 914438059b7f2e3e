"""Processes of `-j N` that are ended from outside."""

import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import pytest

from fieldrig_devices.iec.testing.case import Case, Limits, Outcome, Verdict
from fieldrig_devices.iec.testing.parallel import run


@dataclass(frozen=True)
class Deadly:
    """A source of which one case kills the process that runs it."""

    names: tuple[str, ...]

    def cases(self) -> Sequence[Case]:
        return [Case(name, "deadly", Path("deadly.st"), line) for line, name in enumerate(self.names, 1)]

    def run(self, chosen: Sequence[Case], limits: Limits) -> Iterator[Outcome]:
        for case in chosen:
            if case.name == "kills":
                os._exit(9)
            yield Outcome(case, Verdict.PASSED)


@pytest.mark.long
@pytest.mark.parametrize("names", [("a", "b", "kills", "c"), ("kills",)])
def test_only_the_test_that_kills_its_process_is_an_error(names: tuple[str, ...]) -> None:
    sources = [Deadly(("first",)), Deadly(names), Deadly(("last",))]
    outcomes = list(run([(source, source.cases()) for source in sources], Limits(), 2))
    assert [outcome.case.name for outcome in outcomes] == ["first", *names, "last"]
    bad = [outcome for outcome in outcomes if outcome.verdict is not Verdict.PASSED]
    assert [(outcome.case.name, outcome.verdict) for outcome in bad] == [("kills", Verdict.ERROR)]
    assert "was ended from outside" in bad[0].failures[0].message
