"""What is wrong at a chair's joystick, in words, and what to do."""

from __future__ import annotations

from lfdcore.hardware import JoystickLink, JoystickReading

REMEDIES = {
    "not calibrated": "the stick is not calibrated: calibrate it (lfdcore joystick calibrate --help)",
    "forward wire": "the stick's forward axis reads {adc[0]} of 1023, beyond its calibrated ends: is a wire broken or "
    "short? If it is whole, calibrate it (lfdcore joystick calibrate --help)",
    "left wire": "the stick's left axis reads {adc[1]} of 1023, beyond its calibrated ends: is a wire broken or short? "
    "If it is whole, calibrate it (lfdcore joystick calibrate --help)",
    "DAC": "a DAC does not answer: look at its supply and at SDA and SCL",
    "bad command": "the PC commanded what is out of range: let the stick go",
    "forward DAC's memory": "the forward DAC does not keep its neutral voltage: replace it",
    "left DAC's memory": "the left DAC does not keep its neutral voltage: replace it",
}
"""What to do about each fault that a chip tells"""
UNKNOWN = "the chip tells a fault that this lfdcore does not know: flash its firmware (make -C firmware flash)"


def link_trouble(link: JoystickLink) -> str:
    """Why a chair does not drive as far as its joystick's link knows, and what to do; empty while it may."""
    said = link.read()
    if said is None:
        return link.fault
    found = [REMEDIES.get(fault, UNKNOWN).format(adc=said.adc) for fault in said.faults]
    if said.emergency:
        found.append("the emergency button is pressed, or its wire is broken")
    if link.state == "neutral_required" and not found:
        found.append(_not_neutral(said))
    return "; ".join(found)


def _not_neutral(said: JoystickReading) -> str:
    if said.forward == 0 and said.left == 0:
        return "hold the stick at neutral for a moment longer"
    return (
        f"let the stick go: it says {said.forward:+.2f} ahead, {said.left:+.2f} to the left. If it is let go, it is "
        "off centre: calibrate it (lfdcore joystick calibrate --help)"
    )
