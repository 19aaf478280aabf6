"""What the site says of the files that come out."""

from __future__ import annotations

import sys
from pathlib import Path

DOCS = Path(__file__).parents[1] / "docs"
sys.path.insert(0, str(DOCS))

from extension import reference, results, texts  # noqa: E402
from extension.results import undescribed  # noqa: E402

__all__ = ["DOCS", "reference", "results", "texts", "undescribed"]
