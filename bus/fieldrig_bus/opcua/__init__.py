"""OPC UA: devices offer trees of nodes, and a server in the process of the bus shows them to any client."""
