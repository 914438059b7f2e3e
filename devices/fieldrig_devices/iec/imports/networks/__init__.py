"""Networks of ladder diagram and function block diagram, and sequential function charts, as a graph of elements."""
