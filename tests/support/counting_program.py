"""A program `n := n + 1; m := n;` for tests of the debugging service, whose lines the test runs one by one."""

from collections.abc import Callable, Mapping, Sequence

from fieldrig.device import Value
from fieldrig_devices.languages.debugging.debuggee import (
    At,
    Frame,
    Looks,
    ProgramState,
    Reset,
    Step,
    ThreadView,
    Variable,
    evaluated,
)


class CountingProgram:
    """A program `n := n + 1; m := n;` whose lines the test runs one by one."""

    language = "counting"

    def __init__(self) -> None:
        self.on_stop: Callable[[], None] = lambda: None
        self.on_load: Callable[[], None] = lambda: None
        self.state = ProgramState.RUNNING
        self.files: Mapping[str, str] = {"count.txt": "n := n + 1;\nm := n;\n"}
        self.progress = self.problem = ""
        self.values: dict[str, Value] = {"n": 0, "m": 0}
        self.forced_values: dict[str, Value] = {}
        self.line = 1
        self.stops: Mapping[str, set[int]] = {}
        self.code_lines = {1, 2}
        """Lines with an instruction."""
        self.done: list[object] = []
        self.looks: Looks | None = None

    def run_line(self) -> None:
        """Run one line as the program's cycle does, and stop at a breakpoint in front of the next."""
        if self.looks is not None:
            self.looks[0](1)
            if self.state is ProgramState.PAUSED:
                return
        if self.line == 1:
            self.values["n"] = int(self.values["n"]) + 1
        else:
            self.values["m"] = self.values["n"]
        self.values |= self.forced_values
        self.line = 3 - self.line
        if self.looks is not None:
            self.looks[1](1)
            if self.state is ProgramState.PAUSED:
                return
        if self.line in self.stops.get("count.txt", ()):
            self.state = ProgramState.PAUSED
            self.on_stop()

    def threads(self) -> Sequence[ThreadView]:
        return [ThreadView(1, "main", self.state)]

    def stack(self, thread: int) -> Sequence[Frame]:
        return [Frame("MAIN", "count.txt", self.line)]

    def break_at(self, places: Mapping[str, set[int]]) -> Mapping[str, set[int]]:
        self.stops = {file: lines & self.code_lines for file, lines in places.items()}
        return self.stops

    def look_on(self, looks: Looks | None) -> None:
        self.looks = looks

    def at(self, thread: int) -> At | None:
        return At("count.txt", self.line, 0, True)

    def halt(self, thread: int) -> bool:
        self.state = ProgramState.PAUSED
        self.on_stop()
        return True

    def reader(self, text: str) -> Callable[[], Value | None]:
        return evaluated(self, text)

    def goes_on(self, file: str, first: int, last: int) -> bool:
        return False

    def start(self) -> None:
        self.done.append("start")

    def stop(self) -> None:
        self.done.append("stop")

    def reset(self, kind: Reset) -> None:
        self.done.append(kind)

    def pause(self) -> None:
        self.state = ProgramState.PAUSED

    def go_on(self) -> None:
        self.state = ProgramState.RUNNING

    def step(self, thread: int, kind: Step) -> None:
        self.done.append((thread, kind))

    def variables(self, path: str) -> Sequence[Variable]:
        if path:
            raise ValueError(f"{path} has no children")
        return [self.evaluate(name) for name in self.values]

    def evaluate(self, text: str, thread: int | None = None, frame: int = 0) -> Variable:
        name, equals, value = text.partition("=")
        if name not in self.values:
            raise ValueError(f"{name} is not known")
        if equals:
            return Variable(text, text, "BOOL", self.values[name] == int(value))
        return Variable(name, name, "INT", self.values[name], is_writable=True, is_forced=name in self.forced_values)

    def write(self, path: str, value: Value) -> None:
        self.evaluate(path)
        self.values[path] = value

    def force(self, path: str, value: Value | None) -> None:
        self.evaluate(path)
        if value is None:
            self.forced_values.pop(path, None)
        else:
            self.forced_values[path] = self.values[path] = value

    def forced(self) -> Sequence[Variable]:
        return [self.evaluate(name) for name in self.forced_values]

    def download(self, files: Mapping[str, str], *, is_online: bool) -> None:
        self.done.append((dict(files), is_online))
