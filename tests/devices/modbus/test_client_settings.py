"""The registers of a client's messages end at 65535 (Modbus application protocol V1.1b3, 4.4)."""

from typing import Any

import pytest
from pydantic import ValidationError

from fieldrig_devices.modbus.client_settings import ReadSettings, WriteSettings


def message(address: int, *types: str) -> dict[str, Any]:
    return {"address": address, "values": [{"name": f"v{place}", "type": kind} for place, kind in enumerate(types)]}


@pytest.mark.parametrize("settings", [ReadSettings, WriteSettings])
@pytest.mark.parametrize(("address", "types"), [(0xFFFF, ["u16"]), (0xFFFE, ["u32"]), (0xFFFD, ["u16", "u32"])])
def test_the_last_register_may_be_65535_and_no_further(settings: Any, address: int, types: list[str]) -> None:
    assert settings.model_validate(message(address, *types)).address == address
    with pytest.raises(ValidationError, match=r"end at 65535 or below|less than or equal to 65535"):
        settings.model_validate(message(address + 1, *types))
