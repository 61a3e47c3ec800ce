"""Knows no mechanics: errors, units, files, clocks, work on many items."""

from __future__ import annotations

from .lazy import lazily

TYPE_CHECKING = False
if TYPE_CHECKING:
    from .errors import (
        Estimate,
        InputError,
        JkrError,
        Refusal,
        SolveError,
        Unknown,
        accuracy,
        did_you_mean,
        first_line,
        installs,
        known,
        nearest,
        positive,
        printable,
        writable,
    )
    from .executors import Pool, Progress, completed, executor, in_order, silent
    from .files import (
        as_json,
        atomic,
        beside,
        check_series_target,
        check_target,
        lists,
        make_folder,
        opened,
        packed,
        read_bytes,
        real_path,
        remove_file,
        together,
        write_bytes,
        write_csv,
        write_text,
    )
    from .hdf5 import Dataset, Group, format_of, unit_column
    from .numerics import (
        AT_ONCE,
        DISTRIBUTIONS,
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
        Array,
        Distribution,
        EvenCubic,
        PiecewiseCubic,
        PiecewiseQuintic,
        composite_gauss,
        draw,
        evenly,
        spline_slopes,
        zeros_between,
    )
    from .process import (
        PATIENCE,
        SHARE,
        SILENCE,
        StageClock,
        begin_with_one,
        check_size,
        check_text,
        duration,
        free_memory,
        one_thread,
    )
    from .registry import Key, Registry
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

__getattr__ = lazily(__name__, __file__)
