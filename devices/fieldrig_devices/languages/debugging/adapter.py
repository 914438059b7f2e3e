"""A debug adapter: it lets an editor that speaks the Debug Adapter Protocol debug a program in a running rig.

Source: Debug Adapter Protocol, version 1.6x.  The adapter translates between the protocol and the questions of
`service.py`, and knows no language: bytes come in by `feed`, events of the program by `poll`, and both return bytes for
the editor.  Requests whose command begins with "fieldrig." reach the debugging service as they are, for what the
protocol does not have, such as forcing, a download, and the trace.

A rig in virtual time goes back: `stepBack` and `reverseContinue` are for all devices, buses and plants of it.

Left out on purpose: launching a rig (start it with `fieldrig up`), and breakpoints on functions.
"""

from collections.abc import Callable, Mapping
from pathlib import PurePath
from typing import Any, Final

from fieldrig.errors import RigError
from fieldrig.outside.untrusted import field, items, typed
from fieldrig_devices.languages.debugging.framing import Framer, framed
from fieldrig_devices.languages.debugging.service import MOST_WATCHED
from fieldrig_devices.languages.debugging.stops import EXPECTED, is_count
from fieldrig_devices.languages.debugging.texts import shown
from fieldrig_devices.languages.debugging.travel import Travel

OWN: Final = "fieldrig."
CAPABILITIES: Final = {
    "supportsConfigurationDoneRequest": True,
    "supportsConditionalBreakpoints": True,
    "supportsHitConditionalBreakpoints": True,
    "supportsLogPoints": True,
    "supportsEvaluateForHovers": True,
    "supportsSetVariable": True,
    "supportsSetExpression": True,
    "supportsRestartRequest": True,
    "supportsDataBreakpoints": True,
}
REASONS: Final = {"paused": "breakpoint", "failed": "exception"}
MOST_BREAKPOINTS: Final = 1_000

Ask = Callable[[Mapping[str, Any]], dict[str, Any]]
"""Puts a question to the debugging service.  RigError or ValueError if it refuses."""


