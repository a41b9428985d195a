"""Logs of the CAN bus: recording, reading and replay (python-can)."""

import time
from collections.abc import Callable, Iterable, Iterator
from importlib.util import find_spec
from pathlib import Path as FilePath
from threading import Event, Thread
from typing import Any

from cca_core._optional import require_extra
from cca_core.errors import InputError, MissingExtraError
from cca_core.rig.bus import BusLink
from cca_core.rig.frames import Frame

_READERS = {
    ".blf": "BLFReader", ".mf4": "MF4Reader", ".asc": "ASCReader", ".log": "CanutilsLogReader",
    ".csv": "CSVReader",
}  # fmt: skip

LOG_ENDINGS = tuple(_READERS)
"""Endings of the files of a bus log; MF4 needs the package asammdf."""


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
