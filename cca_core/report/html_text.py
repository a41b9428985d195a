"""Text of any origin as HTML."""

import re
from html import escape

from cca_core.plot.labels import sanitize_text


def html_text(text: str) -> str:
    """Escaped text, with numbers and units on one line."""
    return re.sub(r"(\d) (m/s²|m/s|km/h|m|s)\b", "\\1\N{NO-BREAK SPACE}\\2", escape(sanitize_text(text)))
