"""Three force curves of one relaxing specimen, at three speeds with a hold: ``cases/measured/relaxing-*.csv``.

By equations that share no code with what fits them (``tests/adhesive_curves.py``): a tip of 100 nm on an elastomer with
E*(0) = 100 MPa, of which 40 % are left with a time of 30 ms, w = 30 mJ/m^2 over 0.5 nm, a cantilever of 2 N/m, 1 % of
noise of the pull-off force, base lines with offset and tilt. ``python -m studies.relaxing_speeds FOLDER`` writes them.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from adhesive_curves import cycle, sampled, solid  # type: ignore[import-not-found]

R, E, W, RANGE, STIFFNESS = 100e-9, 100e6, 0.03, 0.5e-9, 2.0  # choice: a sharp tip on an elastomer
RATIO, TIME, NOISE, ROWS = 0.4, 0.03, 0.01, 500  # choice: noise over the pull-off force, rows in contact
SPEEDS = {"slow": 0.1e-6, "middle": 0.5e-6, "fast": 2.5e-6}  # choice: of the piezo [m/s]
PUSHED, HELD = 12e-9, 0.06  # choice: way beyond first touch [m], and the hold [s]


def main(folder: Path) -> None:
    """Write the three files."""
    note = "# A synthetic measurement: tip of 100 nm on an elastomer that relaxes, hold of 60 ms"
    w, stress, k = W / (E * R), W / RANGE / E, STIFFNESS / (E * R)
    for i, (name, speed) in enumerate(SPEEDS.items()):
        v = speed / R
        far = 1.2e-7 / R
        t = np.cumsum([0.0, (RANGE / R + PUSHED / R) / v, HELD, (PUSHED / R + far) / v])
        z = (-RANGE / R, PUSHED / R, PUSHED / R, -far)
        made = cycle(w, stress, solid(RATIO, TIME), tuple(zip(t.tolist(), z, strict=True)), k)
        lasting = made.lost - made.begun
        rows = made.begun + lasting / ROWS * np.arange(-ROWS // 3, ROWS + ROWS // 2)
        before, behind = t[0] - 9 * lasting, t[-1] + 9 * lasting
        places = np.interp(rows, [before, *t, behind], [z[0] - 9 * lasting * v, *z, z[-1] - 9 * lasting * v])
        P = sampled(made, rows)
        pulled = -P.min()
        P = P + NOISE * pulled * np.random.default_rng(i).standard_normal(rows.size) + pulled * (0.3 + 0.01 * places)
        table = np.column_stack([rows - rows[0], R * (places - places[0]), E * R**2 * P])

        with (folder / f"relaxing-{name}.csv").open("w") as file:
            file.write(f"{note}, {speed * 1e6:g} um/s\nt_s,z_m,P_N\n")
            np.savetxt(file, table, "%.6g", ",")
        print(f"{name}: contact {lasting:.3g} s, pull-off {E * R**2 * pulled:.4g} N")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
