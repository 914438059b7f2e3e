"""The application of a PAM in a rig, for the debugging service: start and stop hold and release its programs."""

from collections.abc import Callable, Mapping
from functools import partial

from fieldrig.loop.background import Background, Report
from fieldrig_devices.languages.beside import Beside, Refused, duration_of
from fieldrig_devices.languages.debugging.debuggee import Reset
from fieldrig_devices.languages.mistakes import CompileError
from fieldrig_devices.pam.runtime.compiler import Compiled, compile_application
from fieldrig_devices.pam.runtime.debuggee import PamDebuggee
from fieldrig_devices.pam.runtime.runtime import Runtime


def prepare(files: Mapping[str, str], report: Report, *, ignores_case: bool = False) -> Compiled | Refused:
    """Compile an application in a process of its own; the first file includes the others."""
    name, text = next(iter(files.items()))
    report("compiling", 0, 1)
    try:
        return compile_application(text, name, files.get, ignores_case=ignores_case, is_debugged=True)
    except CompileError as wrong:
        return Refused(tuple(wrong.mistakes))


class MachineDebuggee(PamDebuggee):
    """The PAM calls `attach` whenever it has started an application."""

    def __init__(
        self,
        background: Background,
        present: Callable[[], Runtime | None],
        on_reset: Callable[[], None],
        on_download: Callable[[Compiled], None],
        *,
        ignores_case: bool,
    ) -> None:
        """`present` returns the application once it has been started; `on_download` takes another one and resets."""
        super().__init__()
        self._beside, self._present = Beside[Compiled](background), present
        self._on_reset, self._on_download = on_reset, on_download
        self._prepare = partial(prepare, ignores_case=ignores_case)
        self._problem = ""

    @property
    def runtime(self) -> Runtime | None:
        return self._present()

    @property
    def progress(self) -> str:
        return self._beside.progress

    @property
    def problem(self) -> str:
        return self._problem

    def start(self) -> None:
        """Let the programs go on after `stop`."""
        self.go_on()

    def stop(self) -> None:
        """Hold the programs; the ring and the pipes go on."""
        self.pause()

    def reset(self, kind: Reset) -> None:
        """Begin again as after a hardware reset; nothing is retained (G-13)."""
        if kind is Reset.ORIGIN:
            raise ValueError("a PAM always has an application: expected a download of another one")
        self._on_reset()

    def download(self, files: Mapping[str, str], *, is_online: bool) -> None:
        if is_online:
            raise ValueError("a PAM has no online change: expected a download, which begins with a reset")
        if not files:
            raise ValueError("a download has no file: expected the source file of an application first")
        self._problem = ""
        self._beside.compile(self._prepare, dict(files), duration_of(files.values()), self._on_compiled)

    def cancel(self) -> None:
        """Drop what is being compiled."""
        self._beside.cancel()

    def _on_compiled(self, outcome: Compiled | str) -> None:
        if isinstance(outcome, str):
            self._problem = outcome
            return
        self._on_download(outcome)
        self.on_load()
