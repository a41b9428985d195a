"""`tests/validate.py`: a file is run and counted, its sources are known, the page shows each result."""

import importlib.metadata
from pathlib import Path

import pytest

pytest.importorskip("matplotlib")

from matplotlib.figure import Figure

from cca_core.sim.study.parameters import ParameterRanges
from cca_core.sim.study.run import simulate_run
from cca_core.sim.study.source import code_of
from cca_core.sim.study.statistics import StudyTable
from cca_core.sim.study.store import Store
from cca_core.sim.study.study import Study
from tests import validate

DIGEST_OF = validate.digest_of


@pytest.fixture(autouse=True)
def other_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(validate, "digest_of", lambda file: f"{hash(file) % 2**48:012x}")  # all take 10 s
    monkeypatch.setattr(validate, "STATE", tmp_path)
    monkeypatch.setattr(validate, "PAGE", tmp_path / "validation.md")


def test_passing_file_is_counted() -> None:
    result = validate.run_file("tests/test_public_api.py")
    assert result["failed"] == 0
    assert result["tests"] > 20


def test_missing_file_fails() -> None:
    assert validate.run_file("tests/test_nothing.py")["failed"] == 1


def test_result_counts_until_sources_change() -> None:
    suite = validate.Suite()
    name = "tests/test_geometry.py"
    row = {"tests": 7, "skipped": 0, "failed": 0, "seconds": 60, "code": suite.files[name]}
    suite.rows[name] = row
    suite.save()
    again = validate.Suite()
    assert again.passed == {name: row}
    assert len(again.missing) == len(again.files) - 1
    again.files[name] = "other sources"
    assert again.passed == {}
    assert again.missing[0] == name  # its time is known


CODE = '"""Text."""\n\nX = 1  # comment\n\n\ndef f() -> int:\n    """Text."""\n    return X\n'


@pytest.mark.parametrize(
    ("new", "same"),
    [
        (CODE.replace("Text.", "Another text."), True),
        (CODE.replace("  # comment", ""), True),
        (CODE.replace("= 1", "= 2"), False),
        (CODE.replace("return X", "return -X"), False),
        (CODE.replace("X = 1", 'X = """Text."""'), False),
        (CODE.replace("    return", "    # comment\n\n    return"), True),
        (CODE.replace('"""Text."""\n', '"""Té # xt.\n\nMore.\n"""; Y = 2\n', 1), False),
    ],
)
def test_comments_and_docstrings_do_not_count(tmp_path: Path, new: str, same: bool) -> None:
    files = tmp_path / "old.py", tmp_path / "new.py"
    for file, text in zip(files, (CODE, new), strict=True):
        file.write_text(text)
    old, other = (validate.digest([file]) for file in files)
    assert (old == other) is same
    assert validate.digest([files[0]], exact=True) != validate.digest([files[1]], exact=True)


@pytest.mark.parametrize(
    ("name", "reads"),
    [
        ("tests/codegen/test_translation.py", True),
        ("tests/codegen/test_project.py", True),
        ("tests/kernel/test_compilers.py", True),
        ("tests/test_style.py", True),
        ("tests/band/test_qp.py", False),
        ("tests/planner/test_work.py", False),
    ],
)
def test_docstrings_count_where_a_test_reads_them(
    name: str, reads: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The translation to C takes over the docstrings of kernels, and refuses some."""
    called = []
    monkeypatch.setattr(validate, "digest", lambda _, exact: called.append(exact) or "")
    DIGEST_OF(validate.ROOT / name)
    assert called == [reads]


def test_code_is_the_same_text_in_each_version_of_python(tmp_path: Path) -> None:
    """A syntax tree is not: its fields and their text differ between Python 3.11 and 3.13."""
    file = tmp_path / "a.py"
    file.write_text(
        CODE + 'class A:\n    x: int\n    """Té # xt."""; y = "# é\\n"  # comment\n\n    # comment\n'
        '    z = f"{y} # "\n    v = """\n\n  # no comment\n"""\n',
        encoding="utf-8",
    )
    assert code_of(file).decode() == (
        "X = 1\ndef f() -> int:\n    return X\n"
        'class A:\n    x: int\n    ; y = "# é\\n"\n    z = f"{y} # "\n    v = """\n\n  # no comment\n"""\n'
    )


def test_only_what_a_file_uses_counts() -> None:
    def used(name: str) -> set[str]:
        files = validate.inputs(validate.ROOT / name)
        return {"/".join(file.relative_to(validate.ROOT).parts[:2]) for file in files}

    band, planner = used("tests/band/test_qp.py"), used("tests/planner/test_work.py")
    assert {"cca_core/band", "cca_core/kernel", "cca_core/errors.py", "tests/conftest.py"} <= band
    assert not {"cca_core/planner", "cca_core/sim", "cca_core/plot"} & band
    assert {"cca_core/planner", "cca_core/band", "tests/support"} <= planner
    assert {"cca_core/cli", "cca_core/sim", "cca_core/report"} <= used("tests/cli/test_drive.py")


def test_chosen_folder_alone_is_missing() -> None:
    assert all(name.startswith("tests/band/") for name in validate.Suite(("tests/band/",)).missing)


def test_unknown_part_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        validate.main(["nothing"])
    assert "no such part: nothing" in capsys.readouterr().err


