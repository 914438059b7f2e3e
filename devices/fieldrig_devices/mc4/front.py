"""The front of a drive: its diagnosis and states with their names, its enables, and the motor.

Source: manual 4163-4196 for the diagnosis, 6066-6171 for the states (digest PD-093, PD-150 to PD-160).  The manual
leaves LEDs and display to a manual of the drive, so their places are ours.
"""

from fieldrig.front import Front, Group, Key, Led, Number, Plate, SevenSegment, Switch, Text
from fieldrig_devices.drives.motor import INCREMENTS_PER_TURN
from fieldrig_devices.drives.state_words import AXIS_WORDS, MC4_WORDS
from fieldrig_devices.mc4.machine import Machine
from fieldrig_devices.motion.front import motion, position, shaft


def front_of(machine: Machine) -> Front:
    motor = machine.true_motor
    return Front(
        Plate("ELAU", "MC-4", {"motor": "motor_type", "serial number": "motor_serial", "name plate": "plate"}),
        [
            Group(
                [
                    SevenSegment("DiagCode", "diag_code", "code of the most severe pending diagnosis", digits=4),
                    Text("diagnosis", "diag_msg", names=(("", "none"),)),
                    Key("Quit", "quit", "acknowledges the errors", released=None),
                ],
                "diagnosis",
            ),
            Group(
                [
                    Text("AxisState", "axis_state", names=tuple(AXIS_WORDS.items()), good=(3,), bad=(5,)),
                    Text("MC4State", "mc4_state", names=tuple(MC4_WORDS.items()), good=(0x21,), bad=(0x02,)),
                    Number("phase", "phase", "phase of the ring, CP0 to CP4"),
                    Led("ready", "ready", "the ready contact is closed"),
                    Led("torque", "torque_on", "the motor is not free", colour="yellow"),
                    Led("brake", "brake", "the brake relay is closed, so the brake lifts", colour="yellow"),
                    Led("controller enable", "controller_enable", "from the ring"),
                ],
                "state",
            ),
            motion(
                position(),
                ("speed", motor.max_speed_rpm),
                ("torque", motor.peak_torque_nm),
                shaft("position", INCREMENTS_PER_TURN, "the shaft of the motor"),
            ),
            Group(
                [
                    Switch("Inverter Enable", "inverter_enable", "the input for the safe stop"),
                    Switch("mains", "mains", "the supply of this drive"),
                    Number("DC circuit", "dc_bus", decimals=0),
                    Number("overload", "overload", "at 100 % the drive switches off", decimals=1),
                    Number("motor", "motor_temperature", "temperature of the winding", decimals=1),
                ],
                "power",
            ),
        ],
    )
