"""The cases, one file per family.  Importing this package registers all of them.

Names and numbers are those of the public log of CANopenNode under CiA's test tool.  The requirements are taken from the
standards, and so is the interpretation where a name is ambiguous.
"""

from fieldrig_devices.conformance.cases import (
    dictionary,
    eds_file,
    emergency,
    guarding,
    heartbeat,
    heartbeat_or_guarding,
    pdo_mapping,
    pdo_modes,
    pdo_parameters,
    sdo_access,
    sdo_block,
    sdo_channels,
    sdo_segmented,
    states,
    storing,
    synchronization,
    transitions,
)

__all__ = [
    "dictionary",
    "eds_file",
    "emergency",
    "guarding",
    "heartbeat",
    "heartbeat_or_guarding",
    "pdo_mapping",
    "pdo_modes",
    "pdo_parameters",
    "sdo_access",
    "sdo_block",
    "sdo_channels",
    "sdo_segmented",
    "states",
    "storing",
    "synchronization",
    "transitions",
]
