"""The power-on values that a node would refuse to a master, for the objects of CiA 301 whose values are not a range.

Source: the chapters of the objects in CiA 301, 7.5.2.  Left out: what depends on the state of the node, such as a
mapping that may be changed only while its PDO is switched off, as a power-on value changes nothing.
"""

from collections.abc import Iterator

from fieldrig_devices.canopen import emcy
from fieldrig_devices.canopen.cob_id import is_restricted, is_valid, is_well_formed
from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.canopen.error_behaviour import ERROR_BEHAVIOUR, REACTIONS
from fieldrig_devices.canopen.heartbeat import CONSUMER_TIME, is_watched_twice
from fieldrig_devices.canopen.pdo import rpdo, tpdo
from fieldrig_devices.canopen.variable import Variable

PDOS = 512
"""Number of PDOs of each direction, by their indices."""


def wrong_start(dictionary: Dictionary, variable: Variable) -> str:
    """Return what was expected of the present value of this object; "" for a value that it can have."""
    return next(_expected(dictionary, variable), "")


def _expected(dictionary: Dictionary, variable: Variable) -> Iterator[str]:
    index, subindex, number = variable.index, variable.subindex, variable.number
    is_rpdo, is_tpdo = (first <= index < first + PDOS for first in (rpdo.COMMUNICATION, tpdo.COMMUNICATION))
    if index == ERROR_BEHAVIOUR and subindex and number not in REACTIONS:
        yield f"expected one of {', '.join(map(str, REACTIONS))}"
    if is_rpdo and subindex == 2 and not rpdo.is_type(number):
        yield "expected a transmission type of an RPDO: 0 to 240, 254 or 255"
    if is_tpdo and subindex == 2 and not tpdo.is_type(number):
        yield "expected a transmission type of a TPDO: 0 to 240, or 252 to 255"
    if index == CONSUMER_TIME and subindex and is_watched_twice(variable, dictionary.members(CONSUMER_TIME)):
        yield "expected a node-ID that no other sub-index has"
    is_cob_id = index == emcy.COB_ID or ((is_rpdo or is_tpdo) and subindex == 1)
    if is_cob_id and is_valid(number) and (is_restricted(number) or not is_well_formed(number)):
        yield "expected a COB-ID that no other service has, with 11 bits or bit 29 set"
