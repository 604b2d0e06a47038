"""Build the staged book to HTML, strictly: every warning is an error.

python -m cmtof_book.render STAGE HTML

It builds from nothing each time, since pages that Sphinx takes from its cache repeat no warning.
The full log lies beside ``HTML`` as ``book.log``. What no page loads is left out.
"""

import json
import re
import shutil
import subprocess
import sys
from html import escape
from pathlib import Path

import typer
from bs4 import BeautifulSoup

from cmtof.types import Texts
from cmtof_book import ROOT

SHOWN = "div.math[id], figure[id], dt[id^=term], div.citation[id], [id^=erratum-]"
UNUSED = re.compile(
    r"/mathjax/((?!tex-chtml\.js)[\w-]+\.js$|output/svg/|sre/mathmaps/(?!base|en))|/locales/|\.map$"
)


def lighten(html: Path) -> None:
    """Remove what no page loads; offer notebooks without the outputs that their pages show."""
    for file in (html / "_static").rglob("*"):
        if file.is_file() and UNUSED.search(file.as_posix()):
            file.unlink()
    for notebook in html.glob("_sources/notebooks/*"):
        shutil.copyfile(ROOT / "notebooks" / notebook.name, notebook)


def store_texts(html: Path) -> None:
    """Store the texts of pages for the search, and what links show when hovered."""
    texts: Texts = {}
    previews: Texts = {}
    for page in html.glob("*/*.html"):
        if article := BeautifulSoup(page.read_text("utf-8"), "html.parser").article:
            name = page.relative_to(html).as_posix()
            for place in article.select(SHOWN):
                kind = {"dt": "dd", "section": "p", "span": "p"}.get(place.name)
                shown = place.find_next(kind) if kind else place
                previews[f"{name}#{place['id']}"] = str(shown)
            for unread in article.select(
                "pre, summary, .math"
            ):  # nobody quotes code or TeX
                unread.decompose()
            texts[name] = escape(article.get_text(" "))
    for name, held in {"Texts": texts, "Previews": previews}.items():
        path = html / "_static" / f"{name.lower()}.js"
        path.write_text(f"const cmtof{name} = {json.dumps(held)};", "utf-8")


def main(stage: Path, html: Path) -> None:
    """Build ``stage`` and put the pages at ``html``; exit code 1 where it does not build."""
    work, log = html.with_name("sphinx"), html.with_name("book.log")
    shutil.rmtree(work, ignore_errors=True)
    options = ["-W", "-n", "--keep-going", "-q", "--path-output", work]
    command = [Path(sys.executable).with_name("jupyter-book"), "build", stage, *options]
    done = subprocess.run(
        command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    )
    text = re.sub(r"\x1b\[[0-9;]*m", "", done.stdout)  # colours are for a terminal
    log.write_text(text, "utf-8")
    if done.returncode:
        told = re.findall(r".*(?:WARNING|ERROR).*", text)
        print("\n".join(told) or text, file=sys.stderr)
        sys.exit(f"The book did not build; warnings count as errors. Log: {log}")
    shutil.rmtree(html, ignore_errors=True)
    (work / "_build" / "html").replace(html)
    shutil.rmtree(work)
    lighten(html)
    store_texts(html)
    print(f"book: {html / 'index.html'}", file=sys.stderr, flush=True)


if __name__ == "__main__":
    typer.run(main)
