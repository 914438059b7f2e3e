"""The bodies of one POU, from whatever language they are drawn in."""

from dataclasses import dataclass, field

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.imports.fragments import Fragments
from fieldrig_devices.iec.imports.networks.chart import Chart
from fieldrig_devices.iec.imports.networks.graph import Condition, Drawn, Kind
from fieldrig_devices.iec.imports.networks.hidden import Hidden
from fieldrig_devices.iec.imports.networks.kinds import Kinds
from fieldrig_devices.iec.imports.networks.order import divide, join_connectors
from fieldrig_devices.iec.imports.networks.translate import translate


@dataclass(slots=True)
class Bodies:
    fragments: Fragments
    hidden: Hidden
    kinds: Kinds
    conditions: dict[str, Condition] = field(default_factory=dict)
    """The transitions of the POU that have a name, by the name in small letters."""
    actions: list[tree.Action] = field(default_factory=list)
    """Actions that are written inside of charts."""

    def body(self, drawn: Drawn) -> tree.Body:
        position = tree.Position(drawn.line, 1)
        match drawn.language:
            case "ST" | "IL" as language:
                return self.fragments.body(drawn.text, drawn.line, language)
            case "SFC" if drawn.networks:
                return self._chart(drawn)
            case "LD" | "FBD":
                for network in drawn.networks:
                    join_connectors(network.items)
                networks = drawn.networks if drawn.is_divided else [p for n in drawn.networks for p in divide(n)]
                return tree.StBody(translate(networks, self.fragments, self.hidden, self.kinds), position=position)
        return tree.StBody((), position=position)

    def _chart(self, drawn: Drawn) -> tree.Body:
        network = drawn.networks[0]
        if not any(item.kind is Kind.STEP for item in network.items) and not network.items:
            return tree.StBody((), position=tree.Position(drawn.line, 1))
        self.hidden.network += 1
        return Chart(network, self.fragments, self.hidden, self.kinds, self.conditions, self.actions, self.body).body()
