"""Finish the pages that jupyter-book has built: remove unused files, store texts to search.

    python -m cmtof_book.render HTML

The Snakefile runs jupyter-book before, strictly and from nothing each time, since pages that Sphinx
takes from its cache repeat no warning.
"""

import json
import re
import sys
from html import escape
from pathlib import Path

from bs4 import BeautifulSoup

SHOWN = "div.math[id], figure[id], dt[id^=term], div.citation[id], [id^=erratum-]"
UNUSED = re.compile(
    r"/mathjax/((?!tex-chtml\.js)[\w-]+\.js$|output/svg/|sre/mathmaps/(?!base|en))|/locales/|\.map$"
)


def lighten(html: Path) -> None:
    """Remove what no page loads."""
    for file in (html / "_static").rglob("*"):
        if file.is_file() and UNUSED.search(file.as_posix()):
            file.unlink()


def store_texts(html: Path) -> None:
    """Store the texts of pages for the search, and what links show when hovered."""
    texts = {}
    previews = {}
    for page in html.glob("*/*.html"):
        # nobody quotes code, with which this takes twice as long
        text = re.sub("(?s)<pre.+?</pre>", "", page.read_text("utf-8"))
        if article := BeautifulSoup(text, "html.parser").article:
            name = page.relative_to(html).as_posix()
            for place in article.select(SHOWN):
                kind = {"dt": "dd", "section": "p", "span": "p"}.get(place.name)
                previews[f"{name}#{place['id']}"] = str(
                    place.find_next(kind) if kind else place
                )
            for unread in article.select("summary, .math"):  # nor formulas
                unread.decompose()
            texts[name] = escape(article.get_text(" "))
    for name, held in {"Texts": texts, "Previews": previews}.items():
        (html / f"_static/{name.lower()}.js").write_text(
            f"const cmtof{name} = {json.dumps(held)};", "utf-8"
        )


if __name__ == "__main__":
    PAGES = Path(sys.argv[1])
    lighten(PAGES)
    store_texts(PAGES)
