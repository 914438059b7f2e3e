"""The memory between a controller and its PLC, as a bus: `dualport.shm`."""
