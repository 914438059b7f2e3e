"""Carries out the commands of a line one after the other, and gives the result of the line.

Source: ITU-T V.250, 5.4 and 5.7: a line has one result, and after a mistake nothing more of it is carried out.  After
an answer, a reset or a call, the rest of the line is ignored; so it is after O.
"""

from collections.abc import Callable
from typing import Final, Protocol

from fieldrig_devices.modem import extended, results
from fieldrig_devices.modem.commands import COMMANDS, REGISTERS
from fieldrig_devices.modem.extended import PARAMETERS, ROCKWELL_ONLY, TEXTS
from fieldrig_devices.modem.parser import Basic, Dial, Extended, Item, Mistake, Register, StoreNumber, parse
from fieldrig_devices.modem.profile import DEFAULTS, LONGEST_NUMBER, NUMBERS, Memory, Profile, shown
from fieldrig_devices.modem.results import Result

IDENTITY: Final[dict[int, str]] = {
    0: "33600", 1: "000", 2: "OK", 3: "fieldrig modem", 4: "data only, error correction", 5: "000", 6: "fieldrig",
    7: "1", 8: "000", 9: "fieldrig",
}  # fmt: skip
"""The texts of I."""
BUSY_WITH_IT: Final = Result(-1, "")
"""The result comes later, or there is none."""


class Actions(Protocol):
    """The parts of the modem that commands move.  Each returns the result, or `BUSY_WITH_IT`."""

    def answer(self) -> Result: ...
    def dial(self, string: str, stays: bool) -> Result: ...
    def hang_up(self) -> Result: ...
    def seize(self) -> Result: ...
    def go_online(self) -> Result: ...
    @property
    def save(self) -> Callable[[Memory], Result]: ...
    def on_setting(self) -> None:
        """React to a changed setting."""


class Interpreter:
    def __init__(self, actions: Actions, memory: Memory, write: Callable[[str], None], is_rockwell: bool) -> None:
        """`write` gives an information text to the terminal."""
        self._actions, self.memory, self._write, self._is_rockwell = actions, memory, write, is_rockwell
        self.profile = memory.profiles[memory.first].copy()
        self.is_pulse = False
        """Digits are dialled by pulses (P), not tones (T)."""
        self._selected = 0
        self._last_line = ""
        self._last_number = ""

    def run(self, body: str) -> Result:
        self._last_line = body
        for item in parse(body):
            result = self._carry_out(item)
            if result is not results.OK:
                return result
            if isinstance(item, Basic) and item.name == "Z":
                break
        return results.OK

    def repeat(self) -> Result:
        return self.run(self._last_line)

    def reset(self, number: int) -> None:
        """Make a stored profile the active one."""
        self.profile, self.is_pulse = self.memory.profiles[number].copy(), False
        self._actions.on_setting()

    def _carry_out(self, item: Item) -> Result:
        match item:
            case Basic(name, value):
                return self._basic(name, value)
            case Register():
                return self._register(item)
            case Dial(string, stays):
                return self._dial(string, stays)
            case Extended(name, operation, fields):
                return self._extended(name, operation, fields)
            case StoreNumber(place, string) if place < NUMBERS and len(string) <= LONGEST_NUMBER:
                numbers = [string if at == place else number for at, number in enumerate(self.memory.numbers)]
                return self._save(Memory(self.memory.profiles, self.memory.first, numbers))
            case StoreNumber() | Mistake():
                return results.ERROR

    def _basic(self, name: str, value: int) -> Result:
        command = COMMANDS.get(name)
        if command is None or value not in command.values:
            return results.ERROR
        if name in DEFAULTS:
            self.profile.set(name, value)
            self._actions.on_setting()
            return results.OK
        return self._act(name, value)

    def _act(self, name: str, value: int) -> Result:
        actions, memory = self._actions, self.memory
        match name:
            case "A":
                return actions.answer()
            case "H":
                return actions.seize() if value else actions.hang_up()
            case "O":
                return actions.go_online()
            case "I":
                self._write(IDENTITY[value])
            case "Z":
                actions.hang_up()
                self.reset(value)
            case "P" | "T":
                self.is_pulse = name == "P"
            case "&F":
                self.profile = Profile(registers={**Profile().registers, 1: self.profile.registers[1]})
                actions.on_setting()
            case "&V":
                self._show_profiles()
            case "&W":
                kept = [self.profile.copy() if at == value else profile for at, profile in enumerate(memory.profiles)]
                return self._save(Memory(kept, memory.first, memory.numbers))
            case "&Y":
                return self._save(Memory(memory.profiles, value, memory.numbers))
        return results.OK

    def _save(self, memory: Memory) -> Result:
        result = self._actions.save(memory)
        if result is results.OK:
            self.memory = memory
        return result

    def _show_profiles(self) -> None:
        parts = [shown("ACTIVE PROFILE", self.profile)]
        parts += [shown(f"STORED PROFILE {at}", profile) for at, profile in enumerate(self.memory.profiles)]
        parts.append("TELEPHONE NUMBERS:\n" + "\n".join(f"{at}={text}" for at, text in enumerate(self.memory.numbers)))
        self._write("\n".join(parts))

    def _register(self, item: Register) -> Result:
        number = self._selected if item.number is None else item.number
        register = REGISTERS.get(number)
        if register is None:
            return results.ERROR
        self._selected = number
        if item.is_read:
            self._write(f"{self.profile.registers[number]:03d}")
        elif item.value is not None:
            if not register.low <= item.value <= register.high:
                return results.ERROR
            self.profile.registers[number] = item.value
            self._actions.on_setting()
        return results.OK

    def _dial(self, string: str, stays: bool) -> Result:
        if string.startswith("L"):
            string = self._last_number
        elif string.startswith("S"):
            stored = string[1:].removeprefix("=") or "0"
            if not (stored.isascii() and stored.isdigit() and int(stored) < NUMBERS):
                return results.ERROR
            string = self.memory.numbers[int(stored)]
        self._last_number = string
        return self._actions.dial(string, stays)

    def _extended(self, name: str, operation: str, fields: tuple[str, ...]) -> Result:
        if name in ROCKWELL_ONLY and not self._is_rockwell:
            return results.ERROR
        if name in TEXTS and operation in ("", "?"):
            self._write(TEXTS[name])
        elif name in TEXTS and operation == "=?":
            return results.OK
        elif name not in PARAMETERS:
            return results.ERROR
        elif operation == "=?":
            self._write(extended.shown_test(name))
        elif operation == "?":
            self._write(extended.shown_value(name, self.profile.parameters[name]))
        else:
            values = extended.with_fields(name, self.profile.parameters[name], fields) if operation else None
            if values is None:
                return results.ERROR
            self.profile.set_parameter(name, values)
            self._actions.on_setting()
        return results.OK
