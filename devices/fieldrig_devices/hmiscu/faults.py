"""The faults that an HMISCU takes, and what each of them does to its outputs and its programs.

Source: manual 504-505 (SCU-018), 1395-1412 (SCU-062) and 1424-1426 (SCU-065).
"""

from typing import Annotated, Any, Final, Literal, Protocol

from pydantic import Field

from fieldrig.clock import Clock
from fieldrig.faults.faults import Fault, Faults, Timed, models_of
from fieldrig.faults.injected import InjectedFaults


class LinkBroken(Timed):
    """The link between the control runtime and the firmware of the outputs is broken."""

    what: Literal["link_broken"]


class InternalError(Timed):
    """The firmware of the outputs detects an internal error when the fault begins."""

    what: Literal["internal_error"]


class Offline(Timed):
    """The panel is in the Offline Configuration mode, so the controller is not in RUN."""

    what: Literal["offline"]


class ExitRuntime(Timed):
    """The panel leaves its runtime in order to be switched off; when the fault ends, it starts again."""

    what: Literal["exit_runtime"]


HmiscuFault = Annotated[LinkBroken | InternalError | Offline | ExitRuntime, Field(discriminator="what")]
MODELS: Final = models_of(HmiscuFault)


class Outputs(Protocol):
    """The channels of the fast outputs."""

    def set_linked(self, is_linked: bool) -> None: ...

    def fail(self) -> None: ...


class Runtime(Protocol):
    """The programs of the controller."""

    def hold(self, why: str) -> None:
        """Leave RUN, and stay there for this reason."""

    def release(self, *, is_start: bool) -> None:
        """Go back to RUN if it was there, with start values at a start."""


class HmiscuFaults:
    """The faults of one controller, and their effects."""

    def __init__(self, clock: Clock, outputs: Outputs, runtime: Runtime) -> None:
        self._outputs, self._runtime = outputs, runtime
        self.injected = InjectedFaults[Fault[Any]](clock, MODELS, Faults(Fault), on_change=self._on_change)
        self._is_linked, self._is_failed, self._held = True, False, ""

    def _on_change(self) -> None:
        self._link()
        self._fail()
        self._hold()

    def _link(self) -> None:
        is_linked = self.injected.first(LinkBroken) is None
        if is_linked is not self._is_linked:
            self._is_linked = is_linked
            self._outputs.set_linked(is_linked)

    def _fail(self) -> None:
        is_failed = self.injected.first(InternalError) is not None
        if is_failed and not self._is_failed:
            self._outputs.fail()
        self._is_failed = is_failed

    def _hold(self) -> None:
        exits = self.injected.first(ExitRuntime) is not None
        held = "exit_runtime" if exits else "offline" if self.injected.first(Offline) is not None else ""
        if held and not self._held:
            self._runtime.hold(f"the fault {held}")
        elif self._held and not held:
            self._runtime.release(is_start=self._held == "exit_runtime")
        self._held = held
