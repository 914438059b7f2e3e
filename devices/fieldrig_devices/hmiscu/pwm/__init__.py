"""PWM: a square wave with a frequency and a duty cycle."""
