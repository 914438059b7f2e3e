"""The common part of debuggees whose devices load a program and command it, whatever its language is."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping

from fieldrig.device import Value
from fieldrig_devices.languages.debugging.debuggee import Reset, Variable, evaluated


class DebuggeeBase(ABC):
    """A debuggee without its language.  The controller adds its commands, which `Debuggee` describes."""

    def __init__(self) -> None:
        self.on_stop: Callable[[], None] = lambda: None
        self.on_load: Callable[[], None] = lambda: None

    @property
    def progress(self) -> str:
        return ""

    @property
    def problem(self) -> str:
        return ""

    @abstractmethod
    def start(self) -> None: ...

    @abstractmethod
    def stop(self) -> None: ...

    @abstractmethod
    def reset(self, kind: Reset) -> None: ...

    @abstractmethod
    def download(self, files: Mapping[str, str], *, is_online: bool) -> None: ...

    @abstractmethod
    def evaluate(self, text: str, thread: int | None = None, frame: int = 0) -> Variable: ...

    def reader(self, text: str) -> Callable[[], Value | None]:
        return evaluated(self, text)
