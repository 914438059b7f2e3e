import calendar
import re
import sys
from collections.abc import Callable
from pathlib import Path
from textwrap import dedent
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig.config.rig_file import RigConfig, from_dict, load, start_order
from fieldrig.errors import ConfigError, Mistake

HERE = Path(__file__).parents[1]
NODE = "config_kinds:Node"

Loaded = Callable[..., RigConfig]
Refused = Callable[..., list[str]]


@pytest.fixture(autouse=True)
def _kinds_can_be_imported(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(HERE))


@pytest.fixture
def loaded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Loaded:
    """Loads a rig file of this text."""
    monkeypatch.chdir(tmp_path)

    def load_text(text: str, *overrides: str, only: set[str] | None = None) -> RigConfig:
        Path("rig.yaml").write_text(dedent(text), encoding="utf-8")
        return load(Path("rig.yaml"), overrides, only)

    return load_text


@pytest.fixture
def refused(loaded: Loaded) -> Refused:
    """The mistakes of a rig file of this text, as they are printed."""

    def mistakes(text: str, *overrides: str) -> list[str]:
        with pytest.raises(ConfigError) as caught:
            loaded(text, *overrides)
        return [str(mistake) for mistake in caught.value.mistakes]

    return mistakes


RIGHT = """\
    time: virtual
    seed: 7
    speed: max
    processes: each
    start_timeout_s: 5
    buses:
      can0: {kind: "config_kinds:CanLine", bitrate: 250000, process: rack}
      words: {kind: "config_kinds:WordLine"}
    devices:
      io:
        kind: "config_kinds:Node"
        node_id: 20
        links: {can: can0, words: [words]}
        after: reader
        on_exit: stop
        process: rack
      reader: {kind: "config_kinds:Reader", links: {words: words}}
"""


def test_a_right_file_becomes_a_rig(loaded: Loaded) -> None:
    config = loaded(RIGHT)
    assert (config.name, config.time, config.seed, config.speed) == ("rig", "virtual", 7, None)
    assert (config.processes, config.start_timeout_s, config.run) == ("each", 5, Path("run/rig"))
    can0, words = config.buses.values()
    assert (can0.name, can0.bus.settings.bitrate, can0.process) == ("can0", 250_000, "rack")
    assert (words.kind, words.process) == ("config_kinds:WordLine", None)
    io, reader = config.devices.values()
    assert io.links == {"can": ("can0",), "words": ("words",)}
    assert (set(io.many), io.after, io.on_exit, io.process) == ({"words"}, ("reader",), "stop", "rack")
    assert (reader.links, reader.on_exit, reader.process) == ({"words": ("words",)}, "restart", "reader")


def test_what_is_left_out_has_its_default(loaded: Loaded) -> None:
    config = loaded("time: real")
    assert (config.seed, config.speed, config.processes, config.start_timeout_s) == (0, 1.0, "one", 10)
    assert config.control == "tcp/127.0.0.1:7447"


def test_empty_sections_are_no_mistake(loaded: Loaded) -> None:
    config = loaded("time: real\nbuses:\ndevices:\n")
    assert (config.buses, config.devices) == ({}, {})


FIVE_MISTAKES = """\
# A rig with five mistakes in it.
time: virtual
buses:
  can0: {kind: "config_kinds:CanLine", bitrat: 250000}
  can1: {kind: can.udp}
devices:
  io:
    kind: "config_kinds:Node"
    node_id: 200
    links: {can: can2}
  press: {kind: canopen.nod, links: {can: can0}}
"""

FIVE_MESSAGES = """\
five.yaml:4: buses.can0.bitrat: there is no such key
    did you mean bitrate?
five.yaml:5: buses.can1.kind: can.udp doesn't run with time: virtual
    kinds that do: can.hub, can.virtual
five.yaml:9: devices.io.node_id: 200 doesn't fit
    expected a whole number from 1 to 127 (number on the bus)
five.yaml:10: devices.io.links.can: there is no bus "can2"
    did you mean can1?
five.yaml:11: devices.press.kind: there is no kind "canopen.nod"
    did you mean canopen.node?"""


