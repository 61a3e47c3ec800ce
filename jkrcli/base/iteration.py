"""Guards of all iterations and divisions: no result depends on them."""

from __future__ import annotations

import sys

MOST_STEPS = 100  # choice: guard of loops that converge, or end by themselves, in ten or twenty
TINY = sys.float_info.min  # theory: the least normal number, below every size that something is divided by
