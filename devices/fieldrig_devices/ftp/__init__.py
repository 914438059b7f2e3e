"""An FTP server for the files of a device."""
