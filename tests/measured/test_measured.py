"""Measured curves: the same curve in many guises, conventions, zero points, and whole lines for what is wrong."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from jkrcli.base.errors import InputError
from jkrcli.measured import files as measured
from jkrcli.measured.curve import Curve, Reading
from jkrcli.measured.segmentation import with_zero_points

MEND = ": correct it, or put # before it"
A = np.array([1.0, 2.0, 3.0, 2.5]) * 1e-5
DELTA = np.array([-5e-7, 1e-6, 3e-6, 2e-6])
P = np.array([-1e-6, 2e-6, 8e-6, 3e-6])
T = np.array([0.0, 0.5, 1.0, 2.0])
WORDS = ("approach", "approach", "retract", "retract")


def rows(*columns: np.ndarray | tuple[str, ...], mark: str = ",", decimal: str = ".") -> str:
    def cell(value: object) -> str:
        return value if isinstance(value, str) else format(value, ".17e").replace(".", decimal)

    return "".join(mark.join(map(cell, row)) + "\n" for row in zip(*columns, strict=True))


GUISES = {
    "names and units of our own": ("t_s,a_m,delta_m,P_N,segment\n" + rows(T, A, DELTA, P, WORDS), Reading()),
    "semicolons, decimal comma, comments, a line of units, byte order mark": (
        "\ufeff# made by a machine\nTime;Radius;Indentation;Force;Phase\nms;µm;nm;uN;-\n"
        + rows(T * 1e3, A * 1e6, DELTA * 1e9, P * 1e6, ("Loading", "extend", "unloading", "Retrace"), mark=";",
               decimal=","),
        Reading(),
    ),
    "tabs, no header: columns and units by flags": (
        rows(P * 1e9, WORDS, DELTA * 1e6, A, T, mark="\t"),
        Reading(columns={"P": "1", "segment": "2", "delta": "3", "a": "4", "t": "5"},
                units={"P": "nN", "delta": "um", "a": "m", "t": "s"}),
    ),
    "blanks, names of another tongue, codes for segments, projected area": (
        "# Zeit (s)  Kraft (mN)  Weg (mm)  Fl (um^2)  Ast\n"
        + rows(T, P * 1e3, DELTA * 1e3, np.pi * A**2 * 1e12, ("0", "0", "1", "1"), mark="  "),
        Reading(columns={"t": "Zeit", "P": "Kraft", "delta": "Weg", "area": "Fl", "segment": "Ast"}),
    ),
    "contact diameter, minus signs of a typesetter": (
        ("time_s,diameter (um),delta_um,P_mN,phase\n" + rows(T, 2 * A * 1e6, DELTA * 1e6, P * 1e3, WORDS))
        .replace(",-", ",\u2212").replace("e-", "e\u2212"),
        Reading(),
    ),
    "signs turned, zero points elsewhere, an instrument that gives way": (
        "t (s),height (um),P (N),a (m),segment\n" + rows(T, -(DELTA + P / 5.0 + 7e-6) * 1e6, -P + 1e-3, A, WORDS),
        Reading(columns={"delta": "height"}, flip=frozenset({"P", "delta"}), zero={"delta": 7e-6, "P": -1e-3},
                stiffness=5.0),
    ),
}  # fmt: skip


@pytest.mark.parametrize("guise", GUISES)
def test_one_curve_in_many_guises(tmp_path: Path, guise: str) -> None:
    text, reading = GUISES[guise]
    path = tmp_path / "m.csv"
    path.write_text(text, encoding="utf-8")
    (curve,) = measured.read(path, reading)
    assert (curve.name, curve.where, curve.measured) == ("m", str(path), ("a", "delta", "P", "t"))
    assert tuple(curve.segment) == WORDS
    for name, expected in (("a", A), ("delta", DELTA), ("P", P), ("t", T)):
        # Zero points of 1 mN under loads of 1 uN cost three digits.
        np.testing.assert_allclose(getattr(curve, name), expected, rtol=5e-13, atol=0)  # 8e-14 measured


def test_columns_of_curves_and_of_an_indenter(tmp_path: Path) -> None:
    path = tmp_path / "map.tsv"
    path.write_text("curve\tdelta_nm\tP_nN\n" + "".join(f"{'cab'[i % 3]}\t{i}\t{10 * i}\n" for i in range(12)))
    curves = measured.read(path)
    assert [curve.name for curve in curves] == ["c", "a", "b"]
    np.testing.assert_allclose(curves[1].P, np.array([10, 40, 70, 100]) * 1e-9, rtol=1e-14)
    assert curves[1].where == f'{path}: curve "a"'
    assert curves[1].segment is None
    path = tmp_path / "m.csv"
    path.write_text("delta_um,P_nN,diameter_mm\n1,1,5\n2,3,5\n3,5,5\n")
    assert measured.read(path)[0].measured == ("delta", "P")


def test_a_bad_curve_does_not_cost_the_others(tmp_path: Path) -> None:
    path = tmp_path / "m.csv"
    table = [f"{name},{i},{i}" for name in ("one", "two", "three") for i in range(4)]
    table[5] = "two,nan,1"
    path.write_text("curve,delta_nm,P_nN\n" + "\n".join([*table, "four,1,1"]) + "\n")
    found = list(measured.each(path))
    assert [item.name for item in found if isinstance(item, Curve)] == ["one", "three"]
    with pytest.raises(InputError) as caught:
        measured.read(path)
    assert list(caught.value.lines) == [str(item) for item in found if isinstance(item, InputError)] == [
        f'{path}: curve "two": line 7: displacement must be finite, got nan (SI)',
        f'{path}: curve "four": holds 1 row (line 14), at least 3 are needed',
    ]  # fmt: skip


@settings(deadline=None, max_examples=40)
@given(
    table=st.lists(st.tuples(*[st.floats(-1e3, 1e3, allow_subnormal=False)] * 3), min_size=3, max_size=8),
    decimal=st.sampled_from([".", ","]),
)
def test_numbers_come_back_to_the_last_bit(
    tmp_path_factory: pytest.TempPathFactory, table: list[tuple[float, ...]], decimal: str
) -> None:
    """With a decimal point by numpy's reader, with a comma by our own: the same numbers."""
    path = tmp_path_factory.mktemp("t") / "m.csv"
    text = "".join(";".join(map(repr, row)) + "\n" for row in table).replace(".", decimal)
    path.write_text("delta_m;P_N;other\n" + text)
    (curve,) = measured.read(path, Reading(separator="semicolon", decimal=decimal))
    assert curve.delta.tolist() == [row[0] for row in table]
    assert curve.P.tolist() == [row[1] for row in table]


