"""`cca decode`."""

import csv
import struct
from pathlib import Path

import pytest

from cca_core.cli import main
from cca_core.v2x import Bsm, encode_bsm


def message(i: int, sender: str = "00c0ffee", **content: object) -> bytes:
    values = {
        "msg_count": i, "id": sender, "sec_mark": 57.0 + 0.1 * i, "latitude_deg": 41.3 + 1e-5 * i,
        "longitude_deg": -105.6, "speed": 11.13, "psi": 1.5708, "a_x": 0.0, "length": 4.5, "width": 1.8,
    }  # fmt: skip
    return encode_bsm(Bsm(**(values | content)))  # type: ignore[arg-type]


def decode(file: Path, capsys: pytest.CaptureFixture[str], *options: str) -> list[str]:
    assert main(["decode", str(file), *options]) == 0
    return capsys.readouterr().out.splitlines()


def test_each_message_is_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    braking = message(2, a_x=-5.0, events=frozenset({"hard_braking"}))
    file = tmp_path / "log.hex"
    file.write_text("\n".join(data.hex() for data in (message(0), message(1), braking)))
    head, *lines, total, accepted = decode(file, capsys)
    assert head.split()[:3] == ["time", "[s]", "sender"]
    assert lines[0].split() == ["0.000", "00c0ffee", "41.30000", "-105.60000", "11.12", "0.0", "0.00"]
    assert lines[2].split()[-2:] == ["-5.00", "hard_braking"]
    assert total == "3 entries in 0.2 s, 3 Basic Safety Messages of 1 sender"
    assert accepted == "accepted: 3 (updated 2, new 1)"


