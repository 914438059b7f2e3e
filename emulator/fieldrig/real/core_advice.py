"""Advice before the start: whether a process for each device can keep the cycle of a ring on the cores of this host.

Each process with an end of the ring is woken in every cycle, which takes the time that the kind of the bus gives
(`Bus.exchange_ns`).  It was measured on a fast host, and a slow one takes two to three times as long.  So a ring that
takes more than a quarter of all cores for this alone is warned of: of the rings measured, all that took less kept more
than 99 % of their cycles on both hosts, and those that took more kept from 95 % down to nothing.
"""

from collections.abc import Iterator
from typing import Final

from fieldrig.clock import MS
from fieldrig.config.entries import DeviceEntry
from fieldrig.config.rig_file import RigConfig
from fieldrig.settings import MASTER

LARGEST_SHARE: Final = 0.25


def advice(config: RigConfig, cores: int) -> Iterator[str]:
    """Yield a warning, and the line that helps, for each ring with too many processes for this number of cores."""
    for device in config.devices.values():
        cycle_ns = device.settings.cycle_ns()
        for bus in _mastered(device) if cycle_ns else ():
            entry = config.buses[bus]
            processes = len(set(entry.members.values()))
            needed = processes * entry.bus.exchange_ns / (cycle_ns or 1)
            if processes > 2 and needed > LARGEST_SHARE * cores:
                yield (
                    f"{bus} has a cycle of {(cycle_ns or 0) / MS:g} ms and {processes} processes: to wake them takes"
                    f" {needed:.1f} cores or more, and this host has {cores}, so cycles may be lost\n"
                    f"this line in the rig file helps: processes: {{{device.process}: {device.name}, {bus}: {bus}}}"
                )


def _mastered(device: DeviceEntry) -> Iterator[str]:
    """Yield the buses of which the device is the master."""
    for claim in device.settings.claims(device.name):
        if claim.what == MASTER:
            yield from device.links.get(claim.link, ())
