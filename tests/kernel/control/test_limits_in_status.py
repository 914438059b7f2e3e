"""Limits that clients of a device have reached are figures of `fieldrig status`, beside those of tools and buses."""

from typing import Any

import pytest

from fieldrig.cli.status import _show
from fieldrig.control.rig_status import joined


def test_status_says_which_limits_clients_have_reached(capsys: pytest.CaptureFixture[str]) -> None:
    rig: dict[str, Any] = {"rig": "lab", "state": "ready", "uptime_s": 1.0, "time": "real", "file": "lab.yaml"}
    rig |= {"processes": {}, "buses": {}, "devices": {"max4": {}, "belt": {}}, "run": "run/lab"}
    process = {"state": "ready", "pid": 1, "uptime_s": 1.0, "buses": {}, "limits": {}, "memory_mb": 1.0}
    process["client_limits"] = {"max4": {"connections over the limit": 3.0}, "belt": {}}
    status = joined(rig, {"plc": process}, {})
    assert status["client_limits"] == {"max4": {"connections over the limit": 3.0}}
    _show(status)
    assert "limits that clients have reached at max4: connections over the limit 3\n" in capsys.readouterr().out
