"""Applications that arrive while the PAM is on: they are compiled beside the one that runs."""

from collections.abc import Callable, Mapping

from fieldrig.background import Background, Report
from fieldrig_devices.languages.beside import Beside, Refused, duration_of
from fieldrig_devices.languages.mistakes import CompileError
from fieldrig_devices.pam.runtime.compiler import Compiled, compile_application

Sources = tuple[tuple[str, str], ...]
"""Names and texts; the first file is the application, and the others are included."""


def compile_sources(sources: Sources, report: Report) -> Compiled | Refused:
    """Compile an application in a process beside the PAM."""
    (name, text), *included = sources
    report("compiling", 0, 1)
    try:
        return compile_application(text, name, dict(included).get, is_debugged=True)
    except CompileError as wrong:
        return Refused(tuple(wrong.mistakes))


class Downloads:
    """The downloads of one PAM."""

    def __init__(self, background: Background, on_loaded: Callable[[Compiled], None]) -> None:
        self._beside = Beside[Compiled](background)
        self._on_loaded = on_loaded
        self.problem = ""
        """Why the last application was refused; empty if it was loaded."""

    @property
    def progress(self) -> str:
        return self._beside.progress

    def begin(self, files: Mapping[str, str], main: str) -> None:
        """Compile an application; `main` is the name of its first file, if it is among them, or else the first is."""
        if not files:
            raise ValueError("there is nothing to download: expected the source of an application")
        first = main if main in files else next(iter(files))
        sources = ((first, files[first]), *((name, text) for name, text in files.items() if name != first))
        self.problem = ""
        self._beside.compile(compile_sources, sources, duration_of(files.values()), self._on_done)

    def cancel(self) -> None:
        self._beside.cancel()

    def _on_done(self, found: Compiled | str) -> None:
        if isinstance(found, str):
            self.problem = found
        else:
            self._on_loaded(found)
