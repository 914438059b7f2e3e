"""The command `fieldrig editor programs`."""

from typing import Any

from fieldrig.cli.common import Endpoint, echo_json
from fieldrig.outside.addresses import DEFAULT_ENDPOINT


def programs(endpoint: Endpoint = DEFAULT_ENDPOINT) -> None:
    """List the devices of the running rig that have a program to debug, as JSON.

    Each has its name as `device`, its `language`, and the names of its source `files`.
    """
    from fieldrig.control.messages import Client

    with Client(endpoint) as client:
        echo_json(_programs(client))


def _programs(client: Any) -> list[dict[str, Any]]:
    from fieldrig.cli.names import Parts
    from fieldrig.errors import ControlError

    parts, found = Parts(client), list[dict[str, Any]]()
    for device in parts.devices:
        try:
            state = parts.ask_device(device, "debug", {"command": "state"})
            files = parts.ask_device(device, "debug", {"command": "files"})["files"]
        except ControlError:  # a device without a program refuses
            continue
        found.append({"device": device, "language": state["language"], "files": files})
    return found
