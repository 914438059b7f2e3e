"""Suites of TcUnit in a text, run in virtual time."""

from collections.abc import Sequence
from pathlib import Path

from fieldrig_devices.iec.tcunit import report
from fieldrig_devices.iec.tcunit.bench import LONGEST_NS, Bench
from fieldrig_devices.iec.tcunit.project import Sources
from fieldrig_devices.iec.tcunit.session import Suite, Test
from fieldrig_devices.languages.source_file import SourceFile


def suite(body: str, declarations: str = "", methods: str = "", name: str = "Suite") -> str:
    """Return a suite and PRG_TEST with one instance of it, named `s`, which runs it."""
    block = f"FUNCTION_BLOCK {name} EXTENDS TcUnit.FB_TestSuite\nVAR\n{declarations}\nEND_VAR\n{body}\n{methods}"
    program = f"PROGRAM PRG_TEST\nVAR s : {name}; END_VAR\nTcUnit.RUN();\nEND_PROGRAM\n"
    return f"{block}\nEND_FUNCTION_BLOCK\n{program}"


class SuiteBench(Bench):
    """A bench for texts, each a file of its own."""

    def __init__(self, *texts: str, parameters: dict[str, str] | None = None) -> None:
        files = [SourceFile(f"part{number}.st", text) for number, text in enumerate(texts, 1)]
        listed = {("gvl_param_tcunit", key): value for key, value in (parameters or {}).items()}
        super().__init__(Sources(Path(), "tests", files, parameters=listed))

    @classmethod
    def ran(cls, *texts: str, parameters: dict[str, str] | None = None, longest_ns: int = LONGEST_NS) -> "SuiteBench":
        """Return a bench whose suites have finished, or have been given up."""
        bench = cls(*texts, parameters=parameters)
        assert not bench.program.left_out, bench.program.left_out
        bench.run(longest_ns)
        return bench

    @property
    def lines(self) -> Sequence[str]:
        return self.session.lines

    @property
    def suites(self) -> list[Suite]:
        return list(self.session.suites.values())

    def test(self, name: str) -> Test:
        """Return the test with a name, whatever its suite."""
        return next(suite.tests[name] for suite in self.suites if name in suite.tests)

    def summary(self) -> list[str]:
        return report.summary(self.session)
