"""Passages of the manual about programs that can be read in two ways.  The defaults are the likelier readings."""

from typing import Literal

from pydantic import Field

from fieldrig.settings import Settings

Events = Literal["remembered", "counted", "sampled"]
"""Events between two cycles of their group count once, each of them counts, or none does."""

StartEvents = Literal["changes", "all", "none"]
"""Events before the POWERON parts have finished: those that occur then count, all that are true then, or none."""


class Readings(Settings):
    events: Events = Field(
        default="remembered",
        description="what ON_EVENT sees of events between two of its cycles: one (remembered), each of them (counted), "
        "or none (sampled)",
    )
    events_at_start: StartEvents = Field(
        default="changes",
        description="events of ON_EVENT before the POWERON parts have finished: those that occur then count (changes), "
        "all that are true then (all), or none (none)",
    )
    # COMMON variables "do not produce event" (manual line 2644).
    common_variables_cause_events: bool = Field(
        default=False,
        description="whether ON_EVENT and EXCEPTION see a change of a COMMON variable",
    )
    exceptions_wake: bool = Field(
        default=True,
        description="whether an exception ends the wait of a suspended sequence, or comes when the wait is over",
    )
    math_error_is_fatal: bool = Field(
        default=True,
        description="true: an error of a function or of ^ is 02..FFF3; false: its result is 0.0 outside the domain, "
        "and the largest real beyond the range",
    )
    checks_workspaces: bool = Field(
        default=True,
        description="whether stack control is enabled, so that a workspace that is too small stops the PAM",
    )
