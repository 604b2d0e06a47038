"""What a reader moves: sliders, scenes to turn, dividers.

The book's script draws them on its pages. JupyterLab gets the same script within a frame.
"""

from html import escape
from pathlib import Path

from cmtof_book import ROOT, record

STATIC = ROOT / "book/_static"

# What the theme gives a page: colours and letters.
LOOK = (
    "body { --pst-color-border: #ccc; --pst-color-primary: #0072b2; --pst-color-surface: #f2f4f5;"
    " background: #fff; color: #000; font: 15px sans-serif; max-width: 720px; }"
)
# The frame is as high as what it holds.
GROW = (
    "const body = this.contentDocument.body;"
    "new ResizeObserver(() => (this.height = body.scrollHeight + 20)).observe(body)"
)


def show(html: str, *scripts: Path) -> None:
    """Show HTML that the book's script, and scripts that run after it, bring to life."""
    style, *acts = [
        file.read_text("utf-8") if file.is_file() else ""
        for file in (STATIC / "cmtof.css", STATIC / "cmtof.js", *scripts)
    ]
    held = escape(
        f'<style>{LOOK}{style}</style><body class="bd-article">{html}'
        f"<script>{''.join(acts)}</script>"
    )
    frame = f'<iframe width="100%" frameborder="0" onload="{GROW}" srcdoc="{held}"></iframe>'
    record.show({"text/html": frame}, "page", html=html)
