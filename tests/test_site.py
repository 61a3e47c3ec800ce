"""The site that ``make docs`` builds, in Chromium: nothing is cut or overlaps on a phone, a screen and paper."""

import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from conftest import MEDIA, shown_at

from jkrcli.cli import VERBS
from jkrcli.many.verbs import STUDIES

ROOT = Path(__file__).parents[1]
FAULTS = """
const faults = [], visible = [...document.querySelectorAll('.main, .main *')].filter(
  part => part.clientWidth && getComputedStyle(part).visibility !== 'hidden');
const words = part => `${part.tagName}.${part.className} "${part.textContent.trim().slice(0, 40)}"`;
for (const part of visible) {
  const equation = part.classList.contains('math-wrapper') && arguments[0] === 'screen';  // it scrolls
  if (getComputedStyle(part).overflowX !== 'visible' && part.scrollWidth > part.clientWidth + 1 && !equation)
    faults.push('cut: ' + words(part));
  if (part.matches('table, pre, img, p') && !part.closest('.math-wrapper')
      && part.getBoundingClientRect().right > document.documentElement.clientWidth + 1)
    faults.push('beyond the page: ' + words(part));
}
for (const section of document.querySelectorAll('article section')) {
  const boxes = [...section.children].map(part => [part.getBoundingClientRect(), part]).filter(([box]) => box.height);
  boxes.slice(1).forEach(([box, part], i) => {
    if (box.top < boxes[i][0].bottom - 1) faults.push('overlaps what is above: ' + words(part));
  });
}
return faults;
"""


@pytest.fixture(name="site", scope="module")
def _site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    pytest.importorskip("furo")
    folder = tmp_path_factory.mktemp("site")
    words = ("--quiet", "--nitpicky", "--fail-on-warning", "-d", folder / "doctrees", "docs", folder / "html")
    subprocess.run([sys.executable, "-m", "sphinx", *words], cwd=ROOT, check=True)
    return folder / "html"


def pages(site: Path) -> list[Path]:
    return sorted(page for page in site.rglob("*.html") if "article" in page.read_text(encoding="utf-8")
                  and page.name not in ("search.html", "genindex.html"))  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize(("media", "width"), MEDIA)
def test_nothing_is_cut_or_overlaps_and_no_script_errs(site: Path, browser: Any, media: str, width: int) -> None:
    shown_at(browser, width, media)
    found = {}
    for page in pages(site):
        browser.get(page.as_uri())
        faults = [*browser.execute_script(FAULTS, media), *(entry["message"] for entry in browser.get_log("browser"))]
        found |= {page.name: faults} if faults else {}
    assert len(pages(site)) > 60
    assert found == {}


@pytest.mark.slow
def test_every_verb_has_a_page_with_each_option_and_users_see_no_contributors_pages(site: Path) -> None:
    import click

    from jkrcli.cli import jkr

    for verb in VERBS:
        text = (site / "reference" / "verbs" / f"{verb}.html").read_text(encoding="utf-8")
        command = jkr.get_command(click.Context(jkr), verb)
        assert command is not None
        options = [option for option in command.params if isinstance(option, click.Option) and not option.hidden]
        assert [option.opts for option in options if f"{option.opts[-1]}" not in text] == []
    maps = (site / "reference" / "verbs" / "study.html").read_text(encoding="utf-8")
    assert [name for name in STUDIES if f"<h2>jkr study {name}<" not in maps] == []
    tree = (site / "index.html").read_text(encoding="utf-8").partition('class="sidebar-tree"')[2]
    tree = tree.partition("</aside>")[0]
    assert 'href="guides/index.html"' in tree
    assert "project/" not in tree
