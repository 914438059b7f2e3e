"""A debugger for the program of any device with a debugging service, with one command per line.

It does not depend on a terminal: `do` executes a line and calls `say` with the output.  A KeyboardInterrupt during a
wait for the program pauses the program.  `ask` raises the errors of the connection.
"""

from collections.abc import Callable, Iterator, Sequence
from typing import Any, Final

from fieldrig.points.values import counted
from fieldrig.text.durations import duration_ns
from fieldrig_devices.languages.debugging import values
from fieldrig_devices.languages.debugging.adapter import Ask
from fieldrig_devices.languages.debugging.debugger_words import WORDS
from fieldrig_devices.languages.debugging.prompt import NotStoppedError
from fieldrig_devices.languages.debugging.sources import Place, Sources
from fieldrig_devices.languages.debugging.tracing import trace
from fieldrig_devices.languages.debugging.travel import Travel, changed
from fieldrig_devices.languages.debugging.words import count, limit, none

REACH: Final = 5
"""Number of lines shown above and below."""
LONGEST_START_S: Final = 20.0
"""Time that a device may need to have its program again after a reset, in seconds."""

STANDING: Final = ("paused", "failed")
"""The states of a task that has stopped in the middle of its program."""

Moments = Callable[[float | None], Iterator[object]]
"""Yields about 50 times a second, for a number of seconds; None means without end."""


_WORDS_OF_STOPS: Final = {"condition": "if", "hits": "at time", "log": "logs"}
"""The words in front of what a breakpoint has beside its place."""


