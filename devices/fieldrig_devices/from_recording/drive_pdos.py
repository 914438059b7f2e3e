"""The usual mapping of the PDOs of a drive, for one whose mapping no master has read.

Source: CiA 402-3, the PDOs of the generic mapping, as our own drive has them.
"""

from fieldrig_devices.canopen.cob_id import is_valid
from fieldrig_devices.cia402.objects import STATUS_WORD
from fieldrig_devices.drive_profile.states import State
from fieldrig_devices.from_recording.identifiers import Identifier
from fieldrig_devices.from_recording.known_objects import of_drives
from fieldrig_devices.from_recording.layout import Layout, part_of
from fieldrig_devices.from_recording.pdos import Pdo

STATE_MASK = 0x6F
STATES = frozenset(state.value for state in State)


def usual_layout(pdo: Pdo, log: Identifier) -> Layout | None:
    """Return the usual layout if length and contents of the frames fit it: a status word has a state of CiA 402."""
    dictionary = of_drives()
    if not is_valid(dictionary.number(pdo.parameter, 1, 1 << 31)):
        return None
    count = dictionary.number(pdo.mapping, 0)
    parts = [part_of(dictionary.number(pdo.mapping, place)) for place in range(1, count + 1)]
    if sum(part.bits for part in parts) != 8 * log.length or not parts:
        return None
    layout = Layout(parts, is_known=True, is_assumed=True)
    place = next((place for place, part in enumerate(parts) if part.object == STATUS_WORD), None)
    if pdo.is_transmitted and place is not None:
        words = {layout.values(change.value)[place] & STATE_MASK for change in log.changes.changes(0)}
        if not words <= STATES:
            return None
    return layout
