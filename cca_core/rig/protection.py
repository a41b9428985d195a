"""End-to-end protection of CAN messages (AUTOSAR Profile 1): CRC, counter, data id, states of a receiver."""

from collections import Counter, deque
from dataclasses import dataclass, fields
from enum import Enum

from cca_core._checks import check_real
from cca_core._repr import short_repr
from cca_core.errors import InputError

N_COUNTS = 15
"""Counters are 0 to 14; AUTOSAR Profile 1 reserves 15."""

_POLYNOMIAL = 0x1D  # CRC-8 of SAE J1850


def _crc_table() -> tuple[int, ...]:
    table = []
    for byte in range(256):
        for _ in range(8):
            byte = (byte << 1 ^ _POLYNOMIAL) & 0xFF if byte & 0x80 else byte << 1
        table.append(byte)
    return tuple(table)


_CRC = _crc_table()


class CheckStatus(Enum):
    """Result of the check of one reception, as the profile defines them."""

    OK = "ok"
    SOME_LOST = "some messages lost, within the limit"
    INITIAL = "first message"
    SYNC = "counter continues after a jump or a message gap, not yet often enough"
    REPEATED = "counter repeated"
    WRONG_SEQUENCE = "counter jumped"
    WRONG_CRC = "wrong CRC"
    NO_NEW_DATA = "no message"

    @property
    def is_usable(self) -> bool:
        """Whether the content may be used."""
        return self in (CheckStatus.OK, CheckStatus.SOME_LOST)


class LinkState(Enum):
    """State of a link, from the results of its last checks."""

    NO_DATA = "no data"
    INIT = "init"
    VALID = "valid"
    INVALID = "invalid"


@dataclass(frozen=True, slots=True, kw_only=True)
class ProtectionSettings:
    """Limits of the check and of the state machine.

    Parameters
    ----------
    max_delta : int
        Largest step of the counter after a cycle with a message [-], 1 to 14; each cycle without one adds 1.
    max_missing : int
        Cycles without a new message after which the counter must be confirmed again [-].
    sync_messages : int
        Further messages in sequence that confirm a counter after a jump or a message gap [-].
    window : int
        Number of results that the state machine considers [-], at least 1.
    min_ok_init, min_ok_valid, min_ok_invalid : int
        Minimum number of good results in the window to become or to stay valid [-], by the present state.
    max_error_init, max_error_valid, max_error_invalid : int
        Largest number of wrong CRCs in the window for that [-].

    Raises
    ------
    InputError
        If a value is not a whole number within its range.
    """

    max_delta: int = 2
    max_missing: int = 5
    sync_messages: int = 1
    window: int = 10
    min_ok_init: int = 2
    min_ok_valid: int = 1
    min_ok_invalid: int = 3
    max_error_init: int = 0
    max_error_valid: int = 3
    max_error_invalid: int = 1

    __repr__ = short_repr

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            top = N_COUNTS - 1 if field.name in ("max_delta", "max_missing", "sync_messages") else 255
            check_real(field.name, value, ge=field.name in ("max_delta", "window"), le=top)
            if int(value) != value:
                raise InputError(f"{field.name} must be a whole number, was {value:g}")


