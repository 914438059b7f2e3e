"""The configuration of a controller: which objects there are, and the two files that hold it.

Source: PacDrive manual 3604-3648 (digest PD-021, PD-026, PD-027).  The configuration file (.SCF) names the objects, the
parameter file (.PAR) the start values of parameters "with user initialisation", by their paths.  What the files look
like is our choice: JSON.
"""

import json
from collections.abc import Mapping
from typing import Annotated, Literal, Self

from pydantic import AfterValidator, Field, ValidationError, model_validator

from fieldrig.device import Value
from fieldrig.settings import Settings
from fieldrig.untrusted import MalformedError, read_json
from fieldrig_devices.max4.configuration.limits import MOST_AXES

Commands = Literal["position", "velocity", "torque"]


def _symbol(name: str) -> str:
    """As in IEC code (PD-350)."""
    if not name.isascii() or not name.isidentifier() or len(name) > 32 or "__" in name or name.startswith("_"):
        raise ValueError(
            f"{name!r} is no symbolic name: right would be letters, digits, single underscores, at most 32"
        )
    return name


Symbol = Annotated[str, AfterValidator(_symbol)]


class DriveSettings(Settings):
    """An MC-4."""

    ring_address: int = Field(ge=1, le=254, description="RealTimeBusAdr")
    simulated: bool = Field(default=False, description="there is no drive: the axis is where it is told")
    commands: list[Commands] | None = Field(
        default=None,
        min_length=1,
        description="set values in its telegram; left out: all that the cycle has room for",
    )


class Configuration(Settings):
    """The objects, by their symbolic names."""

    drives: dict[Symbol, DriveSettings] = Field(default_factory=dict, description="MC-4 below the real-time bus")
    logic_encoders: list[Symbol] = Field(default_factory=list, description="logic encoders")
    master_encoders: list[Symbol] = Field(default_factory=list, description="encoder inputs")
    inputs: list[Symbol] = Field(default_factory=list, description="digital inputs")
    outputs: list[Symbol] = Field(default_factory=list, description="digital outputs")
    measuring_inputs: list[Symbol] = Field(default_factory=list, description="touch probe inputs")

    @property
    def symbols(self) -> list[str]:
        lists = (self.logic_encoders, self.master_encoders, self.inputs, self.outputs, self.measuring_inputs)
        return [*self.drives, *(name for names in lists for name in names)]

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        seen: set[str] = {"pacdrivem", "max-4", "max4"}
        for symbol in self.symbols:
            if symbol.casefold() in seen:
                raise ValueError(f"symbolic name {symbol}: there are two of it")
            seen.add(symbol.casefold())
        addresses = [one.ring_address for one in self.drives.values()]
        for address in addresses:
            if addresses.count(address) > 1:
                raise ValueError(f"ring_address {address}: two drives have it")
        if len(self.drives) > MOST_AXES:
            raise ValueError(f"{len(self.drives)} drives: {MOST_AXES} are the most")
        return self


def configuration_to_file(configuration: Configuration) -> bytes:
    return json.dumps(configuration.model_dump(mode="json"), indent=1).encode()


def configuration_of_file(data: bytes) -> Configuration:
    """ValueError if it is none."""
    try:
        return Configuration.model_validate_json(data)
    except ValidationError as cause:
        raise ValueError(f"no control configuration: {cause.errors()[0]['msg']}") from cause


def parameters_to_file(values: Mapping[str, Value]) -> bytes:
    return json.dumps(dict(values), indent=1, ensure_ascii=False).encode()


def parameters_of_file(data: bytes) -> dict[str, Value]:
    """ValueError if they are none."""
    try:
        found = read_json(data)
    except MalformedError as cause:
        raise ValueError("no parameter file") from cause
    if not isinstance(found, dict):
        raise ValueError("no parameter file")
    return {path: value for path, value in found.items() if isinstance(value, bool | int | float | str)}
