"""Store of rows: exact numbers, one owner, and nothing lost by a kill."""

import os
import signal
import sqlite3
import subprocess
import sys
from pathlib import Path

import pytest

from cca_core.errors import InputError
from cca_core.sim.study.store import Store

ROW = {"value": 0.1 + 0.2, "none": None, "tiny": 5e-324, "name": "a"}


def filled(path: Path, n: int = 3) -> Path:
    with Store(path, "x") as store:
        for i in range(n):
            store.add(i, ROW)
    return path


def test_rows_come_back_exactly_and_in_order(tmp_path: Path) -> None:
    with Store(tmp_path / "a", "x") as store:
        for key in (7, "seven", 1):
            store.add(key, {**ROW, "key": key})
        written = dict(store.rows)
    with Store(tmp_path / "a", "x") as store:
        assert list(store.rows.items()) == list(written.items())
        assert list(store.rows) == [7, "seven", 1]
        assert store.rows[7] == {**ROW, "key": 7}


def test_duplicate_key_raises(tmp_path: Path) -> None:
    with Store(tmp_path / "a", "x") as store:
        store.add(1, ROW)
        with pytest.raises(InputError, match="key"):
            store.add(1, ROW)


@pytest.mark.parametrize("content", [b"hello", b"hello\n" * 500, b"\xff\xfe\n"])
def test_other_file_raises_and_stays(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "a"
    path.write_bytes(content)
    with pytest.raises(InputError, match="path"):
        Store(path, "x")
    assert path.read_bytes() == content


def test_other_database_raises(tmp_path: Path) -> None:
    connection = sqlite3.connect(tmp_path / "a")
    connection.execute("create table other (a)")
    connection.commit()
    connection.close()
    with pytest.raises(InputError, match="path"):
        Store(tmp_path / "a", "x")


def test_truncated_file_raises(tmp_path: Path) -> None:
    path = filled(tmp_path / "a", 60)
    data = path.read_bytes()
    for size in range(100, len(data), 997):
        path.write_bytes(data[:size])
        with pytest.raises(InputError, match="path"):
            Store(path, "x")


def test_missing_folder_raises(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="path"):
        Store(tmp_path / "no" / "a", "x")


def test_other_fingerprint_raises(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"a' belongs to another one; give another file name, or delete"):
        Store(filled(tmp_path / "a"), "y")


def test_second_owner_is_refused(tmp_path: Path) -> None:
    with Store(tmp_path / "a", "x") as store:
        store.add(1, ROW)
        with pytest.raises(InputError, match="locked"):
            Store(tmp_path / "a", "x")
    with Store(tmp_path / "a", "x") as store:
        assert len(store.rows) == 1


WRITER = """
import sys
from cca_core.sim.study.store import Store

with Store(sys.argv[1], "x") as store:
    for i in range(len(store.rows), 10**6):
        store.add(i, {"square": i * i})
        print(i, flush=True)
"""


def test_added_rows_survive_kill(tmp_path: Path) -> None:
    path, confirmed = tmp_path / "a", -1
    for rows in (3, 20, 1, 50):
        command = [sys.executable, "-c", WRITER, str(path)]
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
            assert process.stdout is not None
            for line in process.stdout:
                confirmed = int(line)
                rows -= 1
                if rows == 0:
                    os.kill(process.pid, signal.SIGKILL)
                    break
        with Store(path, "x") as store:
            assert len(store.rows) > confirmed
            assert all(row == {"square": key * key} for key, row in store.rows.items())
