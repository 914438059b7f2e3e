"""Iron for the machines: axes and winders that move as the closed solution says, on wires with units."""
