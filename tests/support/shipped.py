"""The rigs of `configs`, in virtual time."""

from pathlib import Path
from typing import Final

from fieldrig.config.rig_file import RigConfig, load

CONFIGS: Final = Path(__file__).parents[2] / "configs"
RIGS: Final = sorted(
    path.name for path in CONFIGS.glob("*.yaml") if path.name not in {"lab-vcan.yaml", "own-device.yaml"}
)
"""The files, without a variant of one of them, and a rig whose buses have no model."""


def in_virtual_time(file: str, *overrides: str) -> RigConfig:
    """Load a rig of this name."""
    return load(CONFIGS / file, (*overrides, "time=virtual"))
