"""Answers to `debug` questions: what an editor or a command line asks about a program.

A question is an object {"command": NAME, ...}, and the answer is an object.  The commands follow the Debug Adapter
Protocol, so that an adapter for an editor only translates.  The asker waits by asking for `state`, which has a count of
stops: it grows whenever a thread stops at a breakpoint, after a step, or because of a fault.
"""

from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import asdict
from math import nan
from operator import itemgetter
from typing import Any, Final

from fieldrig.clock import Clock
from fieldrig.device import Point, Value
from fieldrig.outside.untrusted import MalformedError, field, items, shown, typed
from fieldrig_devices.languages.debugging.breakpoints import Breakpoints
from fieldrig_devices.languages.debugging.debuggee import (
    Debuggee,
    Frame,
    ProgramState,
    Reset,
    Step,
    ThreadView,
    Variable,
)
from fieldrig_devices.languages.debugging.probes import MOST_PROBES, Place, Probes, Search
from fieldrig_devices.languages.debugging.probes import shown as found_shown
from fieldrig_devices.languages.debugging.stepping import Stepping
from fieldrig_devices.languages.debugging.stops import Stop
from fieldrig_devices.languages.debugging.texts import shown as shown_value

MOST_NAMES: Final = 1_000
MOST_BREAKPOINTS: Final = 1_000
MOST_WATCHED: Final = 16
MOST_LOGGED: Final = 1_000
"""Texts of breakpoints that wait to be read; the oldest ones are given up."""
MOST_FILES: Final = 1_000
LONGEST_DOWNLOAD: Final = 8 << 20
"""Longest source of a download in characters, over all of its parts."""

PROGRAM: Final = "program:"
"""Begins the keys of points that are variables of the program by the names that the debugger has for them."""

Answer = dict[str, Any]


