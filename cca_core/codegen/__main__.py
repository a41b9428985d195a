"""Write the C of the kernel anew."""

from pathlib import Path

from cca_core.codegen import translate

FOLDER = Path(__file__).resolve().parents[1] / "kernel"

if __name__ == "__main__":
    for name, text in translate(FOLDER).items():
        (FOLDER / "c" / name).write_text(text, encoding="utf-8")
