"""A conformance suite for any CANopen node, emulated or foreign, on any of our buses (`fieldrig conform`)."""

from typing import TYPE_CHECKING

from fieldrig.lazy import lazy_names

__all__ = [
    "Description",
    "Verdict",
    "choose",
    "conform_virtual",
]

if TYPE_CHECKING:
    from fieldrig_devices.conformance.description import Description
    from fieldrig_devices.conformance.run import choose, conform_virtual
    from fieldrig_devices.conformance.suite import Verdict
else:
    __getattr__, __dir__ = lazy_names(
        __name__,
        {
            "fieldrig_devices.conformance.description": "Description",
            "fieldrig_devices.conformance.run": "choose conform_virtual",
            "fieldrig_devices.conformance.suite": "Verdict",
        },
    )
