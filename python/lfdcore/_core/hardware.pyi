"""
Devices: LIDARs that speak SCIP 2.0.
"""

from __future__ import annotations
import lfdcore._core.grid
import typing

__all__: list[str] = ["ScipLidar", "ScipStatistics", "TimedScan"]

class TimedScan:
    """
    A scan, when it was taken, and its number.
    """

    @property
    def scan(self) -> lfdcore._core.grid.LaserScan:
        """
        LaserScan
        """

    @property
    def sequence(self) -> int:
        """
        1 for the first scan that was received
        """

    @property
    def stamp(self) -> float:
        """
        when the scanner's mirror began its turn, by the clock of time.monotonic() [s]
        """

class ScipStatistics:
    """
    What a ScipLidar has received.
    """

    @property
    def damaged(self) -> int:
        """
        replies with a wrong sum or a wrong length, and what was no reply
        """

    @property
    def lost(self) -> int:
        """
        scans that the device's clock says are missing between those received
        """

    @property
    def reconnects(self) -> int:
        """
        times that it measured anew after it was lost
        """

    @property
    def scans(self) -> int:
        """
        received whole
        """

class ScipLidar:
    """
    A LIDAR that speaks SCIP 2.0 (Hokuyo UTM-30LX, URG-04LX and their kin), read by a thread of its own from its construction to close().

    address: a serial port (/dev/...), or host or host:port in the network (port 10940 unless given). A serial port is tried at `baud`, then at 115200, 19200, 57600 and 500000. upside_down: mounted hanging, so that its scans are mirrored.

    Raises DeviceError unless it measures: absent, taken, no SCIP device, broken; ValueError for an address or a rate that cannot be. A device that is lost later is no error: fault() says what is wrong, newest() grows old, and the thread tries until it measures again.
    """

    def __init__(self, address: str, *, baud: int = 115200, upside_down: bool = False) -> None: ...
    def close(self) -> None:
        """
        Switches the laser off and ends the thread, within about a second. The last scan stays.
        """

    def fault(self) -> str:
        """
        What is wrong and what to do; empty while it measures.
        """

    def model(self) -> str:
        """
        As the device calls itself.
        """

    def newest(self) -> TimedScan | None:
        """
        The newest scan, at once; None before the first. Compare its stamp with now.
        """

    def scan_period(self) -> float:
        """
        [s]
        """

    def statistics(self) -> ScipStatistics:
        """
        ScipStatistics until now
        """

    def wait_newer(self, sequence: int, patience: float) -> TimedScan | None:
        """
        Waits for a scan with a higher sequence number, `patience` [s] at the longest -> TimedScan or None.
        """
