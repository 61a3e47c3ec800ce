"""The comparison of what users get with that of another commit: no word hides a number, no list holds elsewhere."""

import json
import math
import tomllib

import pytest

from studies.golden import MASKS, MEANT, Meant, deviations, differences, numbers

NONE = Meant({})
LISTED = Meant({
    "words": {"*.txt": "new words"}, "files": {"old/*": "renamed"},
    "numbers": [{"files": ["a/*"], "names": ["P_*"], "within": 1e-6, "reason": "rounding"}],
})  # fmt: skip


def told(text: str, path: str = "a/1-run.txt") -> list[str]:
    return [what.split("\n")[0] for what, reason in differences(path, *text.split("|"), LISTED) if reason is None]


def test_each_column_of_a_table_by_itself() -> None:
    before, now = "n,P_N,flag\n0,1.0,\n1,-2.0,odd\n", "n,P_N,flag\n0,1.0,\n1,-2.000001,even\n"
    found = deviations(numbers("t.csv", before), numbers("t.csv", now))
    assert found == {"P_N": pytest.approx(5e-7, rel=1e-3), "flag": math.inf}
    assert told(f"{before}|{now}", "a/t.csv") == ["flag differs by inf"]
    assert told(f"{before}|{now}", "b/t.csv") == ["P_N differs by 5.0e-07", "flag differs by inf"]


def test_a_change_of_words_hides_no_number_of_json() -> None:
    before = "exit code 0\n" + json.dumps({"P_N": 1.0, "note": "old words"}) + "\n-- stderr\n"
    now = before.replace("old words", "new ones")
    assert told(f"{before}|{now}") == []
    assert told(f"{before}|{now.replace('1.0', '1.1')}") == ["P_N differs by 9.1e-02"]
    assert told(f"{before}|{now.replace('code 0', 'code 2')}") == ["exit code differs by 1.0e+00"]
    assert told(f"{before}|{now.replace('P_N', 'load_N')}") == ["P_N differs by inf", "load_N differs by inf"]


def test_costs_that_are_masked_leave_json_to_read() -> None:
    text = '{\n  "cpu_s": <cost>\n  "P_N": 2.0,\n  "sizes": {"memory_B": <cost>}\n}'
    assert numbers("a.json", text)["P_N"] == [2.0]


def test_files_that_are_new_or_gone() -> None:
    assert list(differences("old/x.csv", "a\n", None, LISTED)) == [("is gone", "renamed")]
    assert list(differences("x.csv", None, "a\n", LISTED)) == [("is new", None)]
    assert list(differences("x.csv", "a\n1\n", "a\n1\n", NONE)) == []


def test_the_list_holds_for_its_own_commit_and_has_reasons() -> None:
    listed = tomllib.loads(MEANT.read_text(encoding="utf-8"))
    assert Meant.against(f"{listed['against']}0123").listed == listed
    assert Meant.against("0123456789ab").listed == {}
    for entry in listed.get("numbers", []):
        assert set(entry) == {"files", "names", "within", "reason"}
        assert entry["within"] > 0
        assert len(entry["reason"]) > 20


def test_a_number_in_an_unchanged_sentence_is_told() -> None:
    assert told("P = 1.0 mN|P = 1.1 mN", "show.csv.log") == ["other numbers in the same sentences"]
    assert told("the load|the force", "show.log") == ["other words"]


def masked(text: str) -> str:
    for mask, instead in MASKS:
        text = mask.sub(instead, text)
    return text


@pytest.mark.parametrize(
    "pair",
    [
        ("took 0.31 s", "took 1.2 s"),
        ('"cpu_s": 0.3,', '"cpu_s": 0.41,'),
        ("2026-01-02T10:00:00Z", "2026-11-26T09:59:01Z"),
    ],
)
def test_costs_and_dates_are_no_difference(pair: tuple[str, str]) -> None:
    assert masked(pair[0]) == masked(pair[1])


@pytest.mark.parametrize("text", ["P = -97.101 uN at a = 1.2 mm", "w 20 mJ/m^2", "stiffness 0.2 N/m"])
def test_what_a_user_reads_is_not_masked(text: str) -> None:
    assert masked(text) == text
