"""Runs cases one after the other, and leaves the node as it was.

After each case, its changes are undone, the node returns to 'pre-operational', and if the case has stored parameters,
the previous ones are stored again.  After the last case, all parameters are compared with those before the first.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from enum import Enum

from fieldrig.errors import RigError
from fieldrig_devices.conformance import nmt, store
from fieldrig_devices.conformance.bench import Bench
from fieldrig_devices.conformance.case import Case
from fieldrig_devices.conformance.line import Seen, Steps
from fieldrig_devices.conformance.nmt import Command, State
from fieldrig_devices.conformance.put_back import Snapshot
from fieldrig_devices.conformance.verdict import Failed, NoAnswer, NotApplicable, SdoFault

TRIES = 3


class Verdict(Enum):
    """The result of a case of the conformance suite."""

    PASSED = "passed"
    WARNING = "warning"
    """The case passed, with a doubt."""
    FAILED = "failed"
    NOT_APPLICABLE = "not applicable"


@dataclass(slots=True)
class Result:
    case: Case
    verdict: Verdict
    reason: str = ""
    """Reason for the verdict: why the case is not applicable, or what was expected and what came."""
    expected: str = ""
    came: str = ""
    started_ns: int = 0
    ended_ns: int = 0
    frames: list[Seen] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    """Parameters that could not be restored, and answers that arrived too late."""
    remarks: list[str] = field(default_factory=list)
    """Remarks on the case itself, such as a different interpretation by CiA's tool."""


class Suite:
    def __init__(self, bench: Bench, cases: Sequence[Case], on_result: Callable[[Result], None]) -> None:
        self.bench, self._cases, self._on_result = bench, cases, on_result
        self._snapshot = Snapshot()
        self._put_back = 0
        self.notes: list[str] = []
        """Notes on the node's parameters at the end of the run."""

    def steps(self) -> Steps[None]:
        """Run the suite.  Raises RigError if the node doesn't answer at all."""
        bench = self.bench
        yield from nmt.enter(bench, State.PRE_OPERATIONAL)
        yield from self._find_node()
        yield from self._snapshot.take(bench)
        self.notes += self._late()
        for case in self._cases:
            yield from self._run(case)
        yield from self._finish()

    def _find_node(self) -> Steps[None]:
        """Wait for any answer of the node; the cases check whether it is right."""
        bench = self.bench
        for _ in range(TRIES):
            try:
                yield from bench.sdo.ask(b"\x40\x00\x10\x00", "the first request")
            except NoAnswer:
                continue
            except SdoFault:
                pass
            return
        what = f"node {bench.node_id} doesn't answer"
        raise RigError(what, "check the bus, the bit rate and the node-ID")

    def _run(self, case: Case) -> Steps[None]:
        bench, clock = self.bench, self.bench.line.clock
        bench.begin(case.name)
        result = Result(case, Verdict.PASSED, started_ns=clock.now_ns())
        try:
            yield from case.steps(bench)
        except NotApplicable as reason:
            result.verdict, result.reason = Verdict.NOT_APPLICABLE, str(reason)
        except Failed as fault:
            result.verdict, result.reason = Verdict.FAILED, str(fault)
            result.expected, result.came = fault.expected, fault.came
        except SdoFault as fault:
            result.verdict, result.reason = Verdict.FAILED, f"came {fault}"
            result.expected, result.came = "an SDO transfer to succeed", str(fault)
        if result.verdict is Verdict.PASSED and bench.warnings:
            result.verdict, result.reason = Verdict.WARNING, "; ".join(bench.warnings)
        result.frames, result.ended_ns = list(bench.line.seen), clock.now_ns()
        result.remarks = bench.remarks
        yield from bench.sdo.drain()
        result.notes = yield from self._tidy(result.verdict is Verdict.FAILED)
        result.notes = self._late() + result.notes
        self._on_result(result)

    def _tidy(self, has_failed: bool) -> Steps[list[str]]:
        """Clean up after a case; return notes on failures."""
        bench = self.bench
        try:
            if has_failed:
                bench.sdo.abort(0, 0)  # ends a transfer that may still be open
            if bench.is_moved:
                yield from nmt.enter(bench, State.PRE_OPERATIONAL)
            notes = yield from self._undo()
            if bench.is_upset:
                yield from nmt.restart(bench)
            if bench.is_stored:
                notes += yield from self._store_again()
        except (SdoFault, Failed) as fault:
            notes = [f"the node could not be restored: {fault}"]
            bench.send(nmt.NMT_ID, bytes((Command.RESET_NODE, bench.node_id)))
            yield from bench.expect(nmt.is_boot_up(bench), bench.options.boot_ms)
            yield from bench.settle()
        return notes

    def _late(self) -> list[str]:
        """Return the notes on late answers since the last call."""
        late, self.bench.sdo.late = self.bench.sdo.late, []
        return late

    def _undo(self) -> Steps[list[str]]:
        bench, notes = self.bench, list[str]()
        while bench.undo:
            index, sub, value = bench.undo.pop()
            try:
                yield from bench.sdo.write(index, sub, value)
            except NoAnswer:
                raise
            except SdoFault as fault:
                notes.append(f"{index:04X}h:{sub:02X}h could not be restored to {value.hex(' ')}: {fault}")
        return notes

    def _store_again(self) -> Steps[list[str]]:
        """Store the parameters again that the node's memory had before the case."""
        bench = self.bench
        notes = yield from self._compare()
        for sub in (store.ALL, store.COMMUNICATION):
            if bench.eds.get(store.STORE, sub) is not None:
                try:
                    yield from store.save(bench, sub)
                except NoAnswer:
                    raise
                except SdoFault as fault:
                    notes.append(str(fault))
                return notes
        return [*notes, "the stored parameters have their defaults, as the EDS has no 1010h to store them again"]

    def _finish(self) -> Steps[None]:
        bench = self.bench
        bench.begin()
        yield from nmt.enter(bench, State.PRE_OPERATIONAL)
        try:
            faults = yield from self._compare()
        except SdoFault as fault:
            self.notes.append(f"the node's parameters could not be compared with those before: {fault}")
            return
        how = f" ({self._put_back} values that a reset had changed were restored)" if self._put_back else ""
        self.notes += self._late()
        but = ", except those below" if faults else ""
        self.notes.append(f"the node has the same parameters as before{but}{how}; it is pre-operational")
        self.notes += faults

    def _compare(self) -> Steps[list[str]]:
        """Restore values that differ from those before the suite; return notes on failures."""
        count, faults = yield from self._snapshot.put_back(self.bench)
        self._put_back += count - len(faults)
        return faults
