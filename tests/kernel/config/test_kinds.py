import sys
from pathlib import Path
from typing import Any

import pytest

from fieldrig.config import kinds
from fieldrig.device import Device
from fieldrig.errors import RigError
from fieldrig.settings import Settings


@pytest.fixture(autouse=True)
def _kinds_can_be_imported(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(Path(__file__).parents[1]))


def device(name: str) -> type[Device]:
    return kinds.find_device(f"config_kinds:{name}")


def links(name: str) -> dict[str, tuple[bool, bool, list[str]]]:
    """Required, many, messages of each link."""
    return {
        link.name: (link.required, link.many, [message.__name__ for message in link.messages])
        for link in kinds.link_parameters(device(name)).values()
    }


def test_an_installed_kind_is_found_by_its_name() -> None:
    assert kinds.find_bus("can.virtual").__name__ == "CanVirtual"
    assert kinds.find_device("can.bridge").__name__ == "CanBridge"


def test_a_kind_that_is_not_there_brings_the_closest() -> None:
    with pytest.raises(RigError, match=r'there is no kind "can.virtal"\n  did you mean can.virtual') as caught:
        kinds.find_bus("can.virtal")
    assert caught.value.what == 'there is no kind "can.virtal"'
    with pytest.raises(RigError, match=r'there are: .*can.bridge.*; or "module:Class" for one of your own'):
        kinds.find_device("q")


@pytest.mark.parametrize(
    ("kind", "what", "remedy"),
    [
        (
            "nowhere:Press",
            "nowhere cannot be imported: No module named 'nowhere'",
            "the module must lie beside the rig file or be installed",
        ),
        ("config_kinds:Nod", "config_kinds has no Nod", "did you mean Node?"),
        ("config_kinds:NOT_A_CLASS", '"config_kinds:NOT_A_CLASS" is not a device', "subclass of fieldrig.device"),
        ("config_kinds:CanLine", '"config_kinds:CanLine" is not a device', "subclass of fieldrig.device.Device"),
        ("config kinds:Node", '"config kinds:Node" is not a class', 'expected "package.module:Class"'),
        (".config_kinds:Node", '".config_kinds:Node" is not a class', 'expected "package.module:Class"'),
        (":", '":" is not a class', 'expected "package.module:Class"'),
    ],
)
def test_a_class_that_is_not_there_is_explained(kind: str, what: str, remedy: str) -> None:
    with pytest.raises(RigError) as caught:
        kinds.find_device(kind)
    assert caught.value.what == what
    assert remedy in caught.value.remedy


def test_a_class_that_leaves_out_methods_of_a_bus_is_refused() -> None:
    with pytest.raises(RigError, match="Unfinished lacks close, decode, encode, open, show"):
        kinds.find_bus("config_kinds:Unfinished")


def test_a_module_that_is_not_python_is_explained(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "slip_of_the_pen.py").write_text("class Press(Device:\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    with pytest.raises(RigError, match=r"slip_of_the_pen cannot be imported: .*line 1"):
        kinds.find_device("slip_of_the_pen:Press")


def test_only_what_is_named_is_imported() -> None:
    sys.modules.pop("fieldrig_devices.bridges.can", None)
    kinds.find_bus("wires.virtual")
    assert "fieldrig_devices.bridges.can" not in sys.modules


def test_settings_are_named_by_their_annotation() -> None:
    assert kinds.settings_model(device("Node")).__name__ == "NodeSettings"
    assert kinds.settings_model(device("Reader")) is Settings
    assert kinds.settings_model(device("Idle")) is Settings
    assert kinds.settings_model(kinds.find_bus("config_kinds:CanLine")).__name__ == "LineSettings"


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("Node", {"can": (True, False, ["Frame"]), "words": (False, True, ["Word", "Gap"])}),
        ("Reader", {"words": (True, False, ["Word"]), "frames": (False, False, ["Frame"])}),
        ("Listener", {"any_bus": (True, False, []), "several": (True, True, ["Frame"])}),
        ("Idle", {}),
    ],
)
def test_links_are_the_other_parameters(name: str, expected: dict[str, Any]) -> None:
    assert links(name) == expected


def test_a_parameter_that_is_nothing_known_is_explained() -> None:
    with pytest.raises(
        RigError, match=r"the parameter colour of config_kinds.Odd is not a link\n.*clock, name, random"
    ):
        links("Odd")


def test_an_annotation_that_leads_nowhere_is_explained() -> None:
    with pytest.raises(RigError, match=r"config_kinds.Dangling cannot be read: name 'Clokc' is not defined"):
        links("Dangling")


def test_every_installed_kind_is_listed_with_a_line_about_it() -> None:
    listed = {*kinds.list_buses(), *kinds.list_devices()}
    assert {"can.virtual", "wires.hub", "can.bridge"} <= {kind.name for kind in listed}
    assert all(kind.about for kind in listed)


def test_buses_are_found_by_time_and_family() -> None:
    assert kinds.bus_kinds_for("virtual", "wires") == ["wires.hub", "wires.virtual"]