class ProtectedReceiver:
    """Check of the messages of one data id, and state of their link.

    Parameters
    ----------
    data_id : int
        Identity of the message, 0 to 65535 [-]; sender and receiver agree on it.
    settings : ProtectionSettings, optional
        Limits.

    Attributes
    ----------
    state : LinkState
        Whether the link can be trusted.
    counts : Counter
        Number of each `CheckStatus`.

    Raises
    ------
    InputError
        If `data_id` is out of range.

    Notes
    -----
    Check and states are those of *Specification of SW-C End-to-End Communication Protection Library*
    (AUTOSAR R4.2, E2E Profile 1 and E2E state machine). The data id enters the CRC with both bytes.
    """

    def __init__(self, data_id: int, settings: ProtectionSettings | None = None) -> None:
        self.data_id = int(check_real("data_id", data_id, ge=0, le=0xFFFF))
        self.settings = settings or ProtectionSettings()
        self.state = LinkState.NO_DATA
        self.counts: Counter[CheckStatus] = Counter()
        self._window: deque[CheckStatus] = deque(maxlen=self.settings.window)
        self._last: int | None = None  # counter of the last valid message
        self._max_delta = self.settings.max_delta
        self._missing = self._to_confirm = 0

    def check(self, data: bytes | bytearray | None) -> CheckStatus:
        """Check a message, and advance the state of the link.

        Parameters
        ----------
        data : bytes or None
            Message as received; None in a cycle without one.

        Returns
        -------
        status : CheckStatus
            Its content may be used if `CheckStatus.is_usable`, and if the link is valid.
        """
        status = self._status(data)
        self.counts[status] += 1
        self._advance(status)
        return status

    def _status(self, data: bytes | bytearray | None) -> CheckStatus:
        settings = self.settings
        self._max_delta = min(self._max_delta + (data is None), N_COUNTS - 1)
        if data is None:
            self._missing += 1
            return CheckStatus.NO_NEW_DATA
        counter = data[1] & 0x0F if len(data) > 1 else N_COUNTS
        if counter == N_COUNTS or data[0] != crc8(data[1:], self.data_id):
            return CheckStatus.WRONG_CRC
        if self._last is None:
            self._accept(counter)
            return CheckStatus.INITIAL
        delta = (counter - self._last) % N_COUNTS
        if delta == 0:
            self._missing += 1
            return CheckStatus.REPEATED
        missed, is_near = self._missing > settings.max_missing, delta <= self._max_delta
        self._accept(counter)
        if not is_near:
            self._to_confirm = settings.sync_messages
            return CheckStatus.WRONG_SEQUENCE
        if missed:
            self._to_confirm = settings.sync_messages
        if self._to_confirm:
            self._to_confirm -= not missed
            return CheckStatus.SYNC
        return CheckStatus.OK if delta == 1 else CheckStatus.SOME_LOST

    def _accept(self, counter: int) -> None:
        self._last, self._max_delta, self._missing = counter, self.settings.max_delta, 0

    def _advance(self, status: CheckStatus) -> None:
        if self.state is LinkState.NO_DATA:
            if status not in (CheckStatus.WRONG_CRC, CheckStatus.NO_NEW_DATA):
                self.state = LinkState.INIT
            return
        self._window.append(status)
        n_ok = sum(each.is_usable for each in self._window)
        n_error = self._window.count(CheckStatus.WRONG_CRC)
        settings = self.settings
        if self.state is LinkState.INIT:
            if n_error > settings.max_error_init:
                self.state = LinkState.INVALID
            elif n_ok >= settings.min_ok_init:
                self.state = LinkState.VALID
        elif self.state is LinkState.VALID:
            if n_error > settings.max_error_valid or n_ok < settings.min_ok_valid:
                self.state = LinkState.INVALID
        elif n_error <= settings.max_error_invalid and n_ok >= settings.min_ok_invalid:
            self.state = LinkState.VALID


def crc8(data: bytes | bytearray, data_id: int) -> int:
    """CRC of a message: that of SAE J1850 over both bytes of the data id, the lower one first, and the data.

    Parameters
    ----------
    data : bytes
        The message without its CRC.
    data_id : int
        Identity of the message, 0 to 65535 [-].

    Returns
    -------
    crc : int
        0 to 255. Start value and final XOR are 0, as Profile 1 uses them.
    """
    crc = _CRC[_CRC[data_id & 0xFF] ^ data_id >> 8 & 0xFF]
    for byte in data:
        crc = _CRC[crc ^ byte]
    return crc


def protect(data: bytes | bytearray, data_id: int, counter: int) -> bytes:
    """Write counter and CRC into a message.

    Parameters
    ----------
    data : bytes
        Message of at least two bytes. Byte 0 and the lower half of byte 1 are overwritten.
    data_id : int
        Identity of the message, 0 to 65535 [-].
    counter : int
        Number of the message [-]; it is sent modulo 15.

    Returns
    -------
    message : bytes
        The message with CRC in byte 0 and counter in the lower half of byte 1.

    Raises
    ------
    InputError
        If the message is shorter than two bytes or `data_id` is out of range.
    """
    if len(data) < 2:
        raise InputError(f"data must have at least 2 bytes, had {len(data)}")
    data_id = int(check_real("data_id", data_id, ge=0, le=0xFFFF))
    message = bytearray(data)
    message[1] = message[1] & 0xF0 | counter % N_COUNTS
    message[0] = crc8(message[1:], data_id)
    return bytes(message)
