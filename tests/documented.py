"""What the site says of the files that come out."""

from __future__ import annotations

import re
import sys
from pathlib import Path

DOCS = Path(__file__).parents[1] / "docs"
sys.path.insert(0, str(DOCS))

from extension import kept, reference, results, texts  # noqa: E402
from extension.results import undescribed  # noqa: E402

__all__ = ["DOCS", "blocks", "kept", "reference", "results", "texts", "undescribed"]


def blocks(text: str, *languages: str) -> list[str]:
    """The blocks of a Markdown text that are shown and not run when the site is built."""
    found = re.findall(r"^```(\w+)\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)
    return [block for language, block in found if language in languages]