class DebugService:
    """The debugging service of one device."""

    def __init__(self, clock: Clock, debuggee: Debuggee) -> None:
        self._clock, self._debuggee = clock, debuggee
        self._stops = self._loads = 0
        self._places = Breakpoints()
        self._parts: dict[str, str] = {}
        self._probes = Probes(clock, debuggee)
        self._stopped_ns = 0
        self._unknown: dict[int, str] = {}
        """Why the condition at which a thread stands has no value, by threads."""
        self._log: deque[Answer] = deque(maxlen=MOST_LOGGED)
        """The texts of log points with their numbers."""
        self._stepping: Stepping | None = None
        debuggee.on_stop, debuggee.on_load = self._on_stop, self._on_load
        self._commands: dict[str, Callable[[Mapping[str, Any]], Answer]] = {
            "state": self._state,
            "files": self._files,
            "source": self._source,
            "breakpoints": self._breakpoints,
            "logged": self._logged,
            "start": lambda _: self._do(debuggee.start),
            "stop": lambda _: self._do(debuggee.stop),
            "reset": self._reset,
            "pause": self._pause,
            "continue": lambda _: self._do(debuggee.go_on),
            "step": self._step,
            "stack": self._stack,
            "variables": self._variables,
            "read": self._read,
            "write": self._write,
            "force": self._force,
            "release": self._release,
            "forced": self._forced,
            "part": self._part,
            "download": self._download,
            "watch": self._watch,
            "probe": self._probe,
            "found": self._found,
        }

    def point(self, key: str) -> Point | None:
        """Return the point `program:NAME` of a variable or an expression; None for another key or an unknown name."""
        name = key.removeprefix(PROGRAM)
        if name == key:
            return None
        try:
            read = self._reader(name)
        except ValueError:
            return None

        def present() -> Value:
            value = read()
            return nan if value is None else value

        return Point(present)

    def _reader(self, name: str) -> Callable[[], Value | None]:
        """Return a function for the value; None where there is none, as after a download or the end of a call."""
        if self._debuggee.evaluate(name).value is None:
            raise ValueError(f"{shown(name)} is a group of values\nexpected a single value")
        return self._debuggee.reader(name)

    def answer(self, message: Any) -> Answer:
        """Answer one question.  ValueError, saying what was expected, if it is not understood or not possible now."""
        command = field(message, "command", str)
        action = self._commands.get(command)
        if action is None:
            raise ValueError(f"there is no command {shown(command)}\nexpected {', '.join(self._commands)}")
        return action(message)

    # ---- the program

    def _state(self, _: Mapping[str, Any]) -> Answer:
        debuggee = self._debuggee
        return {
            "language": debuggee.language,
            "state": debuggee.state.value,
            "stops": self._stops,
            "loads": self._loads,
            "logged": self._log[-1]["number"] if self._log else 0,
            "progress": debuggee.progress,
            "problem": debuggee.problem,
            "now_ns": self._clock.now_ns(),
            "stopped_ns": self._stopped_ns,
            "threads": [
                {**asdict(thread), "state": thread.state.value, **self._why(thread)} for thread in debuggee.threads()
            ],
        }

    def _why(self, thread: ThreadView) -> Answer:
        """Return why a thread has stopped, if that was a data breakpoint or a condition that has no value."""
        if thread.state is not ProgramState.PAUSED:
            return {}
        change, wrong = self._probes.stopped.get(thread.number), self._unknown.get(thread.number)
        if change is not None:
            return {"about": change, "change": change}
        return {} if wrong is None else {"about": wrong}

    def _files(self, _: Mapping[str, Any]) -> Answer:
        return {"files": list(self._debuggee.files)}

    def _source(self, message: Mapping[str, Any]) -> Answer:
        name = field(message, "file", str)
        text = self._debuggee.files.get(name)
        if text is None:
            raise ValueError(
                f"there is no file {shown(name)}\nexpected {', '.join(self._debuggee.files) or 'a program'}"
            )
        return {"text": text}

    def _reset(self, message: Mapping[str, Any]) -> Answer:
        kind = choice(Reset, message.get("kind", Reset.WARM.value), "kind")
        return self._do(lambda: self._debuggee.reset(kind))

    def _do(self, action: Callable[[], None]) -> Answer:
        self._stepping = None
        action()
        return {"state": self._debuggee.state.value}

    # ---- places

    def _breakpoints(self, message: Mapping[str, Any]) -> Answer:
        """Replace the breakpoints of one file, or only say where they are; without a file, those of all.

        A line without an instruction is not in `lines`.  With `move`, its breakpoint is at the line where its statement
        begins, or else at the next line with an instruction: `places` are the lines in the order of the question, null
        for one behind the last instruction.  With `lines` instead of breakpoints, the answer is where those would be,
        and nothing changes.  `moves` are the lines after the last load by those before.
        """
        if "file" not in message:
            known = sorted(self._places.stops.items(), key=itemgetter(0))
            return {"breakpoints": [{"file": file, "line": line, **asdict(stop)} for (file, line), stop in known]}
        name = field(message, "file", str)
        if "lines" in message:
            lines = items(message["lines"], int, MOST_BREAKPOINTS, "lines")
            return {"places": self._places.where(self._debuggee, name, lines)}
        if "breakpoints" not in message:
            moves = {str(line): after for (file, line), after in self._places.moves.items() if file == name}
            return {"lines": sorted(self._places.lines(name)), "moves": moves}
        asked = [
            (field(entry, "line", int), _stop_of(entry))
            for entry in items(field(message, "breakpoints", list), dict, MOST_BREAKPOINTS, "breakpoints")
        ]
        if not typed(message.get("move", False), bool, "move"):
            return {"lines": sorted(self._places.replace(self._debuggee, name, dict(asked)))}
        moved = self._places.next_lines(self._debuggee, name, {line for line, _ in asked})
        wanted = {after: stop for line, stop in asked if (after := moved[line]) is not None}
        lines = sorted(self._places.replace(self._debuggee, name, wanted))
        return {"lines": lines, "places": [moved[line] for line, _ in asked]}

    def _logged(self, message: Mapping[str, Any]) -> Answer:
        """Return what breakpoints have logged, from the entry behind the number `after` on, as far as it is kept."""
        after = typed(message.get("after", 0), int, "after")
        return {"entries": [entry for entry in self._log if entry["number"] > after]}

    def _on_load(self) -> None:
        self._loads += 1
        self._stepping = None
        self._places.reload(self._debuggee)
        self._probes.reload()

    def _pause(self, _: Mapping[str, Any]) -> Answer:
        """Pause the program, which is a stop as at a breakpoint."""
        self._debuggee.pause()
        if self._debuggee.state is ProgramState.PAUSED:
            self._count_stop()
        return {"state": self._debuggee.state.value}

    def _step(self, message: Mapping[str, Any]) -> Answer:
        kind = choice(Step, message.get("kind", Step.INTO.value), "kind")
        thread = self._thread(message)
        at = self._debuggee.at(thread)

        def begin() -> None:
            self._stepping = Stepping(thread, kind, at) if at is not None else None
            self._debuggee.step(thread, kind)

        return self._do(begin)

    def _stack(self, message: Mapping[str, Any]) -> Answer:
        return {"frames": [asdict(frame) for frame in self._debuggee.stack(self._thread(message))]}

    def _thread(self, message: Mapping[str, Any]) -> int:
        """Return the thread that a question is about: the one that is paused, if the question names none."""
        threads = self._debuggee.threads()
        numbers = [thread.number for thread in threads]
        if "thread" in message:
            number = field(message, "thread", int)
            if number not in numbers:
                raise ValueError(f"there is no thread {number}\nexpected {', '.join(map(str, numbers)) or 'a program'}")
            return number
        stopped = [thread.number for thread in threads if thread.state in (ProgramState.PAUSED, ProgramState.FAILED)]
        if not stopped and not numbers:
            raise ValueError("there is no program\nexpected a download first")
        return (stopped or numbers)[0]

    def _on_stop(self) -> None:
        """Count the stop, unless it is a breakpoint that lets the program run on, and a step go on."""
        self._unknown.clear()
        paused = [thread for thread in self._debuggee.threads() if thread.state is ProgramState.PAUSED]
        if len(paused) == 1:
            thread = paused[0].number
            if not self._probes.takes_stop(thread) and self._passes(thread):
                return
        self._count_stop()

    def _passes(self, thread: int) -> bool:
        """Let a thread run on from a breakpoint at which it does not stop; false if it stops."""
        debuggee, frame = self._debuggee, self._debuggee.stack(thread)[0]
        stop, at, step = self._places.stops.get((frame.file, frame.line)), debuggee.at(thread), self._stepping
        if at is not None and not at.is_beginning:
            stop = None  # that of the line was passed at its beginning
        if stop is not None and self._stops_at(stop, thread, frame):
            return False
        if step is None or step.thread != thread or at is None:
            if stop is not None:
                debuggee.go_on()
            return stop is not None
        if step.is_done(at, is_at_breakpoint=stop is not None):
            return False
        debuggee.step(thread, step.part_from(at))
        return True

    def _stops_at(self, stop: Stop, thread: int, frame: Frame) -> bool:
        """Return whether a thread stops at a breakpoint; what one logs instead is noted."""
        if stop.condition and not self._holds(stop.condition, thread):
            return False
        if thread in self._unknown:
            return True
        if not stop.is_due():
            return False
        if stop.log:
            text = stop.text(lambda name: self._text_of(name, thread))
            number = self._log[-1]["number"] + 1 if self._log else 1
            place = {"file": frame.file, "line": frame.line, "thread": thread, "at_ns": self._clock.now_ns()}
            self._log.append({"number": number, "text": text, **place})
        return not stop.log

    def _text_of(self, name: str, thread: int) -> str:
        value = self._value_of(name, thread)
        return f"{{{name}: {value['error'].partition(chr(10))[0]}}}" if "error" in value else shown_value(value)

    def _count_stop(self) -> None:
        self._stepping = None
        self._stops += 1
        self._stopped_ns = self._clock.now_ns()

    def _holds(self, condition: str, thread: int) -> bool:
        """A condition that cannot be evaluated stops the program, so that its author notices."""
        try:
            return self._debuggee.evaluate(condition, thread).value is not False
        except ValueError as wrong:
            reason = str(wrong).replace("\n", ": ")
            self._unknown[thread] = f"its condition {condition} has no value here: {reason}"
            return True

    # ---- values

    def _variables(self, message: Mapping[str, Any]) -> Answer:
        path = typed(message.get("path", ""), str, "path")
        return {"variables": [_shown(variable) for variable in self._debuggee.variables(path)]}

    def _read(self, message: Mapping[str, Any]) -> Answer:
        """Read variables or expressions; one that cannot be read has an `error` instead of a value."""
        names = items(field(message, "names", list), str, MOST_NAMES, "names")
        thread = self._thread(message) if "thread" in message else None
        frame = typed(message.get("frame", 0), int, "frame")
        return {"variables": [self._value_of(name, thread, max(frame, 0)) for name in names]}

    def _value_of(self, name: str, thread: int | None, frame: int = 0) -> Answer:
        try:
            return _shown(self._debuggee.evaluate(name, thread, frame))
        except ValueError as wrong:
            return {"path": name, "name": name, "error": str(wrong)}

    def _write(self, message: Mapping[str, Any]) -> Answer:
        return self._each_value(message, self._debuggee.write)

    def _force(self, message: Mapping[str, Any]) -> Answer:
        return self._each_value(message, self._debuggee.force)

    def _release(self, message: Mapping[str, Any]) -> Answer:
        names = items(field(message, "names", list), str, MOST_NAMES, "names")
        for name in names:
            self._debuggee.force(name, None)
        return {"variables": [self._value_of(name, None) for name in names]}

    def _forced(self, _: Mapping[str, Any]) -> Answer:
        return {"variables": [_shown(variable) for variable in self._debuggee.forced()]}

    def _each_value(self, message: Mapping[str, Any], action: Callable[[str, Value], None]) -> Answer:
        values = field(message, "values", dict)
        if len(values) > MOST_NAMES:
            raise MalformedError(f"values: {len(values)}, expected at most {MOST_NAMES}")
        for name, value in values.items():
            if not isinstance(value, bool | int | float | str):
                raise MalformedError(f"{shown(name)}: expected a number, a text, true or false, got {shown(value)}")
            action(name, value)
        return {"variables": [self._value_of(name, None) for name in values]}

    # ---- data breakpoints, and the past

    def _watch(self, message: Mapping[str, Any]) -> Answer:
        """Replace the data breakpoints: the program stops where one of these variables gets another value.

        Without `names` it says which there are.
        """
        if "names" in message:
            self._probes.watch(list(dict.fromkeys(items(message["names"], str, MOST_WATCHED, "names"))))
        return {"names": list(self._probes.names)}

    def _probe(self, message: Mapping[str, Any]) -> Answer:
        """Begin a search of the given name in what runs from now on; with `stop_at`, stop where it found something.

        `places` and `names` are breakpoints and variables that get another value; `thread` and `depth` instead stand
        for lines of a thread with at most that number of callers.  Without a name, the answer has the names of the
        stops that are due; those in `over` are not due any more.  A stop of another name stays, as where the past is
        repeated on the way to it.
        """
        if "probe" not in message:
            self._probes.end(items(message.get("over", []), str, MOST_PROBES, "over"))
            return {"due": self._probes.due}
        name = field(message, "probe", str)
        if "stop_at" in message:
            self._probes.aim(name, field(message, "stop_at", int))
            return {}
        places = [
            Place(
                field(each, "file", str), field(each, "line", int), typed(each.get("condition", ""), str, "condition")
            )
            for each in items(message.get("places", []), dict, MOST_BREAKPOINTS, "places")
        ]
        names = items(message.get("names", []), str, MOST_WATCHED, "names")
        thread = field(message, "thread", int) if "thread" in message else None
        self._probes.search(name, Search(places, names, thread, typed(message.get("depth", 0), int, "depth")))
        return {}

    def _found(self, message: Mapping[str, Any]) -> Answer:
        """Return what a search has found last."""
        name = field(message, "probe", str)
        thread = self._probes.reached_by(name)  # others may have stood before
        states = {one.number: one.state for one in self._debuggee.threads()}
        is_there = thread is not None and states.get(thread) is ProgramState.PAUSED
        return {**found_shown(self._probes.found(name)), "is_there": is_there}

    # ---- download

    def _part(self, message: Mapping[str, Any]) -> Answer:
        """Take a part of a file; `is_first` begins the file again, and without a file all parts are forgotten."""
        if "file" not in message:
            self._parts.clear()
            return {"files": 0}
        name, text = field(message, "file", str), field(message, "text", str)
        before = "" if message.get("is_first", False) else self._parts.get(name, "")
        if sum(map(len, self._parts.values())) + len(text) > LONGEST_DOWNLOAD or len(self._parts) >= MOST_FILES:
            self._parts.clear()
            raise ValueError(
                f"the program is too long\nexpected at most {LONGEST_DOWNLOAD} characters in {MOST_FILES} files"
            )
        self._parts[name] = before + text
        return {"files": len(self._parts)}

    def _download(self, message: Mapping[str, Any]) -> Answer:
        """Load the files whose parts have arrived."""
        is_online = typed(message.get("online", False), bool, "online")
        if not self._parts:
            raise ValueError("there is nothing to download\nexpected `part` before it")
        files, self._parts = self._parts, {}
        return self._do(lambda: self._debuggee.download(files, is_online=is_online))


def _shown(variable: Variable) -> Answer:
    return asdict(variable)


def choice(choices: Any, value: Any, name: str) -> Any:
    known = {choice.value: choice for choice in choices}
    if not isinstance(value, str) or value not in known:
        raise MalformedError(f"{name}: expected {', '.join(known)}, got {shown(value)}")
    return known[value]


def _stop_of(entry: Mapping[str, Any]) -> Stop:
    """Return the breakpoint that an entry of a question means."""
    condition, hits, log = (typed(entry.get(name) or "", str, name) for name in ("condition", "hits", "log"))
    return Stop(condition, hits, log)
