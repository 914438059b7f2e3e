"""TCP connections of outside clients to the services of devices, such as HTTP and FTP."""
