"""Files of TwinCAT for suites: the blocks of Tc2_System and Tc2_Utilities, with files that are in memory only.

As on a controller, a block works from the rising edge of bExecute on, and is busy until it is called again.  All
folders exist.  No file of the host is read or written.

Source: the public descriptions of Tc2_System and Tc2_Utilities.
"""
