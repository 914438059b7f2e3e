"""Settings of a CANopen node in a rig file."""

from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Annotated, Self

from pydantic import Field, model_validator

from fieldrig.clock import MS
from fieldrig.errors import Mistake
from fieldrig.settings import Claim, ConfigFile, Settings, WrongKey, refuse_all
from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.canopen.eds import reader as eds
from fieldrig_devices.canopen.eds.text import EdsError
from fieldrig_devices.canopen.living import living_variable
from fieldrig_devices.canopen.port import UNCONFIGURED
from fieldrig_devices.canopen.signals import SignalSettings, bind
from fieldrig_devices.canopen.start_values import wrong_start
from fieldrig_devices.sources.settings import SourceSettings

SERIAL_NUMBER = "1018:04"


class CanopenSettings(Settings):
    node_id: Annotated[int | None, Field(ge=1, le=127, description="null: the node is unconfigured and waits for LSS")]
    eds: Annotated[ConfigFile, Field(description="EDS or DCF file, relative to the folder of the configuration")]
    signals: Annotated[
        dict[str, str | SignalSettings],
        Field(
            default_factory=dict,
            description="signals by object, '6200:01' or '6200:01.3' (bit 3): a wire's name, or settings with it",
        ),
    ]
    objects: Annotated[
        dict[str, bool | int | float | str],
        Field(default_factory=dict, description="power-on values that replace the EDS's, such as '1017:00': 500"),
    ]
    sources: dict[str, SourceSettings] = Field(
        default_factory=dict, description="objects whose values live by themselves, by '2000:01'"
    )
    serial_number: Annotated[
        int | None, Field(ge=0, le=0xFFFF_FFFF, description="replaces the EDS's value of 1018h sub-index 4")
    ] = None
    sdo_timeout_ms: Annotated[int, Field(gt=0, description="how long the SDO server waits for the next segment")] = 1000
    sdo_block_size: Annotated[
        int, Field(ge=1, le=127, description="segments that a client may send in one block of a block download")
    ] = 127
    boot_up_ms: Annotated[
        float, Field(ge=0, le=600_000, description="time from power-on or a reset until the boot-up message")
    ] = 0.0
    time_period_ms: Annotated[
        int, Field(gt=0, description="period of TIME messages if 1012h makes the node a producer")
    ] = 1000
    maps_while_valid: Annotated[
        bool,
        Field(description="a master may change the mapping of a PDO without making it invalid, which CiA 301 asks for"),
    ] = False

    @model_validator(mode="after")
    def _fits_the_eds(self) -> Self:
        refuse_all(self._wrong())
        return self

    def _wrong(self) -> Iterator[WrongKey]:
        try:
            description = eds.describe(self.eds, self.node_id or UNCONFIGURED)
        except EdsError:
            yield WrongKey(("eds",), _everything(self.eds), "`fieldrig eds check` gives the same list")
            return
        if self.node_id is None and not description.features.has_lss:
            yield WrongKey(
                ("node_id",), "null needs LSS, but the EDS has LSS_Supported=0; expected a number from 1 to 127"
            )
        if not (self._start_values() or self.signals or self.sources):
            return  # a dictionary may have thousands of objects
        dictionary = eds.load(self.eds, self.node_id or UNCONFIGURED)
        for key, value in self._start_values().items():
            yield from _tried(self._place_of(key), partial(_start, dictionary, key, value))
        yield from self._wrong_starts_of(dictionary)
        for key, signal in self.signals.items():
            yield from _tried(("signals", key), partial(bind, dictionary, {key: signal}))
        for key in self.sources:
            yield from _tried(("sources", key), partial(living_variable, dictionary, key))

    def _wrong_starts_of(self, dictionary: Dictionary) -> Iterator[WrongKey]:
        """Yield the objects of these settings with a value that the node would refuse to a master."""
        for key in self.objects:
            try:
                variable = dictionary.by_key(key)
            except ValueError:  # another mistake already
                continue
            if remedy := wrong_start(dictionary, variable):
                yield WrongKey(self._place_of(key), f"the node has no {variable.value} here", remedy)

    def _place_of(self, key: str) -> tuple[str, ...]:
        """Return the key of the settings that gives the start value of this object."""
        return ("objects", key) if key in self.objects else ("serial_number",)

    def doubts(self) -> Iterator[Mistake | WrongKey]:
        from fieldrig_devices.canopen.eds.check import check_eds  # only `fieldrig check` needs it

        for finding in check_eds(self.eds):
            yield Mistake(str(self.eds), finding.line, finding.place, finding.what, finding.remedy)

    def claims(self, device: str) -> Iterator[Claim]:
        if self.node_id is not None:
            yield Claim("can", "node-ID", self.node_id, ("node_id",))
        if not self.signals:
            return
        dictionary = eds.load(self.eds, self.node_id or UNCONFIGURED)
        for key, binding in zip(self.signals, bind(dictionary, self.signals), strict=True):
            if binding.is_output:
                yield Claim("wires", "wire", binding.settings.wire, ("signals", key))

    @property
    def boot_up_ns(self) -> int:
        """Time from power-on or a reset until the boot-up message, in ns."""
        return round(self.boot_up_ms * MS)

    def _start_values(self) -> dict[str, bool | int | float | str]:
        own = {} if self.serial_number is None else {SERIAL_NUMBER: self.serial_number}
        return {**self.objects, **own}

    def dictionary(self, node_id: int | None = None) -> Dictionary:
        """Return the object dictionary of these settings, for their own node-ID or another.

        Raises ValueError, with what was expected, if they don't fit the EDS.
        """
        dictionary = eds.load(self.eds, node_id or self.node_id or UNCONFIGURED)
        for key, value in self._start_values().items():
            _start(dictionary, key, value)
        dictionary.features = dictionary.features._replace(maps_while_valid=self.maps_while_valid)
        return dictionary


def _everything(path: Path) -> str:
    """Return all findings in a file that is refused, not only those for which it is refused."""
    from fieldrig_devices.canopen.eds.check import check_eds

    return "\n".join(f"{path.name}:{finding}" for finding in check_eds(path))


def _tried(place: tuple[str, ...], try_it: Callable[[], object]) -> Iterator[WrongKey]:
    try:
        try_it()
    except ValueError as wrong:
        yield WrongKey(place, str(wrong))


def _start(dictionary: Dictionary, key: str, value: bool | int | float | str) -> None:
    variable = dictionary.by_key(key)
    variable.put(value)
    variable.start = variable.data
