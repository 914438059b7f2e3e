"""The cases, one file per family.  Importing this package makes all of them known.

Names and numbers are those of the public log of CANopenNode under CiA's test tool; requirements are written from the
standards, and where a name leaves open what is tried, so is the reading.
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
