"""The configuration of a controller, which lists its objects, and the two files that store it.

Source: PacDrive manual 3604-3648 (digest PD-021, PD-026, PD-027).  The configuration file (.SCF) names the objects, the
parameter file (.PAR) the start values of parameters "with user initialisation", by their paths.  The format of the
files is our choice: JSON.
"""

import json
from collections.abc import Mapping
from typing import Annotated, Literal, Self

from pydantic import AfterValidator, Field, ValidationError, model_validator

from fieldrig.device import Value
from fieldrig.outside.untrusted import MalformedError, read_json
from fieldrig.settings import Settings
from fieldrig_devices.max4.configuration.limits import MOST_AXES

Commands = Literal["position", "velocity", "torque"]


def symbol_of(name: str) -> str:
    """Check a symbolic name, which follows the rules of IEC code (PD-350)."""
    if not name.isascii() or not name.isidentifier() or len(name) > 32 or "__" in name or name.startswith("_"):
        raise ValueError(f"expected a symbolic name of at most 32 letters, digits and single underscores, got {name!r}")
    return name


Symbol = Annotated[str, AfterValidator(symbol_of)]


class DriveSettings(Settings):
    """Settings of an MC-4."""

    ring_address: int = Field(ge=1, le=254, description="RealTimeBusAdr")
    simulated: bool = Field(
        default=False, description="whether the axis has no drive, and its actual values are its set values"
    )
    commands: list[Commands] | None = Field(
        default=None,
        min_length=1,
        description="set values in its telegram; default: as many as fit into the cycle",
    )


class Configuration(Settings):
    """The objects by their symbolic names."""

    drives: dict[Symbol, DriveSettings] = Field(default_factory=dict, description="MC-4 below the real-time bus")
    logic_encoders: list[Symbol] = Field(default_factory=list, description="logic encoders")
    master_encoders: list[Symbol] = Field(default_factory=list, description="encoder inputs")
    inputs: list[Symbol] = Field(default_factory=list, description="digital inputs")
    outputs: list[Symbol] = Field(default_factory=list, description="digital outputs")
    measuring_inputs: list[Symbol] = Field(default_factory=list, description="touch probe inputs")
    iec_tasks: list[Symbol] = Field(default_factory=list, description="IEC Task objects")
    modems: list[Symbol] = Field(default_factory=list, max_length=1, description="the Modem object, at COM1")

    @property
    def symbols(self) -> list[str]:
        lists = (
            self.logic_encoders,
            self.master_encoders,
            self.inputs,
            self.outputs,
            self.measuring_inputs,
            self.iec_tasks,
            self.modems,
        )
        return [*self.drives, *(name for names in lists for name in names)]

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        seen: set[str] = {"pacdrivem", "max-4", "max4"}
        for symbol in self.symbols:
            if symbol.casefold() in seen:
                raise ValueError(f"symbolic name {symbol}: expected each name once, but it is used twice")
            seen.add(symbol.casefold())
        addresses = [drive.ring_address for drive in self.drives.values()]
        for address in addresses:
            if addresses.count(address) > 1:
                raise ValueError(f"ring_address {address}: expected each address once, but it is used twice")
        if len(self.drives) > MOST_AXES:
            raise ValueError(f"drives: expected at most {MOST_AXES}, got {len(self.drives)}")
        return self


def configuration_to_file(configuration: Configuration) -> bytes:
    return json.dumps(configuration.model_dump(mode="json"), indent=1).encode()


def configuration_of_file(data: bytes) -> Configuration:
    """The configuration in a file.  ValueError if the file is not valid."""
    try:
        return Configuration.model_validate_json(data)
    except ValidationError as cause:
        raise ValueError(f"the control configuration is not valid: {cause.errors()[0]['msg']}") from cause


def parameters_to_file(values: Mapping[str, Value]) -> bytes:
    return json.dumps(dict(values), indent=1, ensure_ascii=False).encode()


def parameters_of_file(data: bytes) -> dict[str, Value]:
    """The start values in a file.  ValueError if the file is not valid."""
    try:
        values = read_json(data)
    except MalformedError as cause:
        raise ValueError("the parameter file is not valid: expected JSON") from cause
    if not isinstance(values, dict):
        raise ValueError("the parameter file is not valid: expected values by path")
    return {path: value for path, value in values.items() if isinstance(value, bool | int | float | str)}
