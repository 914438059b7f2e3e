"""Runs cases one after the other, and leaves the node as it was.

After each case, its changes are undone, the node returns to 'pre-operational', and if the case has stored parameters,
the previous ones are stored again.  After the last case, all parameters are compared with those before the first.

A run always ends: each wait has its limit, and a node that is silent even after a reset fails the cases that remain.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from enum import Enum

from fieldrig.errors import RigError
from fieldrig.points.values import counted
from fieldrig_devices.conformance import nmt, store
from fieldrig_devices.conformance.bench import Bench, show
from fieldrig_devices.conformance.case import Case
from fieldrig_devices.conformance.line import Seen, Steps
from fieldrig_devices.conformance.nmt import Command, State
from fieldrig_devices.conformance.other_masters import foreign
from fieldrig_devices.conformance.put_back import Snapshot
from fieldrig_devices.conformance.verdict import Failed, Lost, NoAnswer, NotApplicable, SdoFault

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
        self._task = "looking for the node"
        self._disturbed: list[str] = []
        """Names of the failed cases during which another master was at work."""
        self.notes: list[str] = []
        """Notes on the node's parameters at the end of the run."""

    def steps(self) -> Steps[None]:
        """Run the suite.  Raises RigError if the node doesn't answer at all."""
        bench = self.bench
        yield from nmt.enter(bench, State.PRE_OPERATIONAL)
        if not (yield from self._is_there()):
            raise RigError(f"node {bench.node_id} doesn't answer", "check the bus, the bit rate and the node-ID")
        self._task = "reading the parameters to restore"
        try:
            yield from self._snapshot.take(bench)
        except Lost as silence:
            what = f"node {bench.node_id} has stopped answering while its parameters were read: {silence}"
            raise RigError(what, "look at the node: it was only read") from silence
        self.notes += self._late()
        for number, case in enumerate(self._cases):
            self._task = f"{case.number} {case.name}"
            yield from self._run(case)
            if bench.sdo.unanswered and not (yield from self._is_there()):
                self._give_up(case, self._cases[number + 1 :])
                return
        yield from self._finish()

    def doing(self) -> str:
        """Return the present task and the last request, for a person who waits."""
        sdo = self.bench.sdo
        silence = f", {sdo.unanswered} of them without an answer at last" if sdo.unanswered else ""
        return f"{self._task}: {counted(sdo.requests, 'request')} until now{silence}; the last one is {sdo.asked}"

    def _is_there(self) -> Steps[bool]:
        """Wait for any answer of the node; the cases check whether it is right."""
        sdo = self.bench.sdo
        sdo.unanswered = 0
        for _ in range(TRIES):
            try:
                yield from sdo.ask(b"\x40\x00\x10\x00", "the device type")
            except NoAnswer:
                continue
            except SdoFault:
                pass
            return True
        return False

    def _give_up(self, last: Case, remaining: Sequence[Case]) -> None:
        """Fail the cases that a silent node would only let run into their time-outs."""
        node, now_ns = f"node {self.bench.node_id}", self.bench.line.clock.now_ns()
        expected, came = f"{node} to answer", f"nothing since case {last.number}, even after a reset"
        for case in remaining:
            reason = f"not run: expected {expected}; came {came}"
            self._on_result(Result(case, Verdict.FAILED, reason, expected, came, now_ns, now_ns))
        self.notes.append(
            f"{node} has stopped answering in case {last.number}, even after a reset: {len(remaining)} cases were not"
            " run, and its parameters may differ from those before"
        )

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
        others = foreign(bench.line.seen, bench.node_id)
        if others and result.verdict is Verdict.FAILED:
            self._disturbed.append(case.number)
            result.notes.append(f"another master sent {show(others[0])} meanwhile: the verdict may be its fault")
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
        self._task = "comparing the parameters with those before"
        if self._disturbed:
            self.notes.append(
                f"another master commanded node {bench.node_id} or asked it during failed cases"
                f" ({', '.join(self._disturbed)}): take it off the bus, and test again"
            )
        yield from nmt.enter(bench, State.PRE_OPERATIONAL)
        try:
            faults = yield from self._compare()
        except (SdoFault, Lost) as fault:
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
