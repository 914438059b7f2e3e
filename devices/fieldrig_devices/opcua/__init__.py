"""The nodes that devices offer to OPC UA clients."""
