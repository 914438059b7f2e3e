"""A program of an ARP card under test in Python: a language of `fieldrig.programs`.

The card is alone, with its input Enable closed: no drive, no other card and no I/O node is there.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from fieldrig.clock import S
from fieldrig.errors import ControlError, RigError, UsageError
from fieldrig.programs import checked_duration
from fieldrig_bus.wires import Signal
from fieldrig_devices.languages.bench import WatchedBench, check_options
from fieldrig_devices.languages.debugging.debuggee import ProgramState

if TYPE_CHECKING:
    from fieldrig.virtual.rig import Rig

CARD: Final = "card"
ENABLE: Final = "I108"
"""The input Enable, without which a card runs no program (manual 3.3); a test opens it with `bench["I108"] = False`."""
ENABLE_WIRE: Final = "enable"
BOOT_NS: Final = 10 * S
"""The longest time that a card takes to have its program after power-on."""


def takes(path: Path) -> bool:
    from fieldrig_devices.arp.language.files import system_of

    return system_of(path) is not None


def load(paths: list[Path], options: Mapping[str, Any]) -> "ArpBench":
    """Load a source file.  ConfigError with every mistake."""
    check_options(options)
    if len(paths) != 1:
        raise UsageError(f"a card has one program, and {len(paths)} files were given", "expected one source file")
    return ArpBench(paths[0])


class ArpBench(WatchedBench):
    def __init__(self, file: Path) -> None:
        super().__init__()
        self._file = file.absolute()
        self._load()

    def _load(self) -> None:
        """Switch the card on, and wait until it has its program."""
        self._rig = self._made()
        self._rig.until(self._is_ready, within=BOOT_NS)
        self._begin_ns = self._rig.now_ns

    def _is_ready(self) -> bool:
        state = self._ask("state")
        return not state["progress"] and state["state"] != ProgramState.NONE.value

    def _made(self) -> "Rig":
        from fieldrig.config.rig_file import from_dict
        from fieldrig.virtual.rig import Rig

        card = {
            "kind": "arp",
            "number": 1,
            "program": str(self._file),
            "links": {"wires": "wires"},
            "signals": {ENABLE: ENABLE_WIRE},
        }
        buses = {"wires": {"kind": "wires.virtual"}}
        rig = Rig(from_dict({"time": "virtual", "buses": buses, "devices": {CARD: card}}))
        self._send = rig.attach("test").link("wires").send
        self._send(Signal(ENABLE_WIRE, True))
        return rig

    def _ask(self, command: str, **more: Any) -> Any:
        try:
            return self._rig.answer(CARD, "debug", {"command": command, **more})
        except ControlError as wrong:
            raise ValueError(f"{wrong.what}\n{wrong.remedy}") from wrong

    def reset(self) -> None:
        super().reset()
        self._rig.close()
        self._load()

    @property
    def now_ns(self) -> int:
        return self._rig.now_ns - self._begin_ns

    @property
    def events(self) -> Sequence[str]:
        return [thread["about"] for thread in self._ask("state")["threads"] if thread["about"]]

    def start(self) -> None:
        try:
            self._ask("start")
        except ValueError as wrong:
            what, _, remedy = str(wrong).partition("\n")
            missing = "a program that waits for other nodes needs a rig with them"
            raise RigError(what, remedy or missing) from wrong

    def stop(self) -> None:
        self._ask("stop")

    def advance(self, duration_ns: int) -> None:
        before = list(self.events)
        self._rig.run_for(checked_duration(duration_ns))
        if self.events and not before:
            raise RigError("an error has stopped the program", "\n".join(self.events))

    def _value(self, path: str) -> Any:
        [variable] = self._ask("read", names=[path])["variables"]
        if "error" in variable:
            raise ValueError(variable["error"])
        return variable["value"]

    def _write(self, path: str, value: Any) -> None:
        if path.upper() == ENABLE:
            self._send(Signal(ENABLE_WIRE, bool(value)))
        else:
            self._ask("write", values={path: value})

    def _force(self, path: str, value: Any) -> None:
        if value is None:
            self._ask("release", names=[path])
        else:
            self._ask("force", values={path: value})
