"""The card's CAN bit rate, @Par[6], which applies only from the start (digest 6.1)."""

from fieldrig.link import Link
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.can.notices import use_bit_rate
from fieldrig_devices.arp.fixed import SCALE
from fieldrig_devices.arp.parameters import GENERAL, Par, Parameters

KBAUD = 1000  # bit/s


def take_bit_rate(can: Link[CanFrame], parameters: Parameters) -> None:
    """Set the bit rate of the card's controller.  Call it at power-on with the link from the bus."""
    use_bit_rate(can, parameters.ram[GENERAL][Par.CAN_KBAUD] * KBAUD // SCALE)
