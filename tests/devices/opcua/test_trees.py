"""The nodes that devices offer, without a bus: points, methods, and the variables of a real program."""

import pytest

from fieldrig.clock import VirtualClock
from fieldrig.device import Point
from fieldrig.testing import RecordedLink
from fieldrig_bus.opcua import message as opc
from fieldrig_devices.iec.compiler import compile_project
from fieldrig_devices.iec.runtime import Runtime, Start
from fieldrig_devices.iec.standalone import StandaloneHost
from fieldrig_devices.languages.source_file import SourceFile
from fieldrig_devices.opcua.face import OpcUaFace
from fieldrig_devices.opcua.methods import Method, MethodsTree
from fieldrig_devices.opcua.points import PointsTree
from fieldrig_devices.opcua.symbols import SymbolsTree
from fieldrig_devices.opcua.tree import NodeTree, Trees, UnknownNodeError

PROGRAM = """
TYPE Colour : (red, green := 5); END_TYPE
TYPE Axis : STRUCT speed : REAL; (* in mm/s *) END_STRUCT END_TYPE
FUNCTION_BLOCK Belt VAR_INPUT position : DINT := 7; END_VAR VAR axes : ARRAY[1..2] OF Axis; END_VAR END_FUNCTION_BLOCK
VAR_GLOBAL grid : ARRAY[0..1, 5..6] OF INT; END_VAR
VAR_GLOBAL CONSTANT highest : INT := 3; END_VAR
PROGRAM PLC_PRG
VAR belt : Belt; wait : TIME := T#1s500ms; name : STRING(10) := 'abc'; small : INT(0..10); colour : Colour;
    values : ARRAY[1..3] OF INT := 1, 2, 3; (* the last three *) END_VAR
belt.position := belt.position;
END_PROGRAM
"""


@pytest.fixture
def tree() -> SymbolsTree:
    host = StandaloneHost(VirtualClock())
    compiled = compile_project([SourceFile("plc.st", PROGRAM)], host)
    runtime = Runtime(compiled, host)
    runtime.initialise(Start.COLD)
    return SymbolsTree(compiled.symbols, runtime)


def paths(tree: NodeTree, path: str) -> list[str]:
    return [node.path for node in tree.children(path)]


def test_programs_and_their_parts_have_the_paths_of_the_source(tree: SymbolsTree) -> None:
    assert set(paths(tree, "")) >= {"PLC_PRG", "grid", "highest"}
    assert set(paths(tree, "PLC_PRG")) == {
        f"PLC_PRG.{name}" for name in ("belt", "wait", "name", "small", "colour", "values")
    }
    assert paths(tree, "PLC_PRG.belt.axes") == ["PLC_PRG.belt.axes[1]", "PLC_PRG.belt.axes[2]"]
    assert paths(tree, "PLC_PRG.belt.axes[2]") == ["PLC_PRG.belt.axes[2].speed"]
    assert tree.find("plc_prg.BELT.position") == opc.Node(
        "PLC_PRG.belt.position", "PLC_PRG.belt", "position", opc.Kind.VARIABLE, "DINT", is_writable=True
    )


def test_every_node_is_a_child_of_its_parent(tree: SymbolsTree) -> None:
    waiting, seen = [""], 0
    while waiting:
        path = waiting.pop()
        for node in tree.children(path):
            assert (node.parent, tree.find(node.path)) == (path, node)
            assert bool(tree.children(node.path)) is node.has_children
            waiting.append(node.path)
            seen += 1
    assert seen > 20


def test_types_ranges_choices_units_and_comments(tree: SymbolsTree) -> None:
    def node(path: str) -> opc.Node:
        found = tree.find(path)
        assert found is not None
        return found

    assert (node("PLC_PRG.wait").type, node("PLC_PRG.wait").unit) == ("TIME", "ms")
    assert (node("PLC_PRG.small").low, node("PLC_PRG.small").high) == (0, 10)
    assert node("PLC_PRG.colour").choices == (("red", 0), ("green", 5))
    assert (node("PLC_PRG.values").type, node("PLC_PRG.values").length) == ("INT", 3)
    assert node("PLC_PRG.values").about == "the last three"
    assert (node("grid").kind, node("grid[1]").length) == (opc.Kind.OBJECT, 2)
    assert not node("highest").is_writable


def test_values_are_read_and_written(tree: SymbolsTree) -> None:
    assert [tree.read(f"PLC_PRG.{name}") for name in ("wait", "name", "values", "belt.position")] == [
        1_500, "abc", [1, 2, 3], 7,
    ]  # fmt: skip
    tree.write("PLC_PRG.values", [4, 5, 6])
    tree.write("PLC_PRG.values[2]", 9)
    tree.write("grid[1,6]", -1)
    assert (tree.read("PLC_PRG.values"), tree.read("grid[1]")) == ([4, 9, 6], [0, -1])


