"""CAN bus of the rig: sending and receiving (python-can)."""

import time
from collections import Counter
from collections.abc import Callable, Iterable
from typing import Any

from cca_core._optional import require_extra
from cca_core.errors import InputError
from cca_core.rig.frames import Frame


class BusLink:
    """A CAN bus that never raises: errors are counted, and the bus is opened again.

    Parameters
    ----------
    arguments : dict
        Arguments of ``can.Bus``.
    reopen_after : float
        Time between two attempts to open a bus that failed [s].
    open_bus : callable, optional
        Opens a bus with these arguments; the default is ``can.Bus``.

    Attributes
    ----------
    counts : Counter
        Number of frames ``"sent"`` and ``"received"``, of ``"unreadable"`` ones, of ``"error_frames"``, of
        failures to send (``"not_sent"``), and of attempts to open the bus again (``"reopened"``).

    Raises
    ------
    MissingExtraError
        If python-can is not installed.
    InputError
        If the bus cannot be opened the first time.
    """

    def __init__(
        self,
        arguments: dict[str, Any],
        *,
        reopen_after: float = 0.5,
        open_bus: Callable[..., Any] | None = None,
    ) -> None:
        self._can = require_extra("can", "rig")
        self._arguments, self._open_bus = dict(arguments), open_bus or self._can.Bus
        self._reopen_after = reopen_after
        self.counts: Counter[str] = Counter()
        self._t_failed = 0.0
        try:
            self._bus: Any = self._open_bus(**self._arguments)
        except Exception as error:  # every interface has errors of its own
            raise InputError(f"bus must be one that can be opened: {type(error).__name__}: {error}") from None

    def send(self, frames: Iterable[Frame]) -> bool:
        """Send frames.

        Parameters
        ----------
        frames : iterable of Frame
            In order.

        Returns
        -------
        sent : bool
            Whether the interface took all of them.
        """
        failures = self.counts["not_sent"]
        for frame in frames:
            if not self._is_open():
                self.counts["not_sent"] += 1
                continue
            message = self._can.Message(arbitration_id=frame.id, data=frame.data, is_extended_id=False)
            try:
                self._bus.send(message)
                self.counts["sent"] += 1
            except Exception:  # bus off, buffer full, an adapter that was unplugged
                self.counts["not_sent"] += 1
                self._close()
        return self.counts["not_sent"] == failures

    def receive(self, timeout: float = 0.0) -> Frame | None:
        """Return the next frame.

        Parameters
        ----------
        timeout : float
            Time to wait for it [s].

        Returns
        -------
        frame : Frame or None
            None if there is none, or the next one is unreadable.
        """
        if not self._is_open():
            time.sleep(min(timeout, 0.01))
            return None
        try:
            message = self._bus.recv(timeout)
        except OSError:
            self._close()
            return None
        except Exception as error:
            if isinstance(error.__cause__, OSError):
                self._close()
            else:  # bytes on the port of a bus in software that are no frame
                self.counts["unreadable"] += 1
            return None
        if message is None:
            return None
        if message.is_error_frame or message.is_remote_frame or message.is_extended_id:
            self.counts["error_frames" if message.is_error_frame else "foreign"] += 1
            return None
        self.counts["received"] += 1
        return Frame(message.arbitration_id, bytes(message.data), message.timestamp)

    def drain(self, limit: int = 1000) -> list[Frame]:
        """Return all frames that have arrived, without waiting.

        Parameters
        ----------
        limit : int
            Largest number of attempts to receive [-]: a flood must not hold the caller.

        Returns
        -------
        frames : list of Frame
            In order of arrival.
        """
        frames = []
        for _ in range(limit):
            before = self.counts.total()
            frame = self.receive()
            if frame is not None:
                frames.append(frame)
            elif self.counts.total() == before:  # nothing has come, not even what is no frame of this rig
                break
        return frames

    def close(self) -> None:
        """Close the bus."""
        if self._bus is not None:
            self._bus.shutdown()
            self._bus = None
            self._t_failed = float("inf")

    def _is_open(self) -> bool:
        if self._bus is None and time.monotonic() - self._t_failed >= self._reopen_after:
            self._t_failed = time.monotonic()
            self.counts["reopened"] += 1
            try:
                self._bus = self._open_bus(**self._arguments)
            except Exception:  # still not there
                self._bus = None
        return self._bus is not None

    def _close(self) -> None:
        self._t_failed = time.monotonic()
        try:
            self._bus.shutdown()
        except Exception:  # it has failed already
            self.counts["not_closed"] += 1
        self._bus = None
