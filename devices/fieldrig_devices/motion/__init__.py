"""Motion profiles and limits of travel, shared by all devices that move axes."""
