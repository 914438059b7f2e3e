"""The stations of a PAM's ring in a rig file; the rules are those of every ring."""

from typing import Any

import pytest
from pydantic import ValidationError

from fieldrig_bus.ring.pam.virtual import PamRingSettings

MEMBERS = ("pam", "feeder", "lift")


def wrong(**settings: Any) -> list[tuple[Any, ...]]:
    """The keys that name no station of the ring, whose master is the PAM."""
    return [key.path for key in PamRingSettings(**settings).wrong_for(MEMBERS, ["pam"])]


def test_what_names_linked_nodes_is_right() -> None:
    faults = [
        {"what": "break", "after": "pam"},
        {"what": "distort", "after": "master", "count": 1},
        {"what": "halt", "station": "lift"},
        {"what": "off", "station": "feeder"},
    ]
    assert wrong(order=["lift"], bypassed=["feeder"], faults=faults) == []


def test_names_of_others_are_refused() -> None:
    faults = [{"what": "halt", "station": "pam"}, {"what": "distort", "after": "lfit"}]
    assert wrong(order=["lift", "lift"], bypassed=["crane"], faults=faults) == [
        ("order", 1), ("bypassed", 0), ("faults", 0, "station"), ("faults", 1, "after"),
    ]  # fmt: skip


@pytest.mark.parametrize("fault", [{"what": "late", "station": "lift"}, {"what": "distort", "station": "lift"}])
def test_faults_of_a_sercos_ring_are_none_of_a_pam(fault: dict[str, str]) -> None:
    with pytest.raises(ValidationError):
        PamRingSettings.model_validate({"faults": [fault]})
