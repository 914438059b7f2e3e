"""HMISCU: the fast outputs of a panel with a controller, as pulse trains (PTO) and pulse-width modulation (PWM).

Source: Magelis SCU HMI Controller PTO/PWM Library Guide, 12/2016; rows SCU-001 to SCU-100.
"""
