"""Settings of a CANopen node in a rig file."""

from typing import Annotated, Self

from pydantic import Field, model_validator

from fieldrig.settings import ConfigFile, Settings
from fieldrig_devices.canopen import eds
from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.canopen.port import UNCONFIGURED
from fieldrig_devices.canopen.ties import Tie, bind

SERIAL_NUMBER = "1018:04"


class CanopenSettings(Settings):
    node_id: Annotated[
        int | None, Field(ge=1, le=127, description="null: none yet, the node waits until it gets one by LSS")
    ]
    eds: Annotated[ConfigFile, Field(description="EDS or DCF file, relative to the folder of the configuration")]
    ties: Annotated[
        dict[str, str | Tie],
        Field(
            default_factory=dict,
            description="wires at objects: '6200:01' or '6200:01.3' (bit 3) to the name of a wire, or more of it",
        ),
    ]
    objects: Annotated[
        dict[str, bool | int | float | str],
        Field(default_factory=dict, description="power-on values other than the EDS's, such as '1017:00': 500"),
    ]
    serial_number: Annotated[
        int | None, Field(ge=0, le=0xFFFF_FFFF, description="in place of the EDS's in 1018h sub-index 4")
    ] = None
    sdo_timeout_ms: Annotated[int, Field(gt=0, description="how long the SDO server waits for the next segment")] = 1000
    sdo_block_size: Annotated[
        int, Field(ge=1, le=127, description="segments that a client may send in one block of a block download")
    ] = 127
    time_period_ms: Annotated[
        int, Field(gt=0, description="how often the time is told if 1012h makes the node its producer")
    ] = 1000

    @model_validator(mode="after")
    def _fits_the_eds(self) -> Self:
        dictionary = self.dictionary()
        if self.node_id is None and not dictionary.features.has_lss:
            raise ValueError("node_id: null needs LSS, and the EDS says LSS_Supported=0; a number would be right")
        bind(dictionary, self.ties)
        return self

    def dictionary(self, node_id: int | None = None) -> Dictionary:
        """As these settings describe it, for their own node-ID or another.

        ValueError, with what would be right, if they don't fit the EDS.
        """
        dictionary = eds.load(self.eds, node_id or self.node_id or UNCONFIGURED)
        start_values = dict(self.objects)
        if self.serial_number is not None:
            start_values[SERIAL_NUMBER] = self.serial_number
        for key, value in start_values.items():
            variable = dictionary.by_key(key)
            try:
                variable.put(value)
            except ValueError as wrong:
                raise ValueError(f"objects: {key}: {wrong}") from wrong
            variable.start = variable.data
        return dictionary