class Debugger:
    """One session."""

    def __init__(
        self,
        ask: Ask,
        say: Callable[[str], None],
        moments: Moments,
        limit_s: float | None,
        travel: Travel | None = None,
    ) -> None:
        """`limit_s` is the time to wait for a program that runs, in seconds; None means without limit.

        `travel` is the way back, if there is one.
        """
        self._ask, self._say, self._moments, self._limit_s = ask, say, moments, limit_s
        self._travel = travel
        self._sources = Sources(ask)
        self._chosen: int | None = None
        self.is_over = False
        self._acts: dict[str, Callable[[list[str]], None]] = {
            "run": self._run,
            "continue": self._continue,
            "step": lambda arguments: self._step("into", arguments),
            "next": lambda arguments: self._step("over", arguments),
            "out": self._out,
            "pause": lambda arguments: self._plain("pause", arguments),
            "stop": lambda arguments: self._plain("stop", arguments),
            "reset": self._reset,
            "break": self._break,
            "delete": self._delete,
            "watch": self._watch,
            "unwatch": self._unwatch,
            "back": self._back,
            "reverse-continue": self._reverse_continue,
            "last": self._last,
            "list": self._list,
            "where": self._where,
            "threads": self._threads,
            "print": self._print,
            "locals": self._locals,
            "set": lambda arguments: self._say_all(values.assign(ask, "write", arguments)),
            "force": lambda arguments: self._say_all(values.assign(ask, "force", arguments)),
            "release": lambda arguments: self._say_all(values.release(ask, arguments)),
            "forced": self._forced,
            "trace": self._trace,
            "state": self._state,
            "help": self._help,
            "quit": self._quit,
            "leave": self._leave,
        }

    def do(self, line: str) -> None:
        """Execute one command.

        Raises ValueError, which says what was expected, NotStoppedError, or an error of the connection.
        """
        word, _, rest = line.strip().partition(" ")
        self._acts[WORDS.find(word)](values.words_of(rest))

    def begin(self) -> None:
        """Say where the program is, and what another session has left: breakpoints, and values watched or forced."""
        self.show_place()
        if self._stops():
            self._break([])
        if self._is_watching():
            self._watch([])
        self._say_all(values.forced(self._ask))

    def show_place(self) -> None:
        """Say where the program is: one line for each task that stands, or the state of the program."""
        state = self._ask({"command": "state"})
        standing = [thread for thread in state["threads"] if thread["state"] in ("paused", "failed")]
        if not standing:
            self._say(f"the program is {state['state']}" if state["threads"] else "there is no program")
            if state["threads"] and (pause := self._rig_pause()):
                self._say(pause)
        for thread in standing:
            frames = self._stack(thread["number"])
            where = self._shown(Place(frames[0]["file"], frames[0]["line"]), frames[0]["routine"]) if frames else ""
            self._say(f"{thread['name']} {thread['state']}{' at ' if where else ''}{where}")
            if thread["about"]:
                self._say(f"  {thread['about']}")
        if standing and self._chosen not in [thread["number"] for thread in standing]:
            self._chosen = standing[0]["number"]

    # ---- going on

    def _run(self, arguments: list[str]) -> None:
        """Start the program; one that runs already is only waited for."""
        is_running = self._ask({"command": "state"})["state"] == "running"
        self._go(None if is_running else "start", arguments)

    def _continue(self, arguments: list[str]) -> None:
        state = self._ask({"command": "state"})["state"]
        is_waited_for = state == "running" and bool(self._stops() or self._is_watching() or arguments)
        if not is_waited_for and state not in ("paused", "failed"):
            raise ValueError("the program is not paused\n`run` starts it, `pause` pauses it")
        self._go(None if is_waited_for else "continue", arguments)

    def _go(self, command: str | None, arguments: list[str]) -> None:
        """Give a command, if there is one, and wait for a stop."""
        limit_s = limit(arguments, self._limit_s)
        before = self._ask({"command": "state"})["stops"]
        if command is not None:
            self._ask({"command": command})
        self._run_rig()
        if self._stops() or self._is_watching() or arguments:
            self._wait(before, limit_s)
        else:
            self.show_place()

    def _step(self, kind: str, arguments: list[str]) -> None:
        for _ in range(count(arguments)):
            before = self._ask({"command": "state"})["stops"]
            chosen = {} if self._chosen is None else {"thread": self._chosen}
            self._ask({"command": "step", "kind": kind, **chosen})
            self._run_rig()
            self._until_it_stops(before, self._limit_s)
        self.show_place()

    def _out(self, arguments: list[str]) -> None:
        none(arguments)
        self._step("out", [])

    def _wait(self, before: int, limit_s: float | None) -> None:
        if limit_s is None:
            self._say("the program runs; Ctrl-C pauses it")
        self._until_it_stops(before, limit_s)
        self.show_place()

    def _until_it_stops(self, before: int, limit_s: float | None) -> None:
        """Wait for another stop than those before; Ctrl-C pauses the program."""
        try:
            for _ in self._moments(limit_s):
                state = self._ask({"command": "state"})
                if state["stops"] > before or state["state"] != "running":
                    return
        except KeyboardInterrupt:
            self._ask({"command": "pause"})
            return
        raise NotStoppedError(self._rig_pause() or f"the program still runs after {limit_s:g} s\n`pause` pauses it")

    def _rig_pause(self) -> str:
        """Say that the rig is paused, and what lets it run; empty for a rig that runs."""
        pause_ns = None if self._travel is None else self._travel.rig_pause_ns
        if pause_ns is None:
            return ""
        word = "`run`" if self._travel is not None and self._travel.is_held else "`fieldrig run`"
        return f"the rig is paused at {pause_ns / 1e9:.9g} s\n  {word} lets it run"

    def _plain(self, command: str, arguments: list[str]) -> None:
        none(arguments)
        self._ask({"command": command})
        self.show_place()

    def _reset(self, arguments: list[str]) -> None:
        if len(arguments) > 1:
            raise ValueError(f"unexpected {' '.join(arguments[1:])!r}\nexpected warm, cold or origin")
        kind = arguments[0] if arguments else "warm"
        has_program = self._ask({"command": "state"})["state"] != "none"
        self._ask({"command": "reset", "kind": kind})
        if has_program and kind != "origin":
            self._until_there()
        self.show_place()

    def _until_there(self) -> None:
        """Wait for the program of a device that starts again after a reset."""
        for _ in self._moments(LONGEST_START_S):
            if self._ask({"command": "state"})["state"] != "none":
                return

    # ---- going back

    def _run_rig(self) -> None:
        """Let a rig run on that a way back has paused."""
        if self._travel is not None:
            self._travel.run()

    def _way_back(self) -> Travel:
        if self._travel is None:
            raise ValueError("this program cannot go back\nexpected one in a rig with `time: virtual`")
        return self._travel

    def _back(self, arguments: list[str]) -> None:
        travel = self._way_back()
        if arguments[:1] == ["to"]:
            if len(arguments) != 2:
                raise ValueError("expected `back to LINE` or `back to FILE:LINE`")
            place = self._sources.place_of(arguments[1], self._here())
            self._chosen = int(travel.back_to(place.file, place.line)["thread"])
        elif len(arguments) > 1:
            raise ValueError(
                f"unexpected {' '.join(arguments[1:])!r}\nexpected `back 5`, `back 12.34s` or `back to LINE`"
            )
        elif arguments and not arguments[0].isdecimal():
            travel.back(duration_ns(arguments[0]))
        else:
            for _ in range(count(arguments)):
                self._back_by_line(travel)
        self.show_place()

    def _back_by_line(self, travel: Travel) -> None:
        """Go back by a line; in a rig that is paused between two cycles, to the line that ran last."""
        threads = self._ask({"command": "state"})["threads"]
        if threads and travel.rig_pause_ns is not None and not any(one["state"] in STANDING for one in threads):
            travel.back_by_line(self._chosen or int(threads[0]["number"]))
        else:
            travel.back_by_line(self._standing())

    def _standing(self) -> int:
        """Return the task that stands, or the chosen one of several.  ValueError if none does."""
        threads = self._ask({"command": "state"})["threads"]
        standing = [thread["number"] for thread in threads if thread["state"] in STANDING]
        if not standing:
            raise ValueError("no task is paused\n`pause` pauses the program, `back 12.34s` goes to a time")
        chosen = self._chosen
        return chosen if chosen is not None and chosen in standing else int(standing[0])

    def _reverse_continue(self, arguments: list[str]) -> None:
        none(arguments)
        found = self._way_back().reverse_continue()
        self._chosen = int(found["thread"])
        if "change" in found:
            self._say(changed(found))
        self.show_place()

    def _last(self, arguments: list[str]) -> None:
        if len(arguments) != 1:
            raise ValueError("expected the name of one variable")
        self._say(changed(self._way_back().last_change(arguments[0])))

    def _watch(self, arguments: list[str]) -> None:
        names: list[str] = self._ask({"command": "watch"})["names"]
        if arguments:
            names = self._ask({"command": "watch", "names": [*names, *arguments]})["names"]
        self._say_all([f"stops when {name} changes" for name in names] or ["no variable is watched"])

    def _is_watching(self) -> bool:
        return bool(self._ask({"command": "watch"})["names"])

    def _unwatch(self, arguments: list[str]) -> None:
        names: list[str] = self._ask({"command": "watch"})["names"]
        if not set(arguments) <= set(names):
            raise ValueError("such a variable is not watched\n`watch` lists them")
        left = [name for name in names if arguments and name not in arguments]
        self._ask({"command": "watch", "names": left})
        self._say(f"{counted(len(left), 'watched variable')} left")

    # ---- looking

    def _here(self) -> Place | None:
        """The place of the task that is looked at; None without a program."""
        frames = self._stack(self._chosen)
        return Place(frames[0]["file"], frames[0]["line"]) if frames else None

    def _stack(self, thread: int | None) -> list[dict[str, Any]]:
        question = {"command": "stack"} if thread is None else {"command": "stack", "thread": thread}
        frames: list[dict[str, Any]] = self._ask(question)["frames"]
        return frames

    def _list(self, arguments: list[str]) -> None:
        here = self._here()
        if len(arguments) > 1:
            raise ValueError("expected one line to show")
        place = self._sources.place_of(arguments[0], here) if arguments else here
        if place is None:
            raise ValueError("there is no program")
        text, stops = self._sources.lines(place.file), self._stops()
        for number in range(max(place.line - REACH, 1), min(place.line + REACH, len(text)) + 1):
            at = Place(place.file, number)
            mark = "*" if at in stops else " "
            self._say(f"{'>' if at == here else ' '}{mark}{number:5}  {text[number - 1]}")

    def _where(self, arguments: list[str]) -> None:
        none(arguments)
        frames = self._stack(self._chosen)
        if not frames:
            self._say(
                "the task is between two cycles"
                if self._ask({"command": "state"})["threads"]
                else "there is no program"
            )
        for number, frame in enumerate(frames):
            text = self._shown(Place(frame["file"], frame["line"]), frame["routine"])
            self._say(f"called at {text}" if number else text)

    def _shown(self, place: Place, routine: str = "") -> str:
        text = self._sources.line(place).strip()
        return f"{routine + ', ' if routine else ''}{place}{': ' if text else ''}{text}"

    def _threads(self, arguments: list[str]) -> None:
        threads = self._ask({"command": "state"})["threads"]
        if arguments:
            numbers = [str(thread["number"]) for thread in threads]
            if len(arguments) > 1 or arguments[0] not in numbers:
                raise ValueError(f"{' '.join(arguments)!r} is not a task\nexpected {', '.join(numbers) or 'a program'}")
            self._chosen = int(arguments[0])
        for thread in threads:
            mark = ">" if thread["number"] == self._chosen else " "
            about = f"  {thread['about']}" if thread["about"] else ""
            self._say(f"{mark}{thread['number']:3}  {thread['name']}  {thread['state']}{about}")

    def _print(self, arguments: list[str]) -> None:
        self._say_all(values.printed(self._ask, arguments, self._chosen))

    def _locals(self, arguments: list[str]) -> None:
        """Show the variables of a frame; 0 is the innermost one."""
        if len(arguments) > 1 or not all(argument.isdecimal() for argument in arguments):
            raise ValueError(f"unexpected {' '.join(arguments)!r}\nexpected the number of a caller")
        if self._chosen is None:
            raise ValueError("no task is paused\nexpected a breakpoint first")
        frame = arguments[0] if arguments else "0"
        self._say_all(values.inside(self._ask, f"@{self._chosen}:{frame}") or ["there are no variables"])

    def _forced(self, arguments: list[str]) -> None:
        none(arguments)
        self._say_all(values.forced(self._ask) or ["no value is forced"])

    def _trace(self, arguments: list[str]) -> None:
        self._say_all(trace(self._ask, arguments, lambda: self._moments(self._limit_s)))

    def _state(self, arguments: list[str]) -> None:
        none(arguments)
        state = self._ask({"command": "state"})
        self._say(f"{state['language']}: {state['state']} at {state['now_ns'] / 1e9:.3f} s")
        for about in (state["progress"], state["problem"]):
            if about:
                self._say(about)
        self._threads([])

    def _say_all(self, lines: Sequence[str]) -> None:
        for line in lines:
            self._say(line)

    # ---- where it stops

    def _break(self, arguments: list[str]) -> None:
        if arguments:
            first, *rest = arguments
            if rest and (rest[0] != "if" or len(rest) == 1):
                raise ValueError(f"unexpected {' '.join(rest)!r}\nexpected `break LINE if CONDITION`")
            self._stop_at(self._sources.place_of(first, self._here()), " ".join(rest[1:]))
        stops = self._stops()
        if not stops:
            self._say("no breakpoints")
        for place, stop in stops.items():
            words = [f"{word} {stop[name]}" for name, word in _WORDS_OF_STOPS.items() if stop.get(name)]
            self._say(" ".join(["breakpoint at", self._shown(place), *words]))

    def _stops(self) -> dict[Place, dict[str, Any]]:
        """Return the device's breakpoints by place, also those that another session has set."""
        breakpoints = self._ask({"command": "breakpoints"})["breakpoints"]
        return {Place(one["file"], one["line"]): one for one in breakpoints}

    def _stop_at(self, wanted: Place, condition: str) -> None:
        """Set a breakpoint at the first line from `wanted` on that has an instruction."""
        stops = {place: stop for place, stop in self._stops().items() if place != wanted}
        if self._set_breakpoints(wanted.file, {**stops, wanted: {"condition": condition}})[-1] is None:
            raise ValueError(f"there is no instruction at or after {wanted}")

    def _set_breakpoints(self, file: str, stops: dict[Place, dict[str, Any]]) -> list[int | None]:
        """Set the breakpoints of one file; return their lines, None for one behind the last instruction."""
        wanted = [{**stop, "line": place.line} for place, stop in stops.items() if place.file == file]
        question = {"command": "breakpoints", "file": file, "breakpoints": wanted, "move": True}
        places: list[int | None] = self._ask(question)["places"]
        return places

    def _delete(self, arguments: list[str]) -> None:
        here, stops = self._here(), self._stops()
        gone = {self._sources.place_of(argument, here) for argument in arguments} if arguments else set(stops)
        if not gone <= set(stops):
            raise ValueError("there is no such breakpoint\n`break` lists them")
        left = {place: stop for place, stop in stops.items() if place not in gone}
        for file in {place.file for place in gone}:
            self._set_breakpoints(file, left)
        self._say(f"{counted(len(left), 'breakpoint')} left")

    # ---- leaving

    def _help(self, arguments: list[str]) -> None:
        if len(arguments) > 1:
            raise ValueError("expected one command to explain")
        self._say_all([WORDS.line(arguments[0])] if arguments else list(WORDS.lines()))

    def _quit(self, arguments: list[str]) -> None:
        none(arguments)
        self.is_over = True
        if self._stops():
            self._delete([])
        if self._is_watching():
            self._unwatch([])
        if forced := values.forced(self._ask):
            self._say(f"{counted(len(forced), 'forced value')} left, until `release`")
        if self._ask({"command": "state"})["state"] == "paused":
            self._ask({"command": "continue"})
            self._say("the program continues")
        self._run_rig()

    def _leave(self, arguments: list[str]) -> None:
        none(arguments)
        self.is_over = True
