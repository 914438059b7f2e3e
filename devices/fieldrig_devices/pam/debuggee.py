"""The application of a PAM for the debugging service (`languages/debugging`)."""

from collections.abc import Mapping
from typing import Protocol

from fieldrig_devices.languages.debugging.debuggee import ProgramState, Reset
from fieldrig_devices.pam.runtime.debuggee import PamDebuggee
from fieldrig_devices.pam.runtime.runtime import Runtime


class Owner(Protocol):
    """The PAM."""

    @property
    def application(self) -> Runtime | None:
        """The application that runs, or has stopped after it has run."""

    @property
    def problem(self) -> str:
        """Why a download was refused, or nothing."""

    @property
    def progress(self) -> str:
        """How far a download is, or nothing."""

    def reset(self) -> None:
        """Carry out a hardware reset."""

    def halt(self) -> None:
        """Stop the application until the next reset."""

    def download(self, files: Mapping[str, str]) -> None:
        """Compile an application, and reset with it if it has no mistakes."""


class DeviceDebuggee(PamDebuggee):
    """An application on a PAM.  It starts by a reset, because a PAM has no other way."""

    def __init__(self, owner: Owner) -> None:
        super().__init__()
        self._owner = owner

    @property
    def runtime(self) -> Runtime | None:
        return self._owner.application

    @property
    def problem(self) -> str:
        return self._owner.problem

    @property
    def progress(self) -> str:
        return self._owner.progress

    @property
    def state(self) -> ProgramState:
        return ProgramState.HELD if self._owner.application is None else super().state

    def start(self) -> None:
        self._owner.reset()

    def stop(self) -> None:
        self._owner.halt()

    def reset(self, kind: Reset) -> None:
        self._owner.reset()

    def download(self, files: Mapping[str, str], *, is_online: bool) -> None:
        if is_online:
            raise ValueError("a PAM has no online change: expected a download, which resets it")
        self._owner.download(files)