def test_dropped_entries_state_the_reason(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    other = "0013" + "02" + "0000"  # SPaT
    entries = [message(0).hex(), message(0).hex(), "zz", message(1).hex()[:40], other, message(2).hex()]
    file = tmp_path / "log.hex"
    file.write_text("\n".join(entries))
    lines = decode(file, capsys)
    assert lines[2].endswith("dropped: duplicate")
    assert "dropped, unreadable: data must be hexadecimal digits" in lines[3]
    assert "dropped, unreadable: data must hold 37 bytes of message, had 17" in lines[4]
    assert lines[5].endswith("SPaT, not decoded")
    assert lines[-3] == "dropped: 3 (unreadable 2, duplicate 1)"
    assert lines[-2] == "others: 1 (SPaT 1)"
    assert lines[-1].startswith("first unreadable entry, at 0.000 s: data must be hexadecimal digits")


def test_quiet_prints_counts_alone(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "log.hex"
    file.write_text(message(0).hex())
    assert len(decode(file, capsys, "--quiet")) == 2


def test_table_without_a_file_is_the_output(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file, table = tmp_path / "log.hex", tmp_path / "log.csv"
    file.write_text("\n".join(message(i).hex() for i in range(3)))
    assert main(["decode", str(file), "--csv", str(table)]) == 0
    capsys.readouterr()
    assert main(["decode", str(file), "--csv"]) == 0
    assert capsys.readouterr().out == table.read_text()


def test_table_holds_every_field(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file, table = tmp_path / "log.hex", tmp_path / "log.csv"
    file.write_text("\n".join([message(0).hex(), "00", message(1, events=frozenset({"flat_tire"})).hex()]))
    decode(file, capsys, "--csv", str(table))
    rows = list(csv.DictReader(table.read_text(encoding="utf-8").splitlines()))
    assert [row["result"] for row in rows] == ["new", "unreadable", "updated"]
    assert float(rows[0]["psi"]) == pytest.approx(1.5708, abs=3e-4)
    assert float(rows[2]["latitude_deg"]) == pytest.approx(41.30001)
    assert rows[2]["events"] == "flat_tire"
    assert rows[1]["id"] == ""
    assert "accuracy.semi_major" in rows[0]


def pcap(packets: list[tuple[float, bytes]], link: int, order: str = "<") -> bytes:
    head = struct.pack(f"{order}IHHiIII", 0xA1B2C3D4, 2, 4, 0, 0, 65535, link)
    return head + b"".join(
        struct.pack(f"{order}IIII", int(t), round(t % 1 * 1e6), len(data), len(data)) + data
        for t, data in packets
    )


def pcapng(packets: list[tuple[float, bytes]], link: int) -> bytes:
    def block(kind: int, body: bytes) -> bytes:
        body += bytes(-len(body) % 4)
        return struct.pack("<II", kind, len(body) + 12) + body + struct.pack("<I", len(body) + 12)

    nanoseconds = struct.pack("<HHB3xHH", 9, 1, 9, 0, 0)
    blocks = block(0x0A0D0D0A, struct.pack("<IHHq", 0x1A2B3C4D, 1, 0, -1))
    blocks += block(1, struct.pack("<HHI", link, 0, 65535) + nanoseconds)
    for t, data in packets:
        ticks = round(t * 1e9)
        head = struct.pack("<IIIII", 0, ticks >> 32, ticks & 0xFFFFFFFF, len(data), len(data))
        blocks += block(6, head + data)
    return blocks


def udp(data: bytes) -> bytes:
    ports = struct.pack(">HHHH", 5000, 5001, 8 + len(data), 0)
    ip = struct.pack(">BBHHHBBH4s4s", 0x45, 0, 28 + len(data), 0, 0, 64, 17, 0, bytes(4), bytes(4))
    return ip + ports + data


def wsmp(data: bytes) -> bytes:
    return b"\x03\x00\x20" + bytes([len(data)]) + data


MACS = bytes(12)
SNAP = b"\xaa\xaa\x03\0\0\0\x88\xdc"
RADIOTAP = b"\0\0\x08\0" + bytes(4)
LINKS = {
    "ethernet-wsmp": (1, lambda data: MACS + b"\x88\xdc" + wsmp(data)),
    "ethernet-udp": (1, lambda data: MACS + b"\x08\x00" + udp(data)),
    "ethernet-vlan-udp": (1, lambda data: MACS + b"\x81\x00\x00\x07\x08\x00" + udp(data)),
    "wifi": (105, lambda data: b"\x88" + bytes(25) + SNAP + wsmp(data)),
    "radiotap": (127, lambda data: RADIOTAP + b"\x08" + bytes(23) + SNAP + wsmp(data)),
    "linux": (113, lambda data: bytes(14) + b"\x08\x00" + udp(data)),
    "raw-ip": (101, udp),
    "bare": (147, lambda data: data),
}


@pytest.mark.parametrize("form", ["pcap", "pcap-big-endian", "pcapng"])
@pytest.mark.parametrize("link", LINKS)
def test_captures_are_read(link: str, form: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    number, wrap = LINKS[link]
    packets = [(1_700_000_000.25 + 0.1 * i, wrap(message(i))) for i in range(5)]
    file = tmp_path / "log.pcap"
    file.write_bytes({
        "pcap": pcap(packets, number), "pcap-big-endian": pcap(packets, number, ">"),
        "pcapng": pcapng(packets, number),
    }[form])  # fmt: skip
    lines = decode(file, capsys)
    assert [float(line.split()[0]) for line in lines[1:6]] == pytest.approx([0.0, 0.1, 0.2, 0.3, 0.4])
    assert lines[-1] == "accepted: 5 (updated 4, new 1)"


@pytest.mark.parametrize("make", [pcap, pcapng])
def test_cut_captures_never_raise(make: object, tmp_path: Path) -> None:
    whole = make([(1.0, message(0)), (1.1, message(1))], 147)  # type: ignore[operator]
    file = tmp_path / "log.pcap"
    for end in range(len(whole)):
        file.write_bytes(whole[:end])
        assert main(["decode", str(file)]) in (0, 2)


@pytest.mark.parametrize("line", ["this is not a message", "hello world", "abc,def", "2.5 zz", "<?xml?>"])
def test_line_that_is_no_message_is_counted(
    line: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "log.txt"
    file.write_text("\n".join([message(0).hex(), line, message(1).hex()]))
    lines = decode(file, capsys)
    assert "accepted: 2 (new 1, updated 1)" in lines
    assert any("unreadable 1" in each for each in lines)


def test_log_without_messages_has_code_2(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "letter.txt"
    file.write_text("Dear reader,\nthis is no log.\n")
    assert main(["decode", str(file)]) == 2
    output = capsys.readouterr()
    assert output.out == ""
    assert output.err.startswith("cca decode: ")


def test_bare_messages_one_after_another(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "log.uper"
    file.write_bytes(b"".join(message(i) for i in range(4)))
    assert decode(file, capsys)[-1] == "accepted: 4 (updated 3, new 1)"
