"""Names that a user types, checked at once: a wrong one is answered with the nearest one that exists."""

from collections.abc import Iterable, Sequence
from fnmatch import fnmatchcase
from typing import TYPE_CHECKING, Any

from fieldrig.errors import ControlError
from fieldrig.text.nearest import closest

if TYPE_CHECKING:
    from fieldrig.control.messages import Client


def check_name(name: str, known: Iterable[str], wrong: str) -> None:
    """ControlError that begins with `wrong` and the name, with the nearest known name, if it is none of them."""
    names = list(dict.fromkeys(known))
    if name not in names:
        raise ControlError(f"{wrong} {name!r}", closest(name, names))


def unfit(patterns: Iterable[str], known: Sequence[str]) -> str | None:
    """Return the first pattern that fits none of the known names; a * matches any characters.  None if all fit."""
    return next((pattern for pattern in patterns if not any(fnmatchcase(name, pattern) for name in known)), None)


def check_patterns(patterns: Iterable[str], known: Sequence[str], wrong: str) -> None:
    """ControlError that begins with `wrong` and the first pattern that fits none of the known names."""
    pattern = unfit(patterns, known)
    if pattern is not None:
        raise ControlError(f"{wrong} {pattern!r}", closest(pattern, list(known)))


class Parts:
    """The parts of a running rig.  Their names are checked before anything is asked."""

    def __init__(self, client: "Client") -> None:
        self._client = client
        self.status: dict[str, Any] = client.ask("rig/status")
        self.buses: list[str] = list(self.status["buses"])
        self.devices: list[str] = list(self.status["devices"])

    @property
    def rig(self) -> str:
        """The name of the rig."""
        return str(self.status["rig"])

    def ask_device(self, device: str, verb: str, message: Any = None) -> Any:
        """Ask a device.  ControlError for an unknown device, or one that does not answer."""
        check_name(device, self.devices, f"{self.rig} has no device")
        return self._client.ask(f"device/{device}/{verb}", message)

    def check_buses(self, patterns: Iterable[str]) -> None:
        """ControlError for the first pattern that fits no bus."""
        for pattern in patterns:
            if pattern in self.devices:
                raise ControlError(
                    f"{pattern!r} is a device of {self.rig}, not a bus",
                    f"its values are written with a /, such as `fieldrig watch {pattern}/*`; buses are:"
                    f" {', '.join(self.buses)}",
                )
        check_patterns(patterns, self.buses, f"{self.rig} has no bus")