def test_page_shows_complete_and_partial_studies() -> None:
    row = simulate_run(ParameterRanges(scenario="eebl"), validate.SEED, 0)
    row |= {"v2v_collided_with": "red", "avoiding_action": "", "t_hazard": 2.0}
    table = StudyTable(scenario="eebl", rows=(row, {**row, "index": 1, "avoiding_action": "brake"}))
    lines = validate.study_lines({"eebl": (1, table), "ima": (12, None)})
    assert any(line.startswith("| eebl | 2 | 1 | 1: 100.00%") for line in lines)
    assert "| ima | not complete | 12 of 2000 | | | | | |" in lines
    first, second = validate.collision_lines([table], [])[-2:]
    assert first.startswith("| eebl | 0 | red |")
    assert "first message of the hazard at 2.00 s" in first
    assert "**avoidable** (brake)" in second


def test_other_clone_resumes_from_the_page(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(validate, "commit", lambda: "abcdef0")
    suite = validate.Suite()
    suite.rows = {
        name: {"tests": 7, "skipped": 1, "failed": 0, "seconds": 60, "code": code}
        for name, code in (
            ("tests/test_ncap.py", suite.files["tests/test_ncap.py"]),
            ("tests/test_serial.py", "0" * 12),
        )
    }
    name = "tests/test_repr.py"
    suite.rows[name] = {"tests": 9, "skipped": 0, "failed": 2, "seconds": 5, "code": suite.files[name]}
    row = simulate_run(ParameterRanges(scenario="eebl"), validate.SEED, 0)
    safe = {**row, "v2v_collided_with": "", "avoiding_action": "brake"}
    late = {**row, "index": 2000, "v2v_collided_with": "red", "avoiding_action": "", "t_hazard": 2.0}
    rows = (*({**safe, "index": i} for i in range(2000)), late)
    table = StudyTable(scenario="eebl", rows=rows)
    with monkeypatch.context() as context:
        context.setattr(validate, "progress_of", lambda name: (2000, table) if name == "eebl" else (3, None))
        context.setattr(validate, "plot_study", lambda *_, **__: Figure())
        validate.write_page(suite)
    assert validate.figure_of("eebl").exists()
    page = validate.PAGE.read_text(encoding="utf-8")
    assert "study_eebl.png" in page
    again = validate.Suite()
    assert again.passed.keys() == {"tests/test_ncap.py"}
    assert again.failed == {name: suite.rows[name]}
    assert again.missing[0] == name
    assert again.passed["tests/test_ncap.py"] == suite.rows["tests/test_ncap.py"]
    assert validate.progress_of("eebl") == (2000, None)
    assert validate.progress_of("ima") == (0, None)
    assert validate.drive_study("eebl") == []
    validate.write_page(again)
    assert validate.PAGE.read_text(encoding="utf-8") == page.replace("3 of 2000", "0 of 2000")
    monkeypatch.setattr(Study, "fingerprint", "other sources")
    assert validate.progress_of("eebl") == (0, None)


def test_older_result_does_not_hide_that_of_the_page(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(validate, "commit", lambda: "abcdef0")
    suite = validate.Suite()
    name = "tests/test_ncap.py"
    row = {"tests": 2, "skipped": 0, "failed": 0, "seconds": 1, "code": suite.files[name]}
    suite.rows = {name: row}
    validate.write_page(suite)
    suite.rows = {name: row | {"code": "0" * 12, "failed": 1}}
    suite.save()
    assert validate.Suite().passed == {name: row}


def test_page_counts_files_without_result() -> None:
    suite = validate.Suite()
    row = {"tests": 2, "skipped": 0, "failed": 0, "seconds": 1}
    suite.rows = {name: row | {"code": code} for name, code in suite.files.items()}
    n = len(suite.files)
    assert validate.summary_lines(suite) == [
        f"All {n} test files ({2 * n} tests) have passed with the present code."
    ]
    suite.rows |= {"tests/test_ncap.py": suite.rows["tests/test_ncap.py"] | {"failed": 1}}
    del suite.rows["tests/test_serial.py"]
    first, second, *_, last = validate.summary_lines(suite)
    assert first.startswith(f"{n - 2} of {n} test files")
    assert second == "Files without a result for this code yet: 1."
    assert last.startswith("- `tests/test_ncap.py`: 1 of 2 tests failed")


def test_parts_may_run_at_the_same_time(monkeypatch: pytest.MonkeyPatch) -> None:
    result = {"tests": 7, "skipped": 0, "failed": 0, "seconds": 60}
    name, other = "tests/test_geometry.py", validate.Suite()

    def run_file(_: str) -> dict[str, int]:
        other.rows["tests/test_ncap.py"] = result | {"code": "a"}
        other.save()
        return result

    monkeypatch.setattr(validate, "run_file", run_file)
    assert validate.Suite((name,)).run() == []
    assert validate.Suite().rows.keys() == {name, "tests/test_ncap.py"}
    study, path, _ = validate.study_of("eebl")
    with Store(path, study.fingerprint):
        assert validate.progress_of("eebl") == (0, None)
    assert validate.progress_of("eebl") == (0, None)


def test_scripts_of_the_tests_hide_no_installed_module() -> None:
    """Python looks first into the folder of a script: a file of that name would be imported instead."""
    installed = importlib.metadata.packages_distributions()
    assert not {file.stem for file in validate.TESTS.glob("*.py")} & installed.keys()