# ---------------------------------------------------------------------- what is wrong
GOOD = "delta_nm,P_nN\n1,1\n2,2\n3,3\n"
WRONG = [
    (
        GOOD,
        Reading(columns={"P": "P_n"}),
        'no single column "P_n" for P, did you mean "P"? (columns: 1 "delta_nm", 2 "P',
    ),
    ("x,y\n1,1\n2,2\n3,3\n", Reading(), "are needed, recognised: none; say which columns they are"),
    ("delta_nm,P_nN,P_nN\n1,1,1\n2,2,3\n3,3,3\n", Reading(), "2 columns are recognised as the load: say which"),
    ("delta,P_nN\n1,1\n2,2\n3,3\n", Reading(), '"delta" (displacement) names no unit: give --unit delta=um'),
    ("delta_nm,P (Pa)\n1,1\n2,2\n3,3\n", Reading(), 'the unit must be one of load, such as mN, got "Pa"'),
    (GOOD, Reading(units={"Load": "nN"}), 'no single column "Load" for --unit Load=nN'),
    ("piezo (nm),deflection\n1,1\n2,2\n3,3\n", Reading(stiffness=0.1), 'no unit: give --unit "deflection=nm", or V'),
    ("1 1 1\n2 2 2\n3 3 3\n", Reading(), "(columns: 1, 2, 3); or --format afm"),
    (
        "delta_nm;P_nN;x\n1;1;1\n1;1;1\n2;N/A;1\n2;N/A;1\n3;1;1\n",
        Reading(),
        'line 5 must hold 3 numbers, got "2;N/A;1"',
    ),
    ("delta_nm;P_nN;x\n" + "1;none;1\n" * 3, Reading(), 'holds text, not numbers: line 2 has "none"'),
    (GOOD + "Block 2\n4,4\n", Reading(), 'line 5 must hold 2 numbers, got "Block 2": remove it'),
    (GOOD + "delta_nm,P_nN\n4,4\n", Reading(), 'line 5 must hold 2 numbers, got "delta_nm,P_nN"' + MEND),
    (GOOD, Reading(units={"t": "s"}), "--unit t=s has no column to belong to: give --column t=NAME"),
    (GOOD, Reading(columns={"P": "1"}, units={}), "one column cannot be two quantities, got P = column 1"),
    ("delta_nm,P_nN\n1,1\n2,2\n", Reading(), "holds 2 rows (lines 2, 3), at least 3 are needed"),
    ("delta_nm,P_nN\n", Reading(), "holds no row of at least 2 numbers; give --separator and --decimal"),
    (GOOD + "4,nan\n", Reading(), "line 5: load must be finite, got nan (SI)"),
    (GOOD + "4\n", Reading(), 'line 5 must hold 2 numbers, got "4"' + MEND),
    ("delta_nm,P_nN,segment\n1,1,up\n2,2,up\n3,?,up\n", Reading(), "line 4 must hold 2 numbers and 1 words"),
    ("a_um,P_nN\n1,1\n-2,2\n3,3\n", Reading(), "line 3: contact radius must be finite and >= 0, got -2e-06 (SI)"),
    ("t_s,delta_nm,P_nN\n0,1,1\n2,2,2\n1,3,3\n", Reading(), "time must not run back, it falls from 2 to 1 s"),
    ("a_um,P_nN\n1,1\n2,2\n3,3\n", Reading(flip=frozenset({"delta"})), "holds no delta to flip or to set to zero"),
    ("a_um,delta_nm\n1,1\n2,2\n3,3\n", Reading(stiffness=1.0), "holds no load: the instrument's deflection"),
]


