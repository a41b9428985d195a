"""Write the C of the kernel anew."""

import sys
from pathlib import Path

from cca_core.codegen import TranslationError, translate

FOLDER = Path(__file__).resolve().parents[1] / "kernel"

if __name__ == "__main__":
    try:
        texts = translate(FOLDER)
    except TranslationError as error:
        sys.exit(f"{FOLDER}/{error}")
    for name, text in texts.items():
        (FOLDER / "c" / name).write_text(text, encoding="utf-8")
