"""Scenarios in Python: the steps and properties of a scenario file, and the same judge.

trip = Scenario()
trip.set("feeder/g_bStart", True, at=100 * MS)
trip.fault("stepper", "trip", when="feeder/g_bBusy")
trip.never("wires/feeder.seal and not feeder/g_bHot")
trip.eventually("not feeder/g_bBusy", within=5 * S)
trip.run(rig)
"""

import sys
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from fieldrig.clock import MS, whole_ns
from fieldrig.device import Value
from fieldrig.errors import ArgumentError, UnmetError
from fieldrig.faults.words import fault_of_words, split_words
from fieldrig.outside.untrusted import shown
from fieldrig.system.stopwatch import Stopwatch
from fieldrig_devices.scenarios.act import Act, Verb
from fieldrig_devices.scenarios.expression import Expression, expression_of
from fieldrig_devices.scenarios.property import Kind, Property
from fieldrig_devices.scenarios.report import Outcome, failures
from fieldrig_devices.scenarios.scenario_file import Scenario as Checked
from fieldrig_devices.scenarios.scenario_file import length_of

if TYPE_CHECKING:
    from fieldrig.real.live_rig import LiveRig
    from fieldrig.virtual.branch import Branch
    from fieldrig.virtual.rig import Rig

HOLD_NS: Final = 100 * MS


class Scenario:
    """A scenario: steps that happen to a rig, and properties that have to hold.  Times are nanoseconds from its begin.

    Each step has an instant `at`, or waits for a milestone: `when` is a condition, which has become true for the
    `nth` time; `at` counts from then.  ArgumentError, with what was expected, for a wrong argument.
    """

    def __init__(self, length: int | None = None) -> None:
        """`length` is its duration; without one it is enough for the last step and the longest time of a property."""
        self._length_ns = None if length is None else _time(length, "length")
        self._acts: list[Act] = []
        self._properties: list[Property] = []

    def set(self, place: str, value: Value, *, at: int = 0, when: str = "", nth: int = 1) -> None:
        """Write a point of a device, or a wire."""
        self._add("set", place, value, at, when, nth)

    def press(
        self, place: str, value: Value = True, *, hold: int = HOLD_NS, at: int = 0, when: str = "", nth: int = 1
    ) -> None:
        """Write it, and after `hold` nanoseconds what was there before."""
        self._add("press", place, value, at, when, nth, _time(hold, "hold"))

    def fault(self, where: str, fault: str | Mapping[str, Any], *, at: int = 0, when: str = "", nth: int = 1) -> None:
        """Add a fault of a bus or device: a mapping, or words such as `trip duration_ms=300`."""
        try:
            given = fault_of_words(split_words(fault)) if isinstance(fault, str) else dict(fault)
        except (TypeError, ValueError) as wrong:
            raise ArgumentError(
                f"{shown(fault)} is no fault: {wrong}", "expected such as trip duration_ms=300"
            ) from wrong
        self._add("fault", where, given, at, when, nth)

    def clear(self, where: str, *, at: int = 0, when: str = "", nth: int = 1) -> None:
        """End all faults of a bus or device."""
        self._add("clear", where, None, at, when, nth)

    def restart(self, device: str, *, at: int = 0, when: str = "", nth: int = 1) -> None:
        """Switch a device off and on."""
        self._add("restart", device, None, at, when, nth)

    def send(self, bus: str, message: str, *, at: int = 0, when: str = "", nth: int = 1) -> None:
        """Send a CAN frame, such as `000#0105`, or bytes of a serial line as hex digits."""
        self._add("send", bus, message, at, when, nth)

    def always(self, condition: str, *, after: str = "", longer: int | None = None, name: str = "") -> None:
        """Require that a condition is true all the time; it may be wrong for at most `longer`."""
        self._require(Kind.ALWAYS, condition, after, longer=longer, name=name)

    def never(self, condition: str, *, after: str = "", longer: int | None = None, name: str = "") -> None:
        """Require that a condition is never true, or for at most `longer`."""
        self._require(Kind.NEVER, condition, after, longer=longer, name=name)

    def expect(self, condition: str, *, within: int, after: str = "", name: str = "") -> None:
        """Require that a condition becomes true within a time of each instant at which `after` does."""
        self._require(Kind.WITHIN, condition, after, longer=within, name=name)

    def stays(self, condition: str, *, until: str, after: str = "", within: int | None = None, name: str = "") -> None:
        """Require that a condition is true until another one is, which has to come `within` a time if there is one."""
        self._require(Kind.STAYS, condition, after, until, within, name)

    def eventually(self, condition: str, *, within: int, name: str = "") -> None:
        """Require that a condition becomes true within a time after the last step, when no fault is left."""
        self._require(Kind.EVENTUALLY, condition, "", longer=within, name=name)

    def play(self, rig: "Rig | Branch | LiveRig") -> Outcome:
        """Play it to a rig from the present instant on, and return the outcome, whatever it is.

        A LiveRig plays it in real time.  RigError for what the rig does not have.
        """
        if not self._properties:
            raise ArgumentError("the scenario requires nothing", 'expected such as scenario.never("tank/overflow")')
        watch, caller, scenario = Stopwatch(), sys._getframe(1), self._checked()
        while caller.f_code.co_filename == __file__ and caller.f_back is not None:
            caller = caller.f_back
        return Outcome(Path(caller.f_code.co_filename), scenario, _played(rig, scenario), watch.seconds)

    def run(self, rig: "Rig | Branch | LiveRig", picture: str | Path | None = None) -> Outcome:
        """Play it, and return the outcome.  UnmetError, with every reason, if a property does not hold.

        `picture` is the SVG file of its signals, which is written in either case.
        """
        outcome = self.play(rig)
        if picture is not None:
            outcome.write_picture(picture)
        wrong = failures(outcome)
        if wrong:
            more = [f"and {name}: {reason}" for name, reason in wrong[1:]]
            raise UnmetError("\n".join([f"{wrong[0][0]}: {wrong[0][1]}", *more]))
        return outcome

    def _checked(self) -> Checked:
        schedule, rules = tuple(self._acts), tuple(self._properties)
        length_ns = length_of(schedule, rules) if self._length_ns is None else self._length_ns
        return Checked(Path(), (), 0, length_ns, schedule, (), rules)

    def _add(self, verb: Verb, where: str, value: Any, at: int, when: str, nth: int, hold_ns: int = 0) -> None:
        if not isinstance(where, str) or not where:
            raise ArgumentError(f"{verb} cannot take {shown(where)}", 'expected a name, such as "tank/level"')
        if verb in ("set", "press") and not isinstance(value, bool | int | float | str):
            raise ArgumentError(f"{where} cannot be {shown(value)}", "expected a level, a number or a text")
        if type(nth) is not int or nth < 1 or (nth > 1 and not when):
            raise ArgumentError(f"nth cannot be {shown(nth)}", "expected how often `when` has to become true")
        text = _expression(when, "when").text if when else ""
        self._acts.append(Act(_time(at, "at"), verb, where, value, hold_ns, text, nth))

    def _require(
        self, kind: Kind, condition: str, after: str, until: str = "", longer: int | None = None, name: str = ""
    ) -> None:
        chosen = name or f"{_WORDS[kind]} {condition}{f' after {after}' if after else ''}"
        if any(one.name == chosen for one in self._properties):
            raise ArgumentError(f"there are two properties {chosen!r}", "give one of them another name")
        self._properties.append(
            Property(
                chosen,
                kind,
                _expression(condition, "the condition"),
                _expression(after, "after") if after else None,
                _expression(until, "until") if kind is Kind.STAYS else None,
                None if longer is None else _time(longer, "the time"),
            )
        )


