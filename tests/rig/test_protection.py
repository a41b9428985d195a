"""End-to-end protection: the CRC against another implementation, the check and its states by their rules."""

import random
from importlib import import_module

import pytest

from cca_core import InputError
from cca_core.rig import CheckStatus, LinkState, ProtectedReceiver, ProtectionSettings, protect

DATA_ID = 0x0123


def message(counter: int, *, fill: int = 0x5A, data_id: int = DATA_ID) -> bytes:
    return protect(bytes([0, fill & 0xF0, *[fill] * 6]), data_id, counter)


def receiver(**settings: int) -> ProtectedReceiver:
    """A receiver that has become valid with counters 0 to 4."""
    made = ProtectedReceiver(DATA_ID, ProtectionSettings(**settings))
    for counter in range(5):
        made.check(message(counter))
    assert made.state is LinkState.VALID
    return made


@pytest.mark.requires("e2e")
def test_messages_equal_those_of_other_implementation() -> None:
    oracle = import_module("e2e.p01")
    rng = random.Random(1)
    for _ in range(3000):
        data, data_id, counter = rng.randbytes(rng.randint(2, 64)), rng.randrange(65536), rng.randrange(15)
        message_here = protect(data, data_id, counter)
        theirs = bytearray(data)
        theirs[1] = theirs[1] & 0xF0 | counter
        oracle.e2e_p01_protect(theirs, data_id, increment_counter=False)
        assert message_here == bytes(theirs)
        assert oracle.e2e_p01_check(bytearray(message_here), data_id)


@pytest.mark.requires("e2e")
def test_wrong_messages_equal_those_of_other_implementation() -> None:
    oracle = import_module("e2e.p01")
    rng = random.Random(2)
    for _ in range(3000):
        data = bytearray(message(rng.randrange(15)))
        data[rng.randrange(8)] ^= rng.randrange(256)
        is_good = ProtectedReceiver(DATA_ID).check(data) is not CheckStatus.WRONG_CRC
        assert is_good == (oracle.e2e_p01_check(data, DATA_ID) and data[1] & 15 < 15)


def test_every_error_of_one_or_two_bits_is_detected() -> None:
    good = int.from_bytes(message(3), "big")
    masks = [1 << i for i in range(64)]
    masks += [a | b for a in masks for b in masks if a < b]
    for mask in masks:
        status = ProtectedReceiver(DATA_ID).check((good ^ mask).to_bytes(8, "big"))
        assert status is CheckStatus.WRONG_CRC


def test_message_of_other_data_id_has_wrong_crc() -> None:
    assert receiver().check(message(5, data_id=DATA_ID + 1)) is CheckStatus.WRONG_CRC


@pytest.mark.parametrize("data", [b"", b"\x00", b"\x00\x0f"])
def test_short_or_reserved_message_has_wrong_crc(data: bytes) -> None:
    assert receiver().check(data) is CheckStatus.WRONG_CRC


def test_first_message_is_initial_and_third_makes_link_valid() -> None:
    made = ProtectedReceiver(DATA_ID)
    assert made.state is LinkState.NO_DATA
    assert [made.check(message(k)) for k in (7, 8, 9)] == [
        CheckStatus.INITIAL,
        CheckStatus.OK,
        CheckStatus.OK,
    ]
    assert made.state is LinkState.VALID


def test_repeated_counter_is_not_usable() -> None:
    made = receiver()
    assert made.check(message(4)) is CheckStatus.REPEATED
    assert made.check(message(5)) is CheckStatus.OK


@pytest.mark.parametrize(("n_lost", "status"), [(1, CheckStatus.SOME_LOST), (2, CheckStatus.WRONG_SEQUENCE)])
def test_lost_messages_within_limit_are_accepted(n_lost: int, status: CheckStatus) -> None:
    assert receiver().check(message(5 + n_lost)) is status


def test_cycle_without_message_widens_limit() -> None:
    made = receiver()
    assert made.check(None) is CheckStatus.NO_NEW_DATA
    assert made.check(None) is CheckStatus.NO_NEW_DATA
    assert made.check(message(7)) is CheckStatus.SOME_LOST


def test_jumped_counter_is_confirmed_by_next_messages() -> None:
    made = receiver(sync_messages=2)
    found = [made.check(message(k)) for k in (10, 11, 12, 13)]
    assert found == [CheckStatus.WRONG_SEQUENCE, CheckStatus.SYNC, CheckStatus.SYNC, CheckStatus.OK]


def test_message_gap_is_confirmed_by_next_messages() -> None:
    made = receiver(max_missing=2)
    for _ in range(3):
        made.check(None)
    found = [made.check(message(k)) for k in (8, 9, 10)]
    assert found == [CheckStatus.SYNC, CheckStatus.SYNC, CheckStatus.OK]


def test_wrong_crcs_make_link_invalid_and_good_ones_valid() -> None:
    made = receiver(max_error_valid=3, max_error_invalid=1, min_ok_invalid=3)
    for k in range(4):
        assert made.state is LinkState.VALID
        made.check(message(5 + k)[:-1] + b"\x00")
    assert made.state is LinkState.INVALID
    counter = 9
    while made.state is LinkState.INVALID:
        made.check(message(counter))
        counter += 1
    assert counter - 9 == 10 + 1 - 1 - 1  # until only one wrong CRC is among the last ten


def test_silent_link_becomes_invalid_within_window() -> None:
    made = receiver(window=10)
    cycles = 0
    while made.state is LinkState.VALID:
        made.check(None)
        cycles += 1
    assert cycles == 10


def test_random_messages_are_never_usable_unless_good() -> None:
    """What is accepted has the CRC and a counter that continues, in any order of faults."""
    rng = random.Random(3)
    for _ in range(300):
        made, last, counter = ProtectedReceiver(DATA_ID), None, rng.randrange(15)
        for _ in range(60):
            fault = rng.choice(("none", "none", "none", "crc", "repeat", "jump", "missing", "other"))
            counter += 0 if fault == "repeat" else rng.randint(4, 12) if fault == "jump" else 1
            data = message(counter, data_id=DATA_ID ^ (fault == "other"))
            if fault == "crc":
                data = bytes([data[0] ^ 0x55]) + data[1:]
            status = made.check(None if fault == "missing" else data)
            if status.is_usable:
                assert fault not in ("crc", "missing", "other")
                assert last is not None
                assert counter % 15 != last
            if fault in ("none", "jump", "repeat"):
                last = counter % 15


@pytest.mark.parametrize(
    "settings",
    [{"max_delta": 0}, {"max_delta": 15}, {"window": 0}, {"sync_messages": 1.5}, {"max_missing": -1}],
)
def test_settings_out_of_range_raise(settings: dict[str, float]) -> None:
    with pytest.raises(InputError, match=next(iter(settings))):
        ProtectionSettings(**settings)  # type: ignore[arg-type]


def test_short_data_cannot_be_protected() -> None:
    with pytest.raises(InputError, match="at least 2 bytes"):
        protect(b"\x00", DATA_ID, 0)
