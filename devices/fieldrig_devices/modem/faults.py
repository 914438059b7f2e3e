"""The faults of a modem; those of its telephone line are faults of the network."""

from collections.abc import Mapping
from typing import Annotated, Any, Final, Literal

from pydantic import Field

from fieldrig.faults.faults import Timed, models_of


class PowerOff(Timed):
    """The modem has no power: it ends a call, its control lines are off, and afterwards it starts again."""

    what: Literal["power_off"]


class SerialUnplugged(Timed):
    """The serial cable is pulled out: both ends see all control lines off."""

    what: Literal["serial_unplugged"]


class SerialMiswired(Timed):
    """TxD and RxD of the serial cable are not crossed over: no data pass, but the control lines do (PD-270)."""

    what: Literal["serial_miswired"]


class LineUnplugged(Timed):
    """The telephone cable is pulled out: no dial tone, no ringing, and a call loses its carrier."""

    what: Literal["line_unplugged"]


ModemFault = Annotated[PowerOff | SerialUnplugged | SerialMiswired | LineUnplugged, Field(discriminator="what")]
MODELS: Final[Mapping[str, type[Any]]] = models_of(ModemFault)