_WORDS: Final = {kind: "expect" if kind is Kind.WITHIN else kind.value for kind in Kind}


def _played(rig: "Rig | Branch | LiveRig", scenario: Checked) -> Any:
    from fieldrig.real.live_rig import LiveRig
    from fieldrig.virtual.branch import Branch
    from fieldrig.virtual.rig import Rig
    from fieldrig_devices.scenarios.running import played_live, played_virtual

    if isinstance(rig, LiveRig):
        return played_live(rig, scenario)
    if isinstance(rig, Branch):
        return rig.call(played_virtual, scenario)
    if isinstance(rig, Rig):
        return played_virtual(rig, scenario)
    raise ArgumentError(f"a scenario cannot be played to {shown(rig)}", "expected a Rig, a Branch or a LiveRig")


def _expression(text: str, what: str) -> Expression:
    try:
        return expression_of(text)
    except (TypeError, ValueError) as wrong:
        problem, _, remedy = str(wrong).partition("\n")
        raise ArgumentError(f"{what} {shown(text)}: {problem}", remedy or "expected a condition as a text") from wrong


def _time(ns: int, what: str) -> int:
    try:
        found = whole_ns(ns)
    except TypeError as wrong:
        raise ArgumentError(f"{what} cannot be {shown(ns)}", "expected nanoseconds, such as 100 * MS") from wrong
    if found < 0:
        raise ArgumentError(f"{what} cannot be {shown(ns)}", "expected a time that is not negative")
    return found