class Adapter:
    """One session of an editor."""

    def __init__(self, ask: Ask, travel: Travel | None = None) -> None:
        """`travel` is the way back; None if there is none, as outside of a rig."""
        self._ask, self._travel = ask, travel
        self._framer = Framer()
        self._sequence = 0
        self._out: list[bytes] = []
        self._folder = ""
        self._stops = self._loads = self._logged = 0
        self._breakpoints: dict[int, tuple[str, int]] = {}
        """The places of the editor's breakpoints by their ids."""
        self._last_id = 0
        self._is_attached = self.is_over = False
        self._why = ""
        """Why the program is going to stop, if the editor has asked for it: `step` or `pause`."""
        self._found: int | None = None
        """The thread that a way back has come to, until the editor knows."""
        self._progress = ""
        self._references: list[str] = []
        """Paths of groups, by their reference minus 1."""
        self._frames: list[dict[str, Any]] = []
        """Frames by their id minus 1, of the last stack of each thread."""
        self._commands: dict[str, Callable[[Mapping[str, Any]], dict[str, Any] | None]] = {
            "initialize": self._initialize,
            "attach": self._attach,
            "launch": self._attach,  # an editor that has started the rig itself ends it with the session
            "configurationDone": self._show_breakpoints,
            "setBreakpoints": self._set_breakpoints,
            "setExceptionBreakpoints": lambda _: None,
            "threads": self._threads,
            "stackTrace": self._stack_trace,
            "scopes": self._scopes,
            "variables": self._variables,
            "setVariable": self._set_variable,
            "setExpression": self._set_expression,
            "evaluate": self._evaluate,
            "source": self._source,
            "loadedSources": self._loaded_sources,
            "continue": self._continue,
            "pause": self._pause,
            "next": lambda arguments: self._step(arguments, "over"),
            "stepIn": lambda arguments: self._step(arguments, "into"),
            "stepOut": lambda arguments: self._step(arguments, "out"),
            "stepBack": self._step_back,
            "reverseContinue": self._reverse_continue,
            "fieldrig.back": self._back,
            "fieldrig.backTo": self._back_to,
            "fieldrig.lastChange": self._last_change,
            "dataBreakpointInfo": self._data_breakpoint_info,
            "setDataBreakpoints": self._set_data_breakpoints,
            "restart": self._restart,
            "disconnect": self._disconnect,
        }

    # ---- bytes

    def feed(self, data: bytes) -> bytes:
        """Take bytes of the editor, and return the responses and events for it."""
        for message in self._framer.feed(data):
            if isinstance(message, dict) and message.get("type") == "request":
                self._request(message)
        return self._taken()

    def poll(self) -> bytes:
        """Look at the program, and return the events that the editor has not seen."""
        if self._is_attached and not self.is_over:
            try:
                self._look()
            except (RigError, ValueError) as cause:
                self._event("output", category="important", output=f"{cause}\n")
                self._event("terminated")
                self.is_over = True
        return self._taken()

    def _taken(self) -> bytes:
        taken, self._out = b"".join(self._out), []
        return taken

    def _send(self, message: dict[str, Any]) -> None:
        self._sequence += 1
        self._out.append(framed({"seq": self._sequence, **message}))

    def _event(self, name: str, **body: Any) -> None:
        self._send({"type": "event", "event": name, "body": body})

    def _request(self, message: Mapping[str, Any]) -> None:
        command = message.get("command")
        head = {"type": "response", "request_seq": message.get("seq", 0), "command": command}
        try:
            body = self._answer(typed(command, str, "command"), message.get("arguments") or {})
        except (RigError, ValueError) as cause:
            text = str(cause)
            self._send({**head, "success": False, "message": text, "body": {"error": {"id": 1, "format": text}}})
            return
        self._send({**head, "success": True, "body": body or {}})
        if command == "initialize":
            self._event("initialized")
        if command == "disconnect":
            self.is_over = True

    def _answer(self, command: str, arguments: Any) -> dict[str, Any] | None:
        typed(arguments, dict, "arguments")
        action = self._commands.get(command)
        if action is None and command.startswith(OWN):
            return self._ask({**arguments, "command": command.removeprefix(OWN)})
        if action is None:
            raise ValueError(f"the adapter has no request {command!r}")
        return action(arguments)

    # ---- the session

    def _initialize(self, _: Mapping[str, Any]) -> dict[str, Any]:
        return CAPABILITIES | {"supportsStepBack": self._travel is not None and self._travel.is_possible}

    def _attach(self, arguments: Mapping[str, Any]) -> None:
        """Attach; `sources` is the folder that has the program's files.

        What another session has left is shown: its breakpoints, and threads that stand.
        """
        self._folder = typed(arguments.get("sources", ""), str, "sources")
        state = self._ask({"command": "state"})
        self._stops, self._loads, self._logged = state["stops"], state["loads"], state["logged"]
        if any(thread["state"] in REASONS for thread in state["threads"]):
            self._stops = -1
        self._is_attached = True

    def _show_breakpoints(self, _: Mapping[str, Any]) -> None:
        """Tell the editor, which has set its own ones, of the others that the device has."""
        known = set(self._breakpoints.values())
        for stop in self._ask({"command": "breakpoints"})["breakpoints"]:
            if (stop["file"], stop["line"]) not in known:
                shown = self._breakpoint(stop["file"], stop["line"], stop["line"])
                shown["source"] = self._source_of(stop["file"])
                self._event("breakpoint", reason="new", breakpoint=shown)

    def end(self) -> None:
        """End the session, also without a request for it: remove the breakpoints, and let a paused program continue."""
        if self._is_attached and not self.is_over:
            self.is_over = True
            self._disconnect({})

    def _disconnect(self, _: Mapping[str, Any]) -> None:
        for file in {stop["file"] for stop in self._ask({"command": "breakpoints"})["breakpoints"]}:
            self._ask({"command": "breakpoints", "file": file, "breakpoints": []})
        self._ask({"command": "watch", "names": []})
        if self._ask({"command": "state"})["state"] == "paused":
            self._ask({"command": "continue"})
        self._run_rig()

    def _restart(self, _: Mapping[str, Any]) -> None:
        self._ask({"command": "stop"})
        self._ask({"command": "reset", "kind": "warm"})
        self._ask({"command": "start"})

    def _look(self) -> None:
        state = self._ask({"command": "state"})
        progress = state["progress"]
        if progress != self._progress:
            self._progress = progress
            if progress:
                self._event("output", category="console", output=f"{progress}\n")
        if state["logged"] != self._logged:
            self._show_logged()
            self._logged = state["logged"]
        if state["loads"] != self._loads:
            self._loads = state["loads"]
            self._show_moves()
        if state["stops"] == self._stops:
            return
        self._stops = state["stops"]
        for thread in sorted(state["threads"], key=lambda thread: bool(thread["number"] != self._found)):
            reason = REASONS.get(thread["state"])
            if reason is not None:
                is_beside = self._found is not None and thread["number"] != self._found
                why = self._why if self._why and reason == "breakpoint" and not is_beside else reason
                why = "data breakpoint" if "change" in thread else why
                body = {"reason": why, "threadId": thread["number"], "allThreadsStopped": False}
                body |= {"preserveFocusHint": True} if is_beside else {}
                self._event("stopped", **body, **({"text": thread["about"]} if thread["about"] else {}))
        self._why, self._found = "", None

    def _show_logged(self) -> None:
        """Show what breakpoints have logged since the last look."""
        for entry in self._ask({"command": "logged", "after": self._logged})["entries"]:
            place = {"source": self._source_of(entry["file"]), "line": entry["line"]}
            self._event("output", category="stdout", output=f"{entry['text']}\n", **place)

    # ---- going on

    def _pause(self, _: Mapping[str, Any]) -> None:
        self._why = "pause"
        self._only("pause")

    def _only(self, command: str) -> None:
        self._ask({"command": command})

    def _continue(self, _: Mapping[str, Any]) -> dict[str, Any]:
        self._why = ""
        self._only("continue")
        self._run_rig()
        return {"allThreadsContinued": True}

    def _step(self, arguments: Mapping[str, Any], kind: str) -> None:
        self._why = "step"
        self._ask({"command": "step", "thread": field(arguments, "threadId", int), "kind": kind})
        self._run_rig()

    # ---- going back

    def _way_back(self) -> Travel:
        if self._travel is None:
            raise ValueError("this program cannot go back: expected one in a rig with `time: virtual`")
        return self._travel

    def _run_rig(self) -> None:
        """Let a rig run on that a way back has paused."""
        if self._travel is not None:
            self._travel.run()

    def _is_back(self, why: str, found: Mapping[str, Any] | None = None) -> None:
        """Show at the next look where the program is now, and the thread that was looked for in front of the others."""
        self._stops, self._why = -1, why
        self._found = None if found is None else int(found["thread"])

    def _step_back(self, arguments: Mapping[str, Any]) -> None:
        found = self._way_back().back_by_line(field(arguments, "threadId", int))
        self._is_back("step", found)

    def _reverse_continue(self, _: Mapping[str, Any]) -> None:
        found = self._way_back().reverse_continue()
        self._is_back("data breakpoint" if "change" in found else "breakpoint", found)

    def _back(self, arguments: Mapping[str, Any]) -> None:
        self._way_back().back(field(arguments, "ns", int))
        self._is_back("goto")

    def _back_to(self, arguments: Mapping[str, Any]) -> None:
        name = self._file_of(field(arguments, "source", dict))
        found = self._way_back().back_to(name, field(arguments, "line", int))
        self._is_back("goto", found)

    def _last_change(self, arguments: Mapping[str, Any]) -> dict[str, Any]:
        return dict(self._way_back().last_change(field(arguments, "name", str)))

    # ---- data breakpoints

    def _data_breakpoint_info(self, arguments: Mapping[str, Any]) -> dict[str, Any]:
        """Return the path of a variable as its identity; a variable of a call and a group have none."""
        name = field(arguments, "name", str)
        if arguments.get("variablesReference"):
            variables = self._ask({"command": "variables", "path": self._group(arguments)})["variables"]
            variable = next((each for each in variables if each["name"] == name), None)
        else:
            [variable] = self._ask({"command": "read", "names": [name]})["variables"]
        if variable is None or "error" in variable:
            return {"dataId": None, "description": f"{name} is not a variable of the program"}
        path = str(variable["path"])
        if variable["value"] is None or path.startswith("@"):
            what = "is a group of values" if variable["value"] is None else "ends with its call"
            return {"dataId": None, "description": f"{name} {what}"}
        return {"dataId": path, "description": path, "accessTypes": ["write"], "canPersist": True}

    def _set_data_breakpoints(self, arguments: Mapping[str, Any]) -> dict[str, Any]:
        """Replace the data breakpoints: the program stops behind a statement that gives such a variable a new value."""
        wanted = [
            field(each, "dataId", str)
            for each in items(arguments.get("breakpoints") or [], dict, MOST_WATCHED, "breakpoints")
        ]
        read = self._ask({"command": "read", "names": wanted})["variables"] if wanted else []
        wrong = ["error" in variable or variable["value"] is None for variable in read]
        self._ask(
            {"command": "watch", "names": [name for name, is_wrong in zip(wanted, wrong, strict=True) if not is_wrong]}
        )
        return {
            "breakpoints": [
                {"verified": False, "message": "there is no such value"} if is_wrong else {"verified": True}
                for is_wrong in wrong
            ]
        }

    # ---- places

    def _set_breakpoints(self, arguments: Mapping[str, Any]) -> dict[str, Any]:
        source = field(arguments, "source", dict)
        wanted = items(arguments.get("breakpoints") or [], dict, MOST_BREAKPOINTS, "breakpoints")
        places = [_place_of(place) for place in wanted]
        name = self._file_of(source)
        right = [place for place in places if is_count(place["hits"])]
        question = {"command": "breakpoints", "file": name, "breakpoints": right, "move": True}
        lines = iter(self._ask(question)["places"])
        self._breakpoints = {number: place for number, place in self._breakpoints.items() if place[0] != name}
        return {
            "breakpoints": [
                self._breakpoint(name, place["line"], next(lines))
                if is_count(place["hits"])
                else {"verified": False, "line": place["line"], "message": EXPECTED}
                for place in places
            ]
        }

    def _breakpoint(self, file: str, line: int, after: int | None) -> dict[str, Any]:
        """Return a new breakpoint as the editor sees it; one that is set has an id, for later changes."""
        if after is None:
            return {"verified": False, "line": line, "message": "there is no instruction from this line on"}
        self._last_id += 1
        self._breakpoints[self._last_id] = file, after
        return {"id": self._last_id, "verified": True, "line": after}

    def _show_moves(self) -> None:
        """Tell the editor where its breakpoints are in a program that has been loaded."""
        asked = {file for file, _ in self._breakpoints.values()}
        moves = {file: self._ask({"command": "breakpoints", "file": file})["moves"] for file in asked}
        for number, (file, line) in list(self._breakpoints.items()):
            after = moves[file].get(str(line))
            shown = {"id": number, "verified": after is not None, "line": line if after is None else after}
            if after is None:
                del self._breakpoints[number]
            else:
                self._breakpoints[number] = file, after
            self._event("breakpoint", reason="changed", breakpoint=shown)

    def _file_of(self, source: Mapping[str, Any]) -> str:
        """Return the program's name of a source: the same path, or else the only one with the same last part."""
        path = typed(source.get("path") or source.get("name") or "", str, "path")
        files: list[str] = self._ask({"command": "files"})["files"]
        last = PurePath(path.replace("\\", "/")).name
        alike = [name for name in files if PurePath(name).name == last]
        if path in files:
            return path
        if len(alike) != 1:
            raise ValueError(f"the program has no file {last!r}; expected {', '.join(files) or 'a program'}")
        return alike[0]

    def _source_of(self, name: str) -> dict[str, Any]:
        """Return where the editor finds a file: in the folder that it gave, or by asking for the text."""
        if self._folder:
            return {"name": name, "path": f"{self._folder.rstrip('/')}/{name}"}
        return {"name": name, "sourceReference": self._ask({"command": "files"})["files"].index(name) + 1}

    def _source(self, arguments: Mapping[str, Any]) -> dict[str, Any]:
        files: list[str] = self._ask({"command": "files"})["files"]
        source = typed(arguments.get("source") or {}, dict, "source")
        number = typed(source.get("sourceReference") or arguments.get("sourceReference") or 0, int, "sourceReference")
        if number > len(files):
            raise ValueError(f"there is no source {number}; expected 1 to {len(files)}")
        name = files[number - 1] if number > 0 else self._file_of(source)
        return {"content": self._ask({"command": "source", "file": name})["text"]}

    def _loaded_sources(self, _: Mapping[str, Any]) -> dict[str, Any]:
        return {"sources": [self._source_of(name) for name in self._ask({"command": "files"})["files"]]}

    def _threads(self, _: Mapping[str, Any]) -> dict[str, Any]:
        threads = self._ask({"command": "state"})["threads"]
        return {"threads": [{"id": thread["number"], "name": thread["name"]} for thread in threads]}

    def _stack_trace(self, arguments: Mapping[str, Any]) -> dict[str, Any]:
        thread = field(arguments, "threadId", int)
        frames = self._ask({"command": "stack", "thread": thread})["frames"]
        first = typed(arguments.get("startFrame") or 0, int, "startFrame")
        most = typed(arguments.get("levels") or len(frames), int, "levels")
        shown = []
        for number, frame in list(enumerate(frames))[max(first, 0) :][: max(most, 0)]:
            self._frames.append({**frame, "thread": thread, "number": number})
            shown.append(
                {
                    "id": len(self._frames),
                    "name": frame["routine"],
                    "line": frame["line"],
                    "column": 1,
                    "source": self._source_of(frame["file"]),
                }
            )
        return {"stackFrames": shown, "totalFrames": len(frames)}

    # ---- values

    def _scopes(self, arguments: Mapping[str, Any]) -> dict[str, Any]:
        """Offer the variables of the frame, or those that its routine has by its name, and all variables."""
        scopes = []
        frame = self._frame(arguments)
        for path in (f"@{frame['thread']}:{frame['number']}", frame["routine"]):
            try:
                variables = self._ask({"command": "variables", "path": path})["variables"]
            except (RigError, ValueError):
                continue
            if not variables:
                continue
            scope = {"name": frame["routine"], "variablesReference": self._reference(path), "expensive": False}
            scopes.append(scope)
            break
        return {"scopes": [*scopes, {"name": "All", "variablesReference": self._reference(""), "expensive": True}]}

    def _frame(self, arguments: Mapping[str, Any]) -> dict[str, Any]:
        number = field(arguments, "frameId", int)
        if not 1 <= number <= len(self._frames):
            raise ValueError(f"there is no frame {number}")
        return self._frames[number - 1]

    def _reference(self, path: str) -> int:
        if path not in self._references:
            self._references.append(path)
        return self._references.index(path) + 1

    def _group(self, arguments: Mapping[str, Any]) -> str:
        number = field(arguments, "variablesReference", int)
        if not 1 <= number <= len(self._references):
            raise ValueError(f"there is no group of variables {number}")
        return self._references[number - 1]

    def _variables(self, arguments: Mapping[str, Any]) -> dict[str, Any]:
        answer = self._ask({"command": "variables", "path": self._group(arguments)})
        return {"variables": [self._variable(variable) for variable in answer["variables"]]}

    def _variable(self, variable: Mapping[str, Any]) -> dict[str, Any]:
        value = variable["value"]
        return {
            "name": variable["name"],
            "value": variable["type"] if value is None else shown(variable),
            "type": variable["type"],
            "evaluateName": variable["path"],
            "variablesReference": self._reference(variable["path"]) if value is None else 0,
        }

    def _set_variable(self, arguments: Mapping[str, Any]) -> dict[str, Any]:
        name, group = field(arguments, "name", str), self._group(arguments)
        for variable in self._ask({"command": "variables", "path": group})["variables"]:
            if variable["name"] == name:
                return self._written(variable["path"], field(arguments, "value", str))
        raise ValueError(f"{group or 'the program'} has no variable {name}")

    def _set_expression(self, arguments: Mapping[str, Any]) -> dict[str, Any]:
        return self._written(field(arguments, "expression", str), field(arguments, "value", str))

    def _written(self, path: str, text: str) -> dict[str, Any]:
        variable = self._ask({"command": "write", "values": {path: text}})["variables"][0]
        return {"value": shown(variable), "type": variable["type"]}

    def _evaluate(self, arguments: Mapping[str, Any]) -> dict[str, Any]:
        question: dict[str, Any] = {"command": "read", "names": [field(arguments, "expression", str)]}
        if arguments.get("frameId") is not None:
            frame = self._frame(arguments)
            question |= {"thread": frame["thread"], "frame": frame["number"]}
        variable = self._ask(question)["variables"][0]
        if "error" in variable:
            raise ValueError(variable["error"])
        shown = self._variable(variable)
        return {
            "result": shown["value"],
            "type": shown["type"],
            "variablesReference": shown["variablesReference"],
        }


_OF_BREAKPOINTS: Final = {"condition": "condition", "hits": "hitCondition", "log": "logMessage"}
"""The parts of a breakpoint in a question to the service, with their names in the protocol."""


def _place_of(asked: Mapping[str, Any]) -> dict[str, Any]:
    """Return a breakpoint of the editor as the service takes it."""
    texts = {name: typed(asked.get(theirs) or "", str, theirs) for name, theirs in _OF_BREAKPOINTS.items()}
    return {"line": field(asked, "line", int), **texts}
