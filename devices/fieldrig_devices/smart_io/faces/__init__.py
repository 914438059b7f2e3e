"""The Smart-IO node without a PAM: a CiA 401 module and a Modbus device."""
