"""Running text of pages and docstrings, cut into sentences."""

import re
from collections.abc import Iterator

_BLOCKS = re.compile(r"(?ms)^(```|~~~|:::|\$\$).*?^\1")
_LINKS = re.compile(r"\[([^\]]*)\](?:\([^)]*\)|\[[^\]]*\])")
_INLINE = re.compile(r"``[^`]+``|\{[\w:]+\}`[^`]*`|:[\w:]+:`[^`]*`|`[^`]*`|\$[^$]*\$|https?://\S+|<[^>]*>")
_NO_PROSE = re.compile(r"\s*(\||#|\(|:|\[\d+\] |\.\. )")  # tables, headings, labels, options, references


def prose(text: str) -> str:
    """Running text of a page: no code, tables, formulas, headings or references; inline code is one word."""
    text = _BLOCKS.sub("\n\n", text)
    text = _INLINE.sub(" x ", _LINKS.sub(r"\1", re.sub(r"!\[[^\]]*\]\([^)]*\)", "", text)))
    return "\n".join("" if _NO_PROSE.match(line) else line for line in text.split("\n"))


def sentences(text: str) -> Iterator[str]:
    """Sentences of paragraphs and list items."""
    for paragraph in re.split(r"\n\s*\n|\n\s*(?:[-*]|\d+\.)\s", text):
        yield from re.split(r"(?<=[.!?])\s", " ".join(paragraph.split()))


def count_words(sentence: str) -> int:
    """Words of a sentence; signs alone do not count."""
    return sum(any(c.isalnum() for c in word) for word in sentence.split())