@pytest.mark.parametrize(("text", "reading", "said"), WRONG)
def test_mistakes_are_told_in_one_line(tmp_path: Path, text: str, reading: Reading, said: str) -> None:
    (path := tmp_path / "m.csv").write_text(text)
    with pytest.raises(InputError) as caught:
        measured.read(path, reading)
    assert said in str(caught.value)
    assert all(line.startswith(f"{path}: ") for line in caught.value.lines)


@pytest.mark.parametrize(("columns", "message"), [
    ({"t": T}, "c: holds none of a, delta, P"), ({"P": np.array([1.0, np.inf])}, "c: P[1] is not finite"),
    ({"a": A, "P": P[1:]}, "c: all columns must have the same length, got {'a': 4, 'P': 3}"),
    ({"a": A[None]}, "c: a: must be one-dimensional, got shape (1, 4)"),
])  # fmt: skip
def test_a_curve_is_checked_when_it_is_made(columns: dict[str, np.ndarray], message: str) -> None:
    with pytest.raises(InputError) as caught:
        Curve("c", **columns)
    assert str(caught.value) == message


# ---------------------------------------------------------------------- zero points
def recorded(noise: float = 0.0, seed: int = 0) -> Curve:
    """An approach with a jump into contact of -3 nN at 5.0 um, stiffening to 40 nN at 6 um, and back."""
    z = np.linspace(0, 6e-6, 1201)
    depth = np.maximum(z - 5e-6, 0)
    load = np.where(depth > 0, -3e-9 + 4.3e-8 * (depth / 1e-6) ** 1.5, 0.0)
    drift = 2e-9 + 1e-3 * z
    P = load + drift + np.random.default_rng(seed).normal(0, noise, z.size) if noise else load + drift
    return Curve("c", delta=np.append(z, z[::-1]), P=np.append(P, P[::-1]))


@pytest.mark.parametrize("noise", [0.0, 2e-10])
def test_baseline_tilt_and_first_touch_are_found(noise: float) -> None:
    raw = recorded(noise)
    found = with_zero_points(raw)
    # Steps are 5 nm wide: half of one where noise is below the jump.
    np.testing.assert_allclose(raw.delta - found.delta, 5e-6, atol=2.6e-9)  # m
    # The line's error at its far end, of 1000 rows of noise: 2 sigma/sqrt(1000)
    np.testing.assert_allclose(found.P.max(), 4e-8, atol=4 * noise + 1e-15)  # N
    assert found.flags[0].startswith("contact point and force offset estimated from 99")
    tilt = float(found.flags[0].removesuffix(" N/m").rsplit(" ", 1)[1])
    np.testing.assert_allclose(tilt, 1e-3, atol=3 * noise / 1.4e-6 / 1000**0.5)  # N/m: 3 sigma, z spreads by 1.4 um


def test_zero_points_need_a_free_approach() -> None:
    raw = recorded()
    for curve, said in (
        (Curve("c", P=raw.P), "a force curve needs displacement and load, the file has P"),
        (raw.rows(slice(0, 900)), "the load of the approach never leaves its baseline: no contact was made"),
        (raw.rows(slice(990, 1400)), "the approach has no free part to estimate contact point"),
        (raw.rows(slice(1201, None)), "has no approach: contact point and force offset cannot be estimated"),
        (replace(raw.rows(slice(0, 1201)), segment=np.full(1201, "up")), r"has no approach \(segments: up\)"),
    ):
        with pytest.raises(InputError, match=f"^c: {said}"):
            with_zero_points(curve)
    both = with_zero_points(replace(raw, segment=np.full(len(raw), "up")))  # what turns back holds both directions
    assert both.flags == with_zero_points(raw).flags