def test_five_mistakes_give_five_messages(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("five.yaml").write_text(FIVE_MISTAKES, encoding="utf-8")
    with pytest.raises(ConfigError) as caught:
        load(Path("five.yaml"))
    assert str(caught.value) == FIVE_MESSAGES


def test_a_mistake_hides_no_other(refused: Refused) -> None:
    """Mistakes in common keys and in those of a kind are reported together."""
    text = LINES + f'      io: {{kind: "{NODE}", node_id: 200, on_exit: sometimes, after: nothing, process: RACK}}\n'
    keys = ("process", "on_exit", "node_id")
    assert [[f"devices.io.{key}: " in item for item in refused(text)].count(True) for key in keys] == [1, 1, 1]
    assert len(refused(text)) == 5  # there is no device `nothing`, and no link


def test_a_mistake_has_parts_for_programs(tmp_path: Path) -> None:
    file = tmp_path / "rig.yaml"
    file.write_text("time: real\nsed: 1\n")
    with pytest.raises(ConfigError) as caught:
        load(file)
    assert caught.value.mistakes == [Mistake(str(file), 2, "sed", "there is no such key", "did you mean seed?")]


LINES = """\
    time: virtual
    buses:
      can0: {kind: "config_kinds:CanLine"}
      words: {kind: "config_kinds:WordLine"}
    devices:
"""


ONE_TO_127 = "expected a whole number from 1 to 127 (number on the bus)"


@pytest.mark.parametrize(
    ("line", "what", "remedy"),
    [
        # links
        ("links: {}", ".links.can: this link is missing", "buses that fit: can0"),
        ("node_id: 5", ".links.can: this link is missing", "buses that fit: can0"),
        ("links: {cn: words, can: can0}", ".links.cn: the device has no such link", "did you mean can?"),
        ("links: {can: [can0]}", ".links.can: this link takes one bus, not a list", "expected can: BUS"),
        (
            "links: {can: words}",
            ".links.can: words is a config_kinds:WordLine, which does not carry what the device sends there",
            "buses that fit: can0",
        ),
        (
            "links: {can: can0, words: [words, words]}",
            ".links: words is linked twice",
            "a device has one end of a bus",
        ),
        ("links: can0", '.links: "can0" doesn\'t fit', "expected a mapping of keys to values"),
        ("links: {can: 0}", ".links.can: 0 doesn't fit", "expected a text or a list"),
        # the other keys of every device
        (
            "links: {can: can0}, on_exit: reboot",
            '.on_exit: "reboot" doesn\'t fit',
            "expected restart or stop or ignore (what happens when its process dies)",
        ),
        (
            "links: {can: can0}, process: A",
            '.process: "A" doesn\'t fit',
            "expected a text like rack-1 or null (process that it runs in; without it one of its own)",
        ),
        ("links: {can: can0}, after: oi", '.after: there is no other device "oi"', "there are none"),
        ("links: {can: can0}, after: io", '.after: there is no other device "io"', "there are none"),
        ("links: {can: can0}, onexit: stop", ".onexit: there is no such key", "did you mean on_exit?"),
        # the settings of this kind
        ('links: {can: can0}, node_id: "7"', '.node_id: "7" doesn\'t fit', ONE_TO_127),
        ("links: {can: can0}, node_id: true", ".node_id: true doesn't fit", ONE_TO_127),
        ("links: {can: can0}, node_id: 7.5", ".node_id: 7.5 doesn't fit", ONE_TO_127),
        ("links: {can: can0}, mode: fst", '.mode: "fst" doesn\'t fit', "expected fast or slow"),
        ("links: {can: can0}, pair: [1, x]", '.pair[1]: "x" doesn\'t fit', "expected a whole number"),
        (
            "links: {can: can0}, signals: {a: {wire: w, scale: 0}}",
            ".signals.a.scale: 0 doesn't fit",
            "expected a number above 0",
        ),
        (
            "links: {can: can0}, signals: {a: {scale: 2}}",
            ".signals.a.wire: this key is missing",
            "expected a text",
        ),
        (
            "links: {can: can0}, signals: {a: {wire: w, scal: 2}}",
            ".signals.a.scal: there is no such key",
            "did you mean scale?",
        ),
        (
            "links: {can: can0}, signals: {a: 5}",
            ".signals.a: 5 doesn't fit",
            "expected a text or a mapping of keys to values",
        ),
    ],
)
def test_a_mistake_in_a_device_is_explained(refused: Refused, line: str, what: str, remedy: str) -> None:
    number = "" if "node_id" in line else "node_id: 5, "
    text = LINES + f'      io: {{kind: "{NODE}", {number}{line}}}\n'
    assert refused(text) == [f"rig.yaml:6: devices.io{what}\n    {remedy}"]


REAL_OR_VIRTUAL = "expected real or virtual (real: the system's clock; virtual: a clock that the rig moves)"
A_NAME = "expected lower-case letters, digits, _ and -, starting with a letter"


@pytest.mark.parametrize(
    ("text", "what", "remedy"),
    [
        ("", ": the file is empty", "it needs `time: real` or `time: virtual`, and devices"),
        ("- a\n", ':1: ["a"] doesn\'t fit', "expected a mapping of names to values"),
        ("seed: 1\n", ":1: time: this key is missing", REAL_OR_VIRTUAL),
        ("time: reel\n", ':1: time: "reel" doesn\'t fit', REAL_OR_VIRTUAL),
        (
            "time: real\nseed: 1.5\n",
            ":2: seed: 1.5 doesn't fit",
            "expected a whole number (all chance in the rig follows from it)",
        ),
        (
            "time: real\nspeed: 2\n",
            ":2: speed: it has no meaning with time: real",
            "take it away, or set time: virtual",
        ),
        (
            "time: virtual\nspeed: 0\n",
            ":2: speed: 0 doesn't fit",
            "expected a number above 0 or max or null (virtual seconds per second; only with time: virtual)",
        ),
        (
            "time: real\ncontrol: 127.0.0.1:7447\n",
            ':2: control: "127.0.0.1:7447" doesn\'t fit',
            "expected a text like tcp/127.0.0.1:7447 (Zenoh endpoint of the control service)",
        ),
        (
            "time: real\nbuses: [can0]\n",
            ':2: buses: ["can0"] doesn\'t fit',
            "expected a mapping of names to values",
        ),
        (
            "time: real\nbuses:\n  can0:\n",
            ":3: buses.can0: null doesn't fit",
            "expected a mapping with a `kind`",
        ),
        (
            "time: real\nbuses:\n  can0: {}\n",
            ":3: buses.can0.kind: this key is missing",
            'expected a text (what it is: a kind that is installed, or "module:Class" of your own)',
        ),
        ("time: real\nbuses:\n  Can0: {kind: can.hub}\n", ':3: buses.Can0: "Can0" is not a name', A_NAME),
        ("time: real\nbuses:\n  0: {kind: can.hub}\n", ":3: buses[0]: 0 is not a name", A_NAME),
        (
            "time: real\nprocesses: {A: []}\n",
            ':2: processes.A: the key "A" doesn\'t fit',
            "expected a text like rack-1",
        ),
        ("time: real\nprocesses: {a: 3}\n", ":2: processes.a: 3 doesn't fit", "expected a text or a list"),
        ("time: real\nprocesses: {a: [3]}\n", ":2: processes.a[0]: 3 doesn't fit", "expected a text"),
        ("time: real\ntime: virtual\n", ":2: time: the same key is in line 1", "keep one of the two"),
        (
            "time: real\n  seed: 1\n",
            ":2: this is not YAML: mapping values are not allowed here",
            "look at the indentation, colons and quotes here",
        ),
    ],
)
def test_a_mistake_in_the_file_is_explained(refused: Refused, text: str, what: str, remedy: str) -> None:
    assert refused(text) == [f"rig.yaml{what}\n    {remedy}"]


def test_a_file_that_is_not_there_or_not_text_is_a_mistake(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"no\.yaml: it cannot be read: No such file or directory"):
        load(tmp_path / "no.yaml")
    (tmp_path / "latin.yaml").write_bytes(b"time: r\xe9al")
    with pytest.raises(ConfigError, match=r"latin\.yaml: it cannot be read: it is not UTF-8 text"):
        load(tmp_path / "latin.yaml")


def test_a_bus_that_refuses_its_settings_is_named(refused: Refused) -> None:
    text = LINES.replace('CanLine"', 'CanLine", bitrate: 666666')
    assert refused(text) == ["rig.yaml:3: buses.can0: no crystal gives 666666 bit/s\n    take 500000"]


def test_links_to_a_bus_that_is_wrong_in_itself_are_no_further_mistake(refused: Refused) -> None:
    text = LINES.replace("CanLine", "CanLin") + f'      io: {{kind: "{NODE}", node_id: 5, links: {{can: can0}}}}\n'
    assert len(refused(text)) == 1


def test_a_bus_and_a_device_cannot_share_a_name(refused: Refused) -> None:
    text = LINES + f'      can0: {{kind: "{NODE}", node_id: 5, links: {{can: can0}}}}\n'
    assert refused(text) == ["rig.yaml:6: devices.can0: a bus is called can0 too\n    give each a name of its own"]


def test_two_nodes_of_a_bus_cannot_share_a_number(refused: Refused) -> None:
    node = f'{{kind: "{NODE}", node_id: 5, links: {{can: can0}}}}'
    (mistake,) = refused(LINES + f"      one: {node}\n      two: {node}\n")
    assert mistake.startswith("rig.yaml:7: devices.two.node_id: node-ID 5 on can0 is taken by devices.one.node_id")


def test_a_node_id_used_twice_is_reported_even_if_one_of_the_entries_is_wrong(refused: Refused) -> None:
    node = f'kind: "{NODE}", node_id: 5, links: {{can: can0}}'
    found = refused(LINES + f"      one: {{{node}, speed: 1}}\n      two: {{{node}}}\n      three: 3\n")
    assert ["devices.one.speed: " in found[0], "devices.two.node_id: " in found[1], len(found)] == [True, True, 3]


def test_two_nodes_on_two_buses_may_share_a_number(loaded: Loaded) -> None:
    node = f'kind: "{NODE}", node_id: 5, links'
    text = LINES.replace("words:", 'can1: {kind: "config_kinds:CanLine"}\n      words:')
    config = loaded(text + f"      one: {{{node}: {{can: can0}}}}\n      two: {{{node}: {{can: can1}}}}\n")
    assert len(config.devices) == 2


@pytest.mark.parametrize("other", ["127.0.0.1:5000", "localhost:5000", "0.0.0.0:5000", "tcp://127.0.0.1:5000"])
def test_two_buses_cannot_listen_on_one_port(refused: Refused, other: str) -> None:
    text = LINES.replace('CanLine"', 'CanLine", listen: "127.0.0.1:5000"')
    (mistake,) = refused(text.replace('WordLine"', f'WordLine", also: ["{other}"]'))
    assert mistake.startswith("rig.yaml:4: buses.words.also[0]: port 5000 is taken by buses.can0.listen")


def test_a_bus_cannot_listen_where_the_control_service_does(refused: Refused) -> None:
    (mistake,) = refused(LINES.replace('CanLine"', 'CanLine", listen: "127.0.0.1:7447"'))
    assert "port 7447 is taken by control" in mistake


LONG = 5_000 * "x"


def test_a_file_name_that_no_system_takes_is_refused_wherever_it_stands(refused: Refused) -> None:
    text = LINES + f'      io: {{kind: "{NODE}", node_id: 5, links: {{can: can0}}, file: {LONG}}}\n'
    (mistake,) = refused(text)
    assert mistake.startswith("rig.yaml:6: devices.io.file: ")
    assert "File name too long" in mistake
    assert len(mistake) < 1000
    assert "File name too long" in refused(f"extends: {LONG}\n")[0]
    (mistake,) = refused(LINES + f'      io: {{kind: "{LONG}:Node"}}\n')
    assert mistake.startswith("rig.yaml:6: devices.io.kind: ")
    with pytest.raises(ConfigError, match="File name too long"):
        load(Path(LONG))


@pytest.mark.skipif(sys.platform != "linux", reason="a file that gives an I/O error")
def test_a_file_that_gives_an_io_error_is_refused_with_its_key(refused: Refused) -> None:
    text = LINES + f'      io: {{kind: "{NODE}", node_id: 5, links: {{can: can0}}, file: /proc/self/mem}}\n'
    (mistake,) = refused(text)
    assert mistake.startswith("rig.yaml:6: devices.io.file: /proc/self/mem cannot be read: Input/output error")
    assert "Input/output error" in refused("extends: /proc/self/mem\n")[0]


@pytest.mark.parametrize("other", ["127.0.0.2:5000", "127.0.0.1:5001", "udp://127.0.0.1:5000"])
def test_other_hosts_ports_and_protocols_do_not_meet(loaded: Loaded, other: str) -> None:
    text = LINES.replace('CanLine"', 'CanLine", listen: "127.0.0.1:5000"')
    assert loaded(text.replace('WordLine"', f'WordLine", listen: "{other}"'))


def test_port_0_is_refused_where_outsiders_must_know_the_port(refused: Refused) -> None:
    found = refused("control: tcp/127.0.0.1:0\n" + dedent(LINES.replace('CanLine"', 'CanLine", listen: "127.0.0.1:0"')))
    assert [item.partition(": ")[2] for item in found] == [
        f"{key}: port 0 is a random port that no outside client knows\n    expected a port from 1 to 65535"
        for key in ("control", "buses.can0.listen")
    ]


def test_a_port_that_a_bus_connects_to_is_not_taken(loaded: Loaded) -> None:
    text = LINES.replace('CanLine"', 'CanLine", listen: "127.0.0.1:5000"')
    assert loaded(text.replace('WordLine"', 'WordLine", connect: "127.0.0.1:5000"'))


def test_two_buses_cannot_have_one_pty(refused: Refused) -> None:
    text = "time: real\nbuses:\n  com1: {kind: serial.pty, path: com}\n  com2: {kind: serial.pty, path: com}\n"
    assert refused(text) == [
        "rig.yaml:4: buses.com2.path: com is taken by buses.com1.path\n    give each a path of its own"
    ]


READER = 'kind: "config_kinds:Reader", links: {words: words}'


def test_what_a_bus_says_of_its_devices_must_be_true(refused: Refused) -> None:
    text = (
        LINES.replace('WordLine"', 'WordLine", first: dave') + f"      alice: {{{READER}}}\n      bob: {{{READER}}}\n"
    )
    assert refused(text + '      dave: {kind: "config_kinds:Idle"}\n') == [
        "rig.yaml:4: buses.words.first: dave is not here\n    here are: alice, bob"
    ]


def test_a_bus_hears_also_of_devices_that_are_wrong_in_themselves_or_elsewhere(
    loaded: Loaded, refused: Refused
) -> None:
    text = LINES.replace('WordLine"', 'WordLine", first: alice') + f"      bob: {{{READER}}}\n"
    assert loaded(text + f"      alice: {{{READER}}}\n", only={"bob"}).buses.keys() == {"words"}
    (mistake,) = refused(text + f"      alice: {{{READER}, speed: 1}}\n")
    assert "devices.alice.speed: " in mistake


def test_devices_start_after_those_they_name_else_in_the_order_of_the_file(loaded: Loaded) -> None:
    text = LINES + f"      d: {{{READER}, after: [b, a]}}\n      c: {{{READER}, after: d}}\n"
    text += f"      b: {{{READER}}}\n      a: {{{READER}}}\n"
    assert start_order(loaded(text)) == ["b", "a", "d", "c"]


def test_devices_that_wait_for_each_other_are_a_mistake(refused: Refused) -> None:
    text = LINES + f"      a: {{{READER}, after: b}}\n      b: {{{READER}, after: a}}\n      c: {{{READER}}}\n"
    assert refused(text) == ["rig.yaml:6: devices.a.after: these wait for each other: a, b\n    take one `after` away"]


def test_files_are_found_from_the_folder_of_the_rig_file(loaded: Loaded, tmp_path: Path) -> None:
    (tmp_path / "io.txt").write_text("x")
    text = LINES + f'      io: {{kind: "{NODE}", node_id: 5, links: {{can: can0}}, file: io.txt}}\n'
    assert loaded(text).devices["io"].settings.model_dump()["file"] == tmp_path / "io.txt"


def test_a_file_that_is_missing_is_a_mistake(refused: Refused, tmp_path: Path) -> None:
    text = LINES + f'      io: {{kind: "{NODE}", node_id: 5, links: {{can: can0}}, file: io.txt}}\n'
    (mistake,) = refused(text)
    assert mistake.startswith(
        f"rig.yaml:6: devices.io.file: no such file: {tmp_path}/io.txt\n    expected the path of a file"
    )


def test_a_file_that_is_missing_is_answered_with_the_nearest_one(refused: Refused, tmp_path: Path) -> None:
    (tmp_path / "io32.eds").write_text("x")
    (tmp_path / "base.yaml").write_text("time: real\n")
    text = LINES + f'      io: {{kind: "{NODE}", node_id: 5, links: {{can: can0}}, file: oi32.eds}}\n'
    what = f"rig.yaml:6: devices.io.file: no such file: {tmp_path}/oi32.eds"
    assert refused(text) == [f"{what}\n    did you mean {tmp_path}/io32.eds?"]
    (mistake,) = refused("time: real\nextends: bose.yaml\n")
    assert "did you mean" in mistake
    assert mistake.endswith("base.yaml?")


def test_settings_may_be_tuples_paths_and_maps_from_numbers(loaded: Loaded) -> None:
    text = LINES + f'      io: {{kind: "{NODE}", node_id: 0x10, links: {{can: can0}}, '
    settings = loaded(text + "pair: [1, 2], folder: a/b, units: {1: one}}\n").devices["io"].settings.model_dump()
    assert settings["node_id"] == 16
    assert (settings["pair"], settings["folder"], settings["units"]) == ((1, 2), Path("a/b"), {1: "one"})


def test_a_class_beside_the_rig_file_is_found(loaded: Loaded, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "path", sys.path[:])
    (tmp_path / "mixer_of_mine.py").write_text("from fieldrig.device import Device\nclass Mixer(Device): ...\n")
    config = loaded('time: real\ndevices:\n  mixer: {kind: "mixer_of_mine:Mixer"}\n')
    assert config.devices["mixer"].cls.__name__ == "Mixer"


def test_a_class_beside_the_rig_file_is_not_taken_from_another_module_of_that_name(
    refused: Refused, tmp_path: Path
) -> None:
    (tmp_path / "calendar.py").write_text("from fieldrig.device import Device\nclass Mixer(Device): ...\n")
    (mistake,) = refused('time: real\ndevices:\n  mixer: {kind: "calendar:Mixer"}\n')
    assert f"another module calendar is in use already: {calendar.__file__}" in mistake


# -- extends and overrides


@pytest.fixture
def base(tmp_path: Path) -> Path:
    folder = tmp_path / "base"
    folder.mkdir()
    (folder / "io.txt").write_text("x")
    (folder / "base.yaml").write_text(
        dedent(LINES) + f'  io: {{kind: "{NODE}", node_id: 5, links: {{can: can0}}, file: io.txt}}\n'
    )
    return folder / "base.yaml"


def test_a_file_is_laid_over_the_one_it_extends(loaded: Loaded, base: Path) -> None:
    config = loaded(
        f"""\
        extends: {base}
        seed: 9
        devices:
          io: {{node_id: 6}}
          reader: {{{READER}}}
        """
    )
    assert (config.time, config.seed, list(config.devices)) == ("virtual", 9, ["io", "reader"])
    io = config.devices["io"].settings.model_dump()
    assert (io["node_id"], io["file"]) == (6, base.parent / "io.txt")


def test_an_entry_that_names_its_kind_starts_anew_and_null_takes_one_away(loaded: Loaded, base: Path) -> None:
    config = loaded(
        f"""\
        extends: {base}
        buses: {{words: null}}
        devices: {{io: {{kind: "{NODE}", node_id: 7, links: {{can: can0}}}}}}
        """
    )
    assert list(config.buses) == ["can0"]
    assert config.devices["io"].settings.model_dump()["file"] is None


def test_a_mistake_names_the_file_that_it_stands_in(refused: Refused, base: Path) -> None:
    base.write_text(base.read_text(encoding="utf-8").replace("node_id: 5", "node_id: 500"), encoding="utf-8")
    first, second = refused(f"extends: {base}\nseed: x\n")
    assert first.startswith(f"{base}:6: devices.io.node_id: 500 doesn't fit")
    assert second.startswith("rig.yaml:2: seed:")


@pytest.mark.parametrize(
    ("value", "what"),
    [
        ("5", "it takes a file, or a list of files"),
        ("[]", "it takes a file, or a list of files"),
        ("[other.yaml, 5]", "it takes a file, or a list of files"),
        ("no.yaml", "no such file: no.yaml"),
        ("rig.yaml", "rig.yaml extends this file in turn"),
        ("[rig.yaml]", "rig.yaml extends this file in turn"),
    ],
)
def test_a_file_that_cannot_be_extended_is_a_mistake(refused: Refused, value: str, what: str) -> None:
    (mistake,) = refused(f"time: real\nextends: {value}\n")
    assert mistake.startswith(f"rig.yaml:2: extends: {what}\n")


ONE = f"""\
time: virtual
seed: 1
buses:
  can0: {{kind: "config_kinds:CanLine", bitrate: 250000}}
  words: {{kind: "config_kinds:WordLine"}}
devices:
  io: {{kind: "{NODE}", node_id: 5, links: {{can: can0}}, signals: {{x: one, y: both}}}}
"""
TWO = f"""\
time: virtual
seed: 2
buses:
  can0: {{kind: "config_kinds:CanLine", bitrate: 500000}}
devices:
  io:
    kind: "{NODE}"
    node_id: 6
    links: {{can: can0}}
    signals: {{x: two, y: both, z: two}}
  lamp: {{kind: "{NODE}", node_id: 7, links: {{can: can0}}}}
"""


@pytest.fixture
def two_files(tmp_path: Path) -> None:
    """Files that a rig can extend at once, and that contradict each other in four keys."""
    (tmp_path / "one.yaml").write_text(ONE)
    (tmp_path / "two.yaml").write_text(TWO)


@pytest.mark.usefixtures("two_files")
def test_files_that_are_extended_together_are_joined(loaded: Loaded) -> None:
    config = loaded(
        """\
        extends: [one.yaml, two.yaml]
        seed: 3
        buses: {can0: {bitrate: 100000}}
        devices: {io: {node_id: 9, signals: {x: three}}}
        """
    )
    assert (config.seed, list(config.buses), list(config.devices)) == (3, ["can0", "words"], ["io", "lamp"])
    io = config.devices["io"].settings.model_dump()
    assert (io["node_id"], io["signals"]) == (9, {"x": "three", "y": "both", "z": "two"})


@pytest.mark.usefixtures("two_files")
def test_every_key_in_which_they_differ_is_refused_with_both_places(refused: Refused) -> None:
    mistakes = refused("extends: [one.yaml, two.yaml]\n")
    places = {
        "seed": (2, 2),
        "buses.can0.bitrate": (4, 4),
        "devices.io.node_id": (8, 7),
        "devices.io.signals.x": (10, 7),
    }
    assert [mistake.splitlines() for mistake in mistakes] == [
        [
            f"two.yaml:{second}: {key}: one.yaml:{first} has another value, and rig.yaml extends both files",
            "    give the key a value in rig.yaml, or the same value in both",
        ]
        for key, (second, first) in places.items()
    ]


@pytest.mark.parametrize("io", ["null", f'{{kind: "{NODE}", node_id: 8, links: {{can: can0}}}}'])
@pytest.mark.usefixtures("two_files")
def test_an_entry_that_is_replaced_or_taken_away_is_no_conflict(loaded: Loaded, io: str) -> None:
    config = loaded(
        f"extends: [one.yaml, two.yaml]\nseed: 3\nbuses: {{can0: {{bitrate: 100000}}}}\ndevices: {{io: {io}}}\n"
    )
    assert list(config.devices) == (["lamp"] if io == "null" else ["io", "lamp"])


@pytest.mark.usefixtures("two_files")
def test_a_file_between_settles_it_for_those_that_extend_it(loaded: Loaded, tmp_path: Path) -> None:
    settled = "seed: 3\nbuses: {can0: {bitrate: 100000}}\ndevices: {io: {node_id: 9, signals: {x: three}}}\n"
    (tmp_path / "both.yaml").write_text(f"extends: [one.yaml, two.yaml]\n{settled}")
    assert loaded("extends: both.yaml\nseed: 4\n").seed == 4


@pytest.mark.long
def test_a_file_that_is_extended_on_two_ways_is_read_once(refused: Refused, base: Path) -> None:
    base.write_text(base.read_text(encoding="utf-8").replace("node_id: 5", "node_id: 500"), encoding="utf-8")
    last = base
    for name in range(64):  # 2**64 ways to the base
        (base.parent / f"{name}.yaml").write_text(f"extends: [{last.name}, {last.name}]\n")
        last = base.parent / f"{name}.yaml"
    (mistake,) = refused(f"extends: [{last}, {base}]\n")
    assert mistake.startswith(f"{base}:6: devices.io.node_id: 500 doesn't fit")


def test_overrides_are_laid_over_the_file(loaded: Loaded) -> None:
    config = loaded(RIGHT, "buses.can0.bitrate=100000", "seed=0x10", "devices.io.signals.x=w", "start_timeout_s=2.5")
    assert (config.buses["can0"].bus.settings.bitrate, config.seed, config.start_timeout_s) == (100_000, 16, 2.5)
    assert config.devices["io"].settings.model_dump()["signals"] == {"x": "w"}


def test_an_override_with_null_takes_a_device_away(loaded: Loaded) -> None:
    assert list(loaded(RIGHT).devices) == ["io", "reader"]
    assert list(loaded(RIGHT, "devices.reader=null", "devices.io.after=[]").devices) == ["io"]


@pytest.mark.parametrize(
    ("override", "what", "remedy"),
    [
        ("seed", "it cannot be read as an override", "expected a key and a value, such as buses.can0.bitrate=250000"),
        ("seed=[", "it cannot be read as an override", "expected a key and a value, such as buses.can0.bitrate=250000"),
        ("seed.x=1", "seed.x: seed holds no keys", "expected a key of the rig file"),
        ("buses.canO.bitrate=1", "buses.canO.bitrate: there is no bus 'canO'", "did you mean can0?"),
        ("devices.oi.after=[]", "devices.oi.after: there is no device 'oi'", "there are: io, reader"),
        ("sed=1", "sed: there is no such key", "did you mean seed?"),
        ("buss.can0.bitrate=1", "buss: there is no such key", "did you mean buses?"),
        ("can0.bitrate=1", "can0: there is no such key", "did you mean buses.can0?"),
        ("io.node_id=1", "io: there is no such key", "did you mean devices.io?"),
        (
            "buses.can0.bitrate=1",
            "buses.can0.bitrate: 1 doesn't fit",
            "expected a whole number from 10000 to 1000000 (bit/s)",
        ),
    ],
)
def test_an_override_that_is_wrong_is_named(refused: Refused, override: str, what: str, remedy: str) -> None:
    assert refused(RIGHT, override) == [f"--set {override}: {what}\n    {remedy}"]


@pytest.mark.parametrize("text", [None, "", "- a\n", "devices: [\n"])
def test_a_file_that_is_no_rig_file_has_one_mistake_however_many_overrides_there_are(
    tmp_path: Path, text: str | None
) -> None:
    file = tmp_path / "rig.yaml"
    if text is not None:
        file.write_text(text)
    with pytest.raises(ConfigError) as refusal:
        load(file, ["time=virtual", "control=tcp/127.0.0.1:1"])
    assert [mistake.file for mistake in refusal.value.mistakes] == [str(file)]


def test_a_process_loads_only_what_it_hosts(loaded: Loaded) -> None:
    text = RIGHT + '      other: {kind: "nowhere:Press", links: {x: words}}\n'
    config = loaded(text, only={"io"})
    assert (list(config.buses), list(config.devices)) == (["can0", "words"], ["io"])
    config = loaded(text, only={"words"})
    assert (list(config.buses), list(config.devices)) == (["words"], [])


def test_a_bus_knows_all_its_members_in_every_process(loaded: Loaded) -> None:
    members = [("io", "rack"), ("reader", "reader")]
    assert list(loaded(RIGHT).buses["words"].members.items()) == members
    assert list(loaded(RIGHT, only={"reader"}).buses["words"].members.items()) == members


# -- from memory


def test_a_rig_may_come_from_a_dict(tmp_path: Path) -> None:
    (tmp_path / "io.txt").write_text("x")
    node = {"kind": NODE, "node_id": 5, "links": {"can": "can0"}, "file": tmp_path / "io.txt", "pair": (1, 2)}
    data = {"time": "virtual", "buses": {"can0": {"kind": "can.virtual"}}, "devices": {"io": node}}
    data["buses"] = {"can0": {"kind": "config_kinds:CanLine"}}
    config = from_dict(data, tmp_path)
    assert config.devices["io"].settings.model_dump()["pair"] == (1, 2)


def test_a_mistake_in_a_dict_has_no_place() -> None:
    with pytest.raises(ConfigError) as caught:
        from_dict({"time": "virtual", "sed": 1})
    assert str(caught.value) == "sed: there is no such key\n    did you mean seed?"


# -- garbage


@pytest.fixture(scope="module")
def garbage_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("garbage") / "rig.yaml"


def only_mistakes(act: Callable[[], RigConfig]) -> None:
    try:
        act()
    except ConfigError as wrong:
        str(wrong).encode()  # half surrogates could not be printed


@pytest.mark.long
@settings(max_examples=150, deadline=None)
@given(text=st.text() | st.text(alphabet="[]{}:,-?|>&*!%#'\"\\ \n\tabUx0<~.="))
def test_garbage_is_a_mistake(garbage_file: Path, text: str) -> None:
    garbage_file.write_text(text, encoding="utf-8", newline="")
    only_mistakes(lambda: load(garbage_file))


@pytest.mark.long
@settings(max_examples=50, deadline=None)
@given(data=st.binary())
def test_bytes_are_a_mistake(garbage_file: Path, data: bytes) -> None:
    garbage_file.write_bytes(data)
    only_mistakes(lambda: load(garbage_file))


@pytest.mark.long
@settings(max_examples=150, deadline=None)
@given(data=st.data())
def test_a_right_file_with_a_slip_is_right_or_a_mistake(garbage_file: Path, data: st.DataObject) -> None:
    text = dedent(RIGHT)
    position = data.draw(st.integers(0, len(text)))
    length = data.draw(st.integers(0, 10))
    slip = data.draw(st.text(alphabet='[]{}:,- \n"ab01~', max_size=4))
    garbage_file.write_text(text[:position] + slip + text[position + length :], encoding="utf-8")
    only_mistakes(lambda: load(garbage_file))


JSON_VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.sampled_from(["can0", NODE, "io", "x"]),
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.dictionaries(
            st.sampled_from(["kind", "links", "after", "process", "can", "can0", "io", "signals", "pair", "node_id"]),
            inner,
        )
    ),
    max_leaves=8,
)


@pytest.mark.long
@settings(max_examples=100, deadline=None)
@given(
    rest=st.dictionaries(st.sampled_from(["time", "buses", "devices", "seed", "speed", "control", "name"]), JSON_VALUES)
)
def test_any_values_anywhere_are_right_or_a_mistake(rest: dict[str, Any]) -> None:
    sys.path.insert(0, str(HERE))
    try:
        only_mistakes(lambda: from_dict({"time": "virtual", **rest}, HERE))
    finally:
        sys.path.remove(str(HERE))


@pytest.mark.long
def test_nesting_and_aliases_without_end_are_a_mistake(refused: Refused) -> None:
    assert "nested too deeply" in refused("[" * 3000)[0]
    assert "contains itself" in refused("time: &a [*a]")[0]
    bomb = "a0: &a0 [1, 1, 1, 1, 1, 1, 1, 1, 1]\n"
    bomb += "".join(f"a{n}: &a{n} [{', '.join([f'*a{n - 1}'] * 9)}]\n" for n in range(1, 9))
    assert re.search("more than 100000 values", refused(bomb)[0])
