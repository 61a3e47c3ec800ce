"""Numbers that many algorithms share: guards of iterations and divisions, sizes of work, what counts as the same.

No result depends on the guards and sizes, nor, beyond its stated error, on what counts as the same.
"""

from __future__ import annotations

import sys

MOST_STEPS = 100  # choice: guard of loops that converge, or end by themselves, in ten or twenty
MOST_SOLVES = 8  # choice: guard of loops whose every step is a solve; two or three are needed
MOST_CELLS = 100_000_000  # choice: numbers of a table that is read or written, 800 MB
AT_ONCE = 1_000_000  # choice: numbers of one array on the way to a result; 8 MB, and some such arrays
LOOKED_AT = 400  # choice: points of a curve as it is drawn, or among which a zero or the largest value is sought
DRAWN = 4000  # choice: points of curves that a picture tells apart
# choice: of a direction of a record, a base line and a contact of a few rows each; so many steps beside a jump too
FEWEST_ROWS = 20
ROWS = 200  # choice: default number of rows of a curve
TOGETHER = 20  # choice: items that make one task of another process
REMEMBERED = 256  # choice: results of one kind that are kept; more only saves time
SHOWN = 20  # choice: names or rows in a message
SAME = 1e-6  # choice: relative difference of two values that are one: above round-off, below what anyone measures
ROUNDED = 1e-9  # theory: relative, above what a sum of a million numbers loses to round-off, 1e6 epsilon = 2e-10
RESIDUAL_LIMIT = 1e-6  # theory: of check solves; a sound factor leaves round-off, 1e-16 to 1e-12, a wrong one 1
UNSEEN = 1e-4  # choice: relative error that no measurement sees
NOTICEABLE = 1e-3  # choice: relative change from which on it is reported
NO_CLAIM = 1e-3  # of a tolerance, no smaller error is stated; tuned on work along a record, by `make constants`
SETTLED = 1e-13  # theory: a step of logs or of unknowns near 1 that is none: 450 machine epsilons, above round-off
TINY = sys.float_info.min  # theory: the least normal number, below every size that something is divided by
