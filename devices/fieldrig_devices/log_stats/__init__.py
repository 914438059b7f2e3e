"""Statistics of a log in constant memory: identifiers, nodes, units, load, answer times and errors."""
