"""Knows no mechanics: errors, units, files, clocks, work on many items."""

from __future__ import annotations

from .lazy import lazily

TYPE_CHECKING = False
if TYPE_CHECKING:
    from .allowance import allowance_of, most_text
    from .arrays import Array, evenly
    from .clock import PATIENCE, SILENCE, StageClock, duration
    from .cubic import EvenCubic, PiecewiseCubic, PiecewiseQuintic, spline_slopes, zeros_between
    from .draws import DISTRIBUTIONS, Distribution, draw
    from .errors import (
        InputError,
        JkrError,
        Refusal,
        SolveError,
        did_you_mean,
        first_line,
        nearest,
        positive,
        printable,
        writable,
    )
    from .executors import Pool, Progress, completed, executor, in_order, silent
    from .files import (
        atomic,
        beside,
        check_series_target,
        check_target,
        make_folder,
        opened,
        packed,
        read_bytes,
        real_path,
        remove_file,
        together,
        write_bytes,
        write_text,
    )
    from .hdf5 import Dataset, Group, format_of, tree_of, unit_column
    from .installing import installs
    from .iteration import (
        AT_ONCE,
        DRAWN,
        FEWEST_ROWS,
        LOOKED_AT,
        MOST_CELLS,
        MOST_SOLVES,
        MOST_STEPS,
        NO_CLAIM,
        NOTICEABLE,
        REMEMBERED,
        RESIDUAL_LIMIT,
        ROUNDED,
        ROWS,
        SAME,
        SETTLED,
        SHOWN,
        TINY,
        TOGETHER,
        UNSEEN,
    )
    from .memory import SHARE, free_memory
    from .quadrature import composite_gauss
    from .registry import Key, Registry
    from .table import as_json, lists, write_csv
    from .threads import begin_with_one, one_thread
    from .units import (
        LARGEST_SI,
        SI,
        UNITS,
        AnyLength,
        Length,
        Modulus,
        Ranged,
        check_ranges,
        decades,
        doubtful_modulus,
        doubtful_work,
        implausible_work,
        parse,
        ranges_of,
        reached,
        scale,
        show,
    )
    from .unknown import Estimate, Unknown, accuracy, known

__getattr__ = lazily(__name__, __file__)
