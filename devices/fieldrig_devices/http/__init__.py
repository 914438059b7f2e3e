"""An HTTP server for pages of a device."""
