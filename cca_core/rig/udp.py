"""Datagrams of radio, sensor and telemetry: one address to receive at, others to send to."""

import ipaddress
import socket
import struct
from collections import Counter
from collections.abc import Iterable

from cca_core.errors import InputError
from cca_core.rig.settings import parse_address

_MAX_BYTES = 65_536
_QUEUE_BYTES = 1 << 20  # of the operating system, for some thousand datagrams


class UdpLink:
    """Datagrams that never raise once the link is open; multicast groups are joined.

    Parameters
    ----------
    listen : str, optional
        Address and port at which datagrams are received.
    send_to : iterable of str
        Addresses and ports to which they are sent.

    Attributes
    ----------
    counts : Counter
        Number of datagrams ``"sent"``, ``"not_sent"`` and ``"received"``.

    Raises
    ------
    InputError
        If an address cannot be used.
    """

    def __init__(self, listen: str | None = None, send_to: Iterable[str] = ()) -> None:
        self.counts: Counter[str] = Counter()
        self._targets = [_resolved("send_to", address) for address in send_to]
        own = None if listen is None else _resolved("listen", listen)
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            # multicast stays on this machine: another one is named by its own address
            self._socket.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, 0)
            if own is not None:
                # a full queue refuses the newest: it must hold a cycle of a flood
                self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _QUEUE_BYTES)
                self._bind(*own)
            self._socket.setblocking(False)
        except OSError as error:
            self._socket.close()
            raise InputError(f"listen must be an address of this machine, was {listen!r}: {error}") from None

    def _bind(self, host: str, port: int) -> None:
        is_group = ipaddress.ip_address(host).is_multicast
        if is_group:
            self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        self._socket.bind((host, port))
        if is_group:
            group = struct.pack("4sI", socket.inet_aton(host), socket.INADDR_ANY)
            self._socket.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, group)

    def send(self, data: bytes) -> None:
        """Send a datagram to all addresses.

        Parameters
        ----------
        data : bytes
            Content.
        """
        for target in self._targets:
            try:
                self._socket.sendto(data, target)
                self.counts["sent"] += 1
            except OSError:  # no receiver, no network, or a full buffer
                self.counts["not_sent"] += 1

    def drain(self, limit: int = 2000) -> list[bytes]:
        """Return the datagrams that have arrived, without waiting.

        Parameters
        ----------
        limit : int
            Largest number of datagrams [-]: a flood must not hold the caller.

        Returns
        -------
        datagrams : list of bytes
            In order of arrival.
        """
        found: list[bytes] = []
        while len(found) < limit:
            try:
                found.append(self._socket.recv(_MAX_BYTES))
            except OSError:  # none left; or the answer that a sent one had no receiver
                break
        self.counts["received"] += len(found)
        return found

    def fileno(self) -> int:
        """Return the number of the socket, to wait for it.

        Returns
        -------
        number : int
            File descriptor.
        """
        return self._socket.fileno()

    def close(self) -> None:
        """Close the link."""
        self._socket.close()


def _resolved(name: str, address: str) -> tuple[str, int]:
    host, port = parse_address(name, address)
    try:
        return socket.gethostbyname(host), port
    except OSError:
        raise InputError(f"{name} must name a known host, was {address!r}") from None
