"""CAN bus of the rig: sending, receiving, logs and their replay (python-can)."""

import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from importlib.util import find_spec
from pathlib import Path as FilePath
from threading import Event, Thread
from typing import Any

from cca_core._optional import require_extra
from cca_core.errors import InputError, MissingExtraError
from cca_core.rig.messages import Frame

_READERS = {
    ".blf": "BLFReader", ".mf4": "MF4Reader", ".asc": "ASCReader", ".log": "CanutilsLogReader",
    ".csv": "CSVReader",
}  # fmt: skip

LOG_ENDINGS = tuple(_READERS)
"""Endings of the files of a bus log; MF4 needs the package asammdf."""


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
            self.counts["error_frames"] += message.is_error_frame
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
            before = self.counts["unreadable"] + self.counts["error_frames"]
            frame = self.receive()
            if frame is not None:
                frames.append(frame)
            elif self.counts["unreadable"] + self.counts["error_frames"] == before:
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


class BusRecorder:
    """Recorder of all frames of a bus, in a thread of its own.

    Parameters
    ----------
    arguments : dict
        Arguments of ``can.Bus``.
    file : str or pathlib.Path
        File with one of `LOG_ENDINGS`.

    Raises
    ------
    InputError
        If the ending is unknown or the bus cannot be opened.
    MissingExtraError
        If python-can, or asammdf for MF4, is not installed.
    """

    def __init__(self, arguments: dict[str, Any], file: str | FilePath) -> None:
        self._can = require_extra("can", "rig")
        _check_ending(file)
        self._logger = self._can.Logger(str(file))
        self._link = BusLink(arguments)
        self._is_closing = Event()
        self._thread = Thread(target=self._record, name="bus recorder", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Write what has arrived and close the file."""
        self._is_closing.set()
        self._thread.join()
        self._logger.stop()
        self._link.close()

    def _record(self) -> None:
        while True:
            is_closing = self._is_closing.is_set()
            frame = self._link.receive(0.0 if is_closing else 0.1)
            if frame is not None:
                self._logger.on_message_received(self._can.Message(
                    arbitration_id=frame.id, data=frame.data, timestamp=frame.t, is_extended_id=False
                ))  # fmt: skip
            elif is_closing:
                return


def read_bus_log(file: str | FilePath) -> Iterator[Frame]:
    """Read a bus log.

    Parameters
    ----------
    file : str or pathlib.Path
        File with one of `LOG_ENDINGS`.

    Yields
    ------
    frame : Frame
        Frames with their times in UTC [s], in order.

    Raises
    ------
    InputError
        If the ending is unknown or the file cannot be read.
    MissingExtraError
        If python-can, or asammdf for MF4, is not installed.
    """
    can = require_extra("can", "rig")
    _check_ending(file)
    if not FilePath(file).is_file():
        raise InputError(f"file {str(file)!r} must exist")
    ending = FilePath(file).suffix.lower()
    reader, mode = getattr(can, _READERS[ending]), "rb" if ending in (".blf", ".mf4") else "r"
    try:
        with FilePath(file).open(mode) as stream:
            for message in reader(stream):
                yield Frame(message.arbitration_id, bytes(message.data), message.timestamp)
    except Exception as error:  # every format has errors of its own
        raise InputError(f"file {str(file)!r} cannot be read: {type(error).__name__}: {error}") from None


def replay_bus(
    frames: Iterable[Frame],
    link: BusLink,
    *,
    ids: frozenset[int] = frozenset(),
    rate: float = 1.0,
    sleep: Callable[[float], object] = time.sleep,
) -> int:
    """Send recorded frames at the times between them.

    Parameters
    ----------
    frames : iterable of Frame
        In order of time, such as `read_bus_log` returns them.
    link : BusLink
        Bus.
    ids : frozenset of int
        Identifiers to send [-]; none are all.
    rate : float
        Speed of the replay [-]; 1 is that of the recording.
    sleep : callable
        Waits for a time [s].

    Returns
    -------
    sent : int
        Number of frames.
    """
    begin, first, n = time.monotonic(), None, 0
    for frame in frames:
        if ids and frame.id not in ids:
            continue
        first = frame.t if first is None else first
        wait = (frame.t - first) / rate - (time.monotonic() - begin)
        if wait > 0.0:
            sleep(wait)
        link.send([frame])
        n += 1
    return n


def _check_ending(file: str | FilePath) -> None:
    ending = FilePath(file).suffix.lower()
    if ending not in LOG_ENDINGS:
        raise InputError(f"file must end with one of {', '.join(LOG_ENDINGS)}, was {str(file)!r}")
    if ending == ".mf4" and find_spec("asammdf") is None:
        raise MissingExtraError("asammdf is not installed; run: pip install asammdf")
