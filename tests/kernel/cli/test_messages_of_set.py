"""Numbers that `fieldrig set` refuses before it asks a rig."""

import pytest
from typer.testing import CliRunner

from fieldrig.cli.app import app


@pytest.mark.parametrize("number", ["nan", "-inf", "1e400", str(1 << 64), str(-(1 << 63) - 1), "0x" + "F" * 17])
def test_a_number_that_no_point_can_have_is_named_with_its_point(number: str) -> None:
    done = CliRunner().invoke(app, ["set", f"tank/level={number}"])
    assert done.exit_code == 2
    assert "tank/level cannot be" in done.stderr
    assert "JSON" not in done.stderr
