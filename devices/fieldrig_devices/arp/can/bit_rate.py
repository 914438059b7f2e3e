"""The card's CAN bit rate, @Par[6], which is taken at the start only (digest 6.1)."""

from fieldrig.link import Link
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.can.notices import use_bit_rate
from fieldrig_devices.arp.fixed import SCALE
from fieldrig_devices.arp.parameters import GENERAL, Par, Parameters

KBAUD = 1000  # bit/s


def take_bit_rate(can: Link[CanFrame], parameters: Parameters) -> None:
    """Tell the card's controller its bit rate; call it at power-on, with the link that the bus gave."""
    use_bit_rate(can, parameters.ram[GENERAL][Par.CAN_KBAUD] * KBAUD // SCALE)
