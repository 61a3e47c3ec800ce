"""Guards of all iterations and divisions: no result depends on them."""

from __future__ import annotations

import sys

MOST_STEPS = 100  # choice: guard of loops that converge, or end by themselves, in ten or twenty
AT_ONCE = 1_000_000  # choice: numbers of one array on the way to a result; 8 MB, and some such arrays
TINY = sys.float_info.min  # theory: the least normal number, below every size that something is divided by
