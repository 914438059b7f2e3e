"""Why a port cannot be opened, without numbers."""

from collections.abc import Callable
from pathlib import Path
from typing import Any, cast

import pytest
import serial

from fieldrig_bus.serial.port_errors import reason


def of_opening(port: str) -> str:
    open_port = cast(Callable[..., Any], serial.serial_for_url)
    with pytest.raises((serial.SerialException, OSError, ValueError)) as refused:
        open_port(port)
    return reason(refused.value)


def test_a_port_that_is_not_there() -> None:
    assert of_opening("/dev/there-is-none") == "No such file or directory"


def test_a_file_is_no_port(tmp_path: Path) -> None:
    file = tmp_path / "file"
    file.write_text("keep me")
    assert of_opening(str(file)) == "it is no serial port (Inappropriate ioctl for device)"
    assert file.read_text() == "keep me"


def test_what_has_no_number_keeps_its_text() -> None:
    assert of_opening("nonsense://x") == "invalid URL, protocol 'nonsense' not known"
