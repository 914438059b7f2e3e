"""The settings of a modem: the active profile, and what its memory keeps: two profiles and telephone numbers."""

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Final, Self

from fieldrig_devices.modem.commands import COMMANDS, REGISTERS
from fieldrig_devices.modem.extended import PARAMETERS, TWINS, Value, fitting

PROFILES: Final = 2
NUMBERS: Final = 4
LONGEST_NUMBER: Final = 64
DEFAULTS: Final = {name: command.default for name, command in COMMANDS.items() if command.default is not None}


@dataclass
class Profile:
    """Settings by command, by number of the S register, and by extended command; new, they are the factory's."""

    settings: dict[str, int] = field(default_factory=lambda: dict(DEFAULTS))
    registers: dict[int, int] = field(
        default_factory=lambda: {number: register.default for number, register in REGISTERS.items()}
    )
    parameters: dict[str, tuple[Value, ...]] = field(
        default_factory=lambda: {name: tuple(place.default for place in PARAMETERS[name]) for name in PARAMETERS}
    )

    def copy(self) -> "Profile":
        return Profile(dict(self.settings), dict(self.registers), dict(self.parameters))

    def set(self, name: str, value: int) -> None:
        """Set a basic command, and the parameter that says the same."""
        self.settings[name] = value
        if name in TWINS:
            parameter, values = TWINS[name]
            self.parameters[parameter] = values[value]

    def set_parameter(self, name: str, values: tuple[Value, ...]) -> None:
        """Set a parameter, and the basic command that says the same, if one does."""
        self.parameters[name] = values
        for command, (parameter, twins) in TWINS.items():
            for value, twin in twins.items():
                if parameter == name and twin == values:
                    self.settings[command] = value

    def to_json(self) -> dict[str, Any]:
        kept = {str(number): value for number, value in self.registers.items() if REGISTERS[number].is_kept}
        return {"settings": self.settings, "registers": kept, "parameters": self.parameters}

    @classmethod
    def from_json(cls, data: Any) -> Self:
        """Return the profile.  ValueError for data that are not one."""
        profile = cls()
        for name, value in _entries(data, "settings"):
            if name not in DEFAULTS or type(value) is not int or value not in COMMANDS[name].values:
                raise ValueError(f"{name}{value} is not a setting")
            profile.set(name, value)
        for name, value in _entries(data, "registers"):
            number = int(name) if name.isascii() and name.isdigit() else -1
            register = REGISTERS.get(number)
            if register is None or type(value) is not int or not register.low <= value <= register.high:
                raise ValueError(f"S{name}={value} is not a register")
            profile.registers[number] = value
        for name, value in _entries(data, "parameters"):
            if name not in PARAMETERS or not isinstance(value, list) or not fitting(name, value):
                raise ValueError(f"{name}={value} is not a parameter")
            profile.parameters[name] = tuple(value)
        return profile


@dataclass
class Memory:
    """The content of the non-volatile memory; new, it is as delivered."""

    profiles: list[Profile] = field(default_factory=lambda: [Profile() for _ in range(PROFILES)])
    first: int = 0
    """The profile that is active at power-on (&Y)."""
    numbers: list[str] = field(default_factory=lambda: [""] * NUMBERS)

    def encode(self) -> bytes:
        data = {
            "profiles": [profile.to_json() for profile in self.profiles],
            "first": self.first,
            "numbers": self.numbers,
        }
        return json.dumps(data, sort_keys=True).encode()

    @classmethod
    def decode(cls, data: bytes) -> Self:
        """The inverse of `encode`.  ValueError for anything else."""
        try:
            kept = json.loads(data)
        except RecursionError as cause:
            raise ValueError("too deeply nested") from cause
        match kept:
            case {"profiles": list(profiles), "first": int(first), "numbers": list(numbers)} if (
                len(profiles) == PROFILES and 0 <= first < PROFILES and _are_numbers(numbers)
            ):
                return cls([Profile.from_json(profile) for profile in profiles], int(first), numbers)
        raise ValueError("not the memory of a modem")


def _are_numbers(numbers: list[Any]) -> bool:
    return len(numbers) == NUMBERS and all(
        isinstance(number, str) and len(number) <= LONGEST_NUMBER for number in numbers
    )


def _entries(data: Any, key: str) -> list[tuple[str, Any]]:
    entries = data.get(key) if isinstance(data, Mapping) else None
    if not isinstance(entries, Mapping):
        raise ValueError(f"a profile without {key}")
    return list(entries.items())


def shown(title: str, profile: Profile) -> str:
    """Return a profile as &V shows it."""
    settings = " ".join(f"{name}{value}" for name, value in profile.settings.items())
    registers = " ".join(f"S{number:02d}:{value:03d}" for number, value in profile.registers.items())
    parameters = " ".join(f"{name}={','.join(map(str, values))}" for name, values in profile.parameters.items())
    return f"{title}:\n{settings}\n{registers}\n{parameters}"
