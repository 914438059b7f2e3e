"""Passages of the manual about programs that can be read in two ways.  The defaults are the likelier readings."""

from dataclasses import dataclass
from typing import Literal

Events = Literal["remembered", "counted", "sampled"]
"""Events between two cycles of their group count once, each of them counts, or none does."""

StartEvents = Literal["changes", "all", "none"]
"""Events before the POWERON parts have finished: those that occur then count, all that are true then, or none."""


@dataclass(frozen=True, slots=True)
class Readings:
    events: Events = "remembered"
    events_at_start: StartEvents = "changes"
    common_variables_cause_events: bool = False
    """False: ON_EVENT and EXCEPTION take no notice of a COMMON variable until something else in them changes.

    COMMON variables "do not produce event" (manual line 2644).
    """
    exceptions_wake: bool = True
    """False: an exception of a suspended sequence waits for the end of the wait."""
    math_error_is_fatal: bool = True
    """False: an error of a function or of ^ has a finite result instead of stopping the application by 02..FFF3."""
    checks_workspaces: bool = True
    """The "stack control" without which a workspace that is too small has no consequences."""
