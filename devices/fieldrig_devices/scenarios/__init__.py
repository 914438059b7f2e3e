"""Scenarios: what happens to a rig, and what has to hold meanwhile (`fieldrig scenario`)."""

from typing import TYPE_CHECKING

from fieldrig.lazy import lazy_names

__all__ = ["Outcome", "Scenario", "Violation", "run_scenario"]

if TYPE_CHECKING:
    from fieldrig_devices.scenarios.property import Violation
    from fieldrig_devices.scenarios.report import Outcome
    from fieldrig_devices.scenarios.running import run_scenario
    from fieldrig_devices.scenarios.script import Scenario
else:
    __getattr__, __dir__ = lazy_names(
        __name__,
        {
            "fieldrig_devices.scenarios.property": "Violation",
            "fieldrig_devices.scenarios.report": "Outcome",
            "fieldrig_devices.scenarios.running": "run_scenario",
            "fieldrig_devices.scenarios.script": "Scenario",
        },
    )
