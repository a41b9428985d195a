"""Control port of a process: the driver's hands, and errors of the system clock, given while it runs."""

import math

from cca_core.rig.udp import UdpLink


class ControlPort:
    """Takes lines such as ``driver on``, ``driver off``, ``utc 5.0`` and ``drift 0.001`` as datagrams.

    Parameters
    ----------
    address : str
        Address and port at which lines are received; empty for none.

    Attributes
    ----------
    has_driver : bool
        Whether the driver steers or brakes.
    unreadable : int
        Number of lines that were not understood [-].

    Raises
    ------
    InputError
        If the address cannot be used.

    Notes
    -----
    ``utc`` adds an offset [s] to what the process reads as time of the operating system, ``drift`` an offset
    that grows from now on [s/s]. The port is for tests and demonstrations; it is closed by default.
    """

    def __init__(self, address: str = "") -> None:
        self.has_driver = False
        self.unreadable = 0
        self._link = UdpLink(address) if address else None
        self._offset = self._drift = self._begin = 0.0

    def poll(self, t: float) -> None:
        """Take the lines that have arrived.

        Parameters
        ----------
        t : float
            Control time now [s].
        """
        for data in self._link.drain() if self._link else ():
            word, _, value = data.decode("utf-8", "replace").strip().partition(" ")
            number = _number(value)
            if word == "driver" and value in ("on", "off"):
                self.has_driver = value == "on"
            elif word == "utc" and math.isfinite(number):
                self._offset = number
            elif word == "drift" and math.isfinite(number):
                self._drift, self._begin = number, t
            else:
                self.unreadable += 1

    def utc_error(self, t: float) -> float:
        """Return what is added to the time of the operating system.

        Parameters
        ----------
        t : float
            Control time now [s].

        Returns
        -------
        error : float
            Offset and drift [s].
        """
        return self._offset + self._drift * (t - self._begin)

    def close(self) -> None:
        """Close the port."""
        if self._link:
            self._link.close()


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return math.nan
