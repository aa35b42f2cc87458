"""The powered wheelchair: from scan and joystick to the driver's intention, a path and a command (Ch. 3)."""
