"""The controller as a Modbus server.

Source: ours, as the manual describes no access to the blocks (digest section 13).  Registers and bits show the points
of a register table.  The table `blocks.yaml` has the pins of the blocks of a controller without a program, all
terminals and the panel; what this controller does not have does not exist there.  Values that are out of range are
accepted, and the block judges them.
"""

from pathlib import Path
from typing import Final

from pydantic import Field

from fieldrig.settings import ConfigFile
from fieldrig_bus.modbus.identification import Identification
from fieldrig_devices.modbus.point_server import PointServerSettings

BLOCKS: Final = Path(__file__).with_name("blocks.yaml")


class ModbusFaceSettings(PointServerSettings):
    """Settings of the server."""

    table: ConfigFile | None = Field(
        default=None,
        description="register table whose names are points: variables of the program, pins, terminals, panel; "
        "null: the pins of the blocks, the terminals and the panel",
    )
    identification: Identification = Field(
        default_factory=lambda: Identification(product_code="HMISCU", product_name="Magelis SCU"),
        description="response to function 43/14",
    )