def test_what_can_t_be_written_is_refused(tree: SymbolsTree) -> None:
    wrong: list[tuple[str, opc.AnyValue]] = [("PLC_PRG.values", [1]), ("PLC_PRG.small", 11), ("highest", 4)]
    for path, value in wrong:
        with pytest.raises(ValueError, match="expected"):
            tree.write(path, value)
    with pytest.raises(TypeError):
        tree.write("PLC_PRG.values", 1)
    for path in ("PLC_PRG", "PLC_PRG.none", "PLC_PRG.values[4]", ""):
        with pytest.raises(UnknownNodeError):
            tree.read(path)


# ---- points and methods


def test_the_parts_of_a_key_are_objects() -> None:
    points = {
        "a.b.c": Point(lambda: 1),
        "a.b": Point(lambda: "x", lambda _: None, "mm", "text"),
        "d": Point(lambda: 2.0),
    }
    tree = PointsTree(lambda: points)
    assert (paths(tree, ""), paths(tree, "a"), paths(tree, "a.b")) == (["a", "d"], ["a.b"], ["a.b.c"])
    assert tree.find("a") == opc.Node("a", "", "a", opc.Kind.OBJECT, has_children=True)
    assert tree.find("a.b") == opc.Node("a.b", "a", "b", opc.Kind.VARIABLE, "STRING", None, True, True, "mm", "text")
    assert tree.find("e") is None


@pytest.mark.parametrize(
    ("value", "name"), [(True, "BOOL"), (1, "DINT"), (2**31, "LINT"), (1.0, "LREAL"), ("x", "STRING")]
)
def test_a_point_has_the_type_of_its_value(value: bool | int | float | str, name: str) -> None:
    found = PointsTree(lambda: {"x": Point(lambda: value)}).find("x")
    assert found is not None
    assert found.type == name


# ---- the face


class FaceBench:
    def __init__(self) -> None:
        self.link = RecordedLink[opc.OpcUaMessage]()
        self.value: object = 1

        def write(value: object) -> None:
            if value == 13:
                raise ValueError("expected another number")
            self.value = value

        points = {f"p{number}": Point(lambda: 0) for number in range(opc.MOST_NODES + 5)}
        points["x"] = Point(lambda: 1, write)
        methods = MethodsTree({"go": Method("go", lambda: None), "halt": Method("halt", self.halt)})
        self.face = OpcUaFace("io", "an IO", self.link, lambda: Trees([PointsTree(lambda: points), methods]))

    def halt(self) -> None:
        raise ValueError("it does not run")

    def ask(self, request: opc.OpcUaMessage) -> opc.OpcUaMessage:
        self.link.deliver(request)
        [answer] = self.link.take()
        return answer


def test_each_offer_has_its_own_generation() -> None:
    bench = FaceBench()
    bench.face.offer()
    bench.face.offer()
    assert bench.link.take() == [opc.Offer("io", "an IO", 1), opc.Offer("io", "an IO", 2)]


def test_many_children_come_in_parts() -> None:
    bench = FaceBench()
    first, second = (bench.ask(opc.Browse("io", 1, "", start)) for start in (0, opc.MOST_NODES))
    assert isinstance(first, opc.Nodes)
    assert isinstance(second, opc.Nodes)
    assert (len(first.nodes), first.is_complete, len(second.nodes), second.is_complete) == (
        opc.MOST_NODES,
        False,
        8,
        True,
    )


@pytest.mark.parametrize(
    ("request_", "status"),
    [
        (opc.Write("io", 1, "x", 2), opc.Status.GOOD),
        (opc.Write("io", 1, "x", 13), opc.Status.OUT_OF_RANGE),
        (opc.Write("io", 1, "x", [1]), opc.Status.TYPE_MISMATCH),
        (opc.Write("io", 1, "p1", 2), opc.Status.NOT_WRITABLE),
        (opc.Write("io", 1, "go()", 2), opc.Status.NOT_WRITABLE),
        (opc.Write("io", 1, "none", 2), opc.Status.UNKNOWN),
        (opc.Call("io", 1, "go()"), opc.Status.GOOD),
        (opc.Call("io", 1, "halt()"), opc.Status.REFUSED),
        (opc.Call("io", 1, "x"), opc.Status.UNKNOWN),
    ],
)
def test_a_request_has_its_status(request_: opc.OpcUaMessage, status: opc.Status) -> None:
    answer = FaceBench().ask(request_)
    assert isinstance(answer, opc.Outcomes)
    assert (answer.exchange, [outcome.status for outcome in answer.outcomes]) == (1, [status])


def test_values_come_in_the_order_of_the_paths() -> None:
    assert FaceBench().ask(opc.Read("io", 4, ("x", "none", "p1"))) == opc.Outcomes(
        4, (opc.Outcome(opc.Status.GOOD, 1), opc.Outcome(opc.Status.UNKNOWN), opc.Outcome(opc.Status.GOOD, 0))
    )
    assert FaceBench().ask(opc.Find("io", 5, "none")) == opc.Nodes(5, ())
