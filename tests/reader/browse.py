"""Look at built pages in headless Chromium (Debian: apt-get install chromium) without a network."""

import re
import shutil
from contextlib import contextmanager

from playwright.sync_api import sync_playwright

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
WIDTHS = {"desk": 1280, "phone": 360}
FLAGS = (
    "--no-sandbox --disable-gpu --disable-quic --no-first-run --disable-sync --disable-extensions "
    "--disable-background-networking --disable-component-update --proxy-server=127.0.0.1:9"
)

# what a page says about itself once its formulas are drawn
PROBE = """async () => {
  const math = document.querySelectorAll('.math').length;
  if (math && window.MathJax && MathJax.startup) await MathJax.startup.promise;
  await document.fonts.ready;
  const article = document.querySelector('article');
  const right = article ? article.getBoundingClientRect().right + 1 : Infinity;
  const wide = selector => [...document.querySelectorAll(selector)].filter(e => e.offsetParent
    && (e.scrollWidth > e.clientWidth + 1 || e.getBoundingClientRect().right > right)).length;
  return {
    undrawn: math - document.querySelectorAll('mjx-container').length,
    broken: document.querySelectorAll('mjx-merror').length,
    images: [...document.images].filter(i => i.loading !== 'lazy' && !i.naturalWidth)
      .map(i => i.src),
    overflow: document.documentElement.scrollWidth - document.documentElement.clientWidth,
    lead: (document.querySelector('.cell figure') ?? document.body).getBoundingClientRect().top,
    code: wide('article .cell_input pre'), equations: wide('article div.math'),
    tables: wide('article :is(.pst-scrollable-table-container, .cell_output .output):has(table)'),
    text: document.body.innerText,
  };
}"""

UNWANTED = {
    "a directive": r"^\s*(```|:::)?\{[a-z-]+\}",
    "a table in Markdown": r"^\|.*\|$",
    "a traceback": r"Traceback \(most recent call last\)",
    "a warning": r"\w+Warning: ",
    "a path of a machine": r"(?<![\w.])/(home|root|tmp|work|Users)/\w",
}


@contextmanager
def chromium():
    """Start a browser without a profile and without a network."""
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=CHROMIUM, args=FLAGS.split()
        )
        yield browser
        browser.close()


@contextmanager
def opened(browser, page, width):
    """Yield a page in its tab, and the list that its complaints are added to."""
    tab = browser.new_page(viewport={"width": width, "height": 900})
    problems = []
    local = ("file:", "data:", "blob:")
    tab.on(
        "request",
        lambda r: r.url.startswith(local) or problems.append(f"asks for {r.url}"),
    )
    # a link to a download ends as a failed navigation
    tab.on(
        "requestfailed",
        lambda r: r.is_navigation_request() or problems.append(f"no {r.url}"),
    )
    tab.on("pageerror", lambda error: problems.append(f"script: {error}"))
    tab.on(
        "console", lambda m: m.type == "error" and problems.append(f"console: {m.text}")
    )
    tab.goto(page.resolve().as_uri())
    yield tab, problems
    tab.close()


def faults(state, width):
    """What is wrong with a page by what it says about itself."""
    if state["undrawn"] > 0 or state["broken"]:
        yield f"{state['undrawn']} formulas are not drawn, {state['broken']} hold an error"
    if state["overflow"] > 0:
        yield f"wider than the screen by {state['overflow']} px"
    if width == WIDTHS["desk"]:
        wide = [kind for kind in ("code", "equations", "tables") if state[kind]]
        yield from (f"{state[kind]} {kind} wider than the column" for kind in wide)
        if state["lead"] > 600:  # of 900 px
            yield f"the first figure begins at {state['lead']:.0f} px, not within the first screen"
    yield from (f"image not drawn: {source}" for source in state["images"])
    for name, pattern in UNWANTED.items():
        if found := re.search(pattern, state["text"], re.MULTILINE):
            yield f"{name}: {found[0]!r}"


def pages(html):
    """Pages of a book, those that only serve the theme or lead on left out."""
    skipped = {"genindex.html", "py-modindex.html", "index.html"}
    found = sorted(html.rglob("*.html"))
    return [p for p in found if "_static" not in p.parts and p.name not in skipped]
