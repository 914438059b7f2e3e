"""A PAM application under test in Python: a language of `fieldrig.programs`.

No node is behind its objects: inputs have the values that the test gives them, and every motion is ready at once.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fieldrig.errors import ConfigError, Mistake, RigError, UsageError
from fieldrig.programs import checked_duration
from fieldrig_devices.languages.bench import WatchedBench, check_options

if TYPE_CHECKING:
    from fieldrig_devices.pam.runtime.compiler import Compiled


def takes(path: Path) -> bool:
    return path.suffix.lower() == ".pam"


def load(paths: list[Path], options: Mapping[str, Any]) -> "PamBench":
    """Load an application with what it includes.  ConfigError with every mistake."""
    from fieldrig.text.source_text import decoded
    from fieldrig_devices.languages.mistakes import CompileError
    from fieldrig_devices.pam.application_files import paths_beside, reader_beside
    from fieldrig_devices.pam.runtime.compiler import compile_application

    check_options(options, ("ignores_case",))
    if len(paths) != 1:
        raise UsageError(f"an application is one file, and {len(paths)} were given", "the file may include others")
    [file] = paths
    try:
        text = decoded(file.read_bytes())
        ignores_case = bool(options.get("ignores_case", False))
        program = compile_application(text, str(file), reader_beside(file), ignores_case=ignores_case)
        program.code.marked.locate(paths_beside(file))
    except CompileError as wrong:
        raise ConfigError(
            [Mistake(one.file or str(file), one.line, "", one.what, one.expected) for one in wrong.mistakes]
        ) from wrong
    except (OSError, ValueError) as wrong:
        raise UsageError(f"{file} cannot be read", str(wrong)) from wrong
    return PamBench(program)


class PamBench(WatchedBench):
    def __init__(self, program: "Compiled") -> None:
        super().__init__()
        self._program = program
        self.reset()

    def reset(self) -> None:
        from fieldrig_devices.pam.runtime.solo import Solo

        super().reset()
        self._solo = Solo(self._program)
        self._now_ns = self._run_ns = 0
        self._is_started = False

    @property
    def now_ns(self) -> int:
        return self._now_ns

    @property
    def events(self) -> Sequence[str]:
        return self._solo.events

    def start(self) -> None:
        self._is_started = True
        self._solo.start()

    def stop(self) -> None:
        self._is_started = False
        self._solo.stop()

    def advance(self, duration_ns: int) -> None:
        was_over = self._solo.is_over
        self._now_ns += checked_duration(duration_ns)
        if self._is_started:  # the time for which it is held is no time of its cycles
            self._run_ns += duration_ns
            self._solo.run_until(self._run_ns)
        if self._solo.is_over and not was_over:
            raise RigError("a fatal error has stopped the application", "\n".join(self.events[-1:]))

    def _value(self, path: str) -> Any:
        return self._solo.evaluate(path).value

    def _write(self, path: str, value: Any) -> None:
        self._solo.write(path, value)

    def _force(self, path: str, value: Any) -> None:
        self._solo.force(path, value)
