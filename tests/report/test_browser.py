"""The report in a real browser: every width and scheme, filters, deep links, print, motion."""

from __future__ import annotations

import base64
import re
import shutil
import time
from collections.abc import Callable, Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest

from tt_precise.claims import claims
from tt_precise.report import render
from tt_precise.report.document import Report

pytestmark = pytest.mark.browser
COMMITTED = Path(__file__).parents[2] / "reports" / "precision-report.html"
QUIET = (
    "--headless=new", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync",
)  # fmt: skip
WIDTHS = {390: 844, 768: 1024, 1400: 900}
HIGHEST_AT_1400 = 15_000  # px, folded
LARGEST = 2_500_000  # bytes
MOST_PAGES = 40
PATIENCE = 20  # s until a condition of ``Page.becomes`` has to hold
CONTRAST = 4.5  # Least contrast of letters, by WCAG 2 AA.

# least contrast of the letters against what is behind them, and where
LEAST_CONTRAST = """
const paint = document.createElement("canvas").getContext("2d", {willReadFrequently: true});
const channels = colour => {
  paint.clearRect(0, 0, 1, 1); paint.fillStyle = colour; paint.fillRect(0, 0, 1, 1);
  return [...paint.getImageData(0, 0, 1, 1).data];
};
const light = colour => {
  const [r, g, b] = channels(colour).map(c => c / 255)
    .map(c => c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4);
  return 0.2126 * r + 0.7152 * g + 0.0722 * b;
};
const ground = element => {
  for (let at = element; at; at = at.parentElement) {
    const colour = getComputedStyle(at).backgroundColor;
    if (channels(colour)[3] > 250) return colour;
  }
  return "white";
};
let least = [99, ""];
for (const element of document.querySelectorAll("body *")) {
  const text = [...element.childNodes].some(n => n.nodeType === 3 && n.data.trim());
  if (!text || element.closest("svg, script, style") || !element.checkVisibility()) continue;
  const [a, b] = [light(getComputedStyle(element).color), light(ground(element))];
  const contrast = (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
  if (contrast < least[0]) least = [contrast, element.outerHTML.slice(0, 200)];
}
return least;
"""
# what sticks out to the right, but for what scrolls in a box of its own
OVERFLOWING = """
return [...document.querySelectorAll("main *")].filter(e => e.checkVisibility()
  && !e.closest("svg, .scroll, .formula") && e.getBoundingClientRect().right > innerWidth + 1
  ).map(e => e.outerHTML.slice(0, 120));
"""


@pytest.fixture(scope="module")
def driver(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    selenium = pytest.importorskip("selenium.webdriver", reason="needs selenium: make browser")
    if not shutil.which("chromedriver"):
        pytest.skip("needs chromedriver: make browser")
    options = selenium.ChromeOptions()
    for flag in (*QUIET, f"--user-data-dir={tmp_path_factory.mktemp('profile')}"):
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    service = selenium.ChromeService(shutil.which("chromedriver"))
    browser = selenium.Chrome(options=options, service=service)
    # a window of a machine without a desktop has no focus of its own
    browser.execute_cdp_cmd("Emulation.setFocusEmulationEnabled", {"enabled": True})
    yield browser
    browser.quit()


class Page:
    """A page in the browser."""

    def __init__(self, driver: Any, address: str):
        self.driver, self.address, self.run = driver, address, driver.execute_script
        self.wait = driver.execute_async_script

    def open(
        self, hash: str = "", width: int = 1400, scheme: str = "light", motion: str = "reduce"
    ) -> None:
        """Open it anew in a window of that width, for a reader with these preferences."""
        preferences = {"prefers-color-scheme": scheme, "prefers-reduced-motion": motion}
        features = [{"name": name, "value": value} for name, value in preferences.items()]
        self.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": features})
        metrics = {"width": width, "height": WIDTHS[width], "deviceScaleFactor": 1, "mobile": False}
        self.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
        self.driver.get("about:blank")
        for log in ("browser", "performance"):
            self.driver.get_log(log)
        self.driver.get(self.address + hash)
        # on a loaded machine the driver may still speak to the page before
        loaded = "return document.readyState === 'complete' && location.href !== 'about:blank'"
        assert self.becomes(lambda: self.run(loaded))

    def follow(self, hash: str) -> None:
        """Follow a link within the page, until the page's own listener has run."""
        self.wait(
            "addEventListener('hashchange', () => setTimeout(arguments[1]), {once: true});"
            "location.hash = arguments[0]",
            hash,
        )

    def becomes(self, condition: Callable[[], bool]) -> bool:
        """True as soon as a condition holds, which a loaded machine may take seconds for."""
        ends = time.monotonic() + PATIENCE
        while not (holds := condition()) and time.monotonic() < ends:
            time.sleep(0.05)
        return holds

    def each(self, selector: str, what: str = "e") -> Any:
        script = f"return [...document.querySelectorAll(arguments[0])].map(e => {what})"
        return self.run(script, selector)

    @property
    def shown(self) -> list[str]:
        return self.each("#claims .claim:not([hidden])", "e.id")

    def fits(self, width: int) -> bool:
        wide = self.run("return document.documentElement.scrollWidth")
        return wide <= width and self.run(OVERFLOWING) == []


@pytest.fixture(params=["small", "committed"])
def page(request: pytest.FixtureRequest, driver: Any, small_report: Report, tmp_path: Path) -> Page:
    file = COMMITTED
    if request.param == "small":
        file = tmp_path / "report.html"
        file.write_text(render.html(small_report), "utf-8")
    opened = Page(driver, file.as_uri())
    opened.open()
    return opened


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("width", WIDTHS)
def test_is_clean_at_every_width(page: Page, width: int, scheme: str) -> None:
    page.open("", width, scheme)
    assert page.driver.get_log("browser") == []
    assert page.fits(width)
    contrast, where = page.run(LEAST_CONTRAST)
    assert contrast >= CONTRAST, where
    # with everything unfolded, too
    page.run("document.querySelectorAll('details').forEach(d => d.open = true)")
    assert page.fits(width)


def test_the_overflow_and_the_contrast_would_be_seen(page: Page) -> None:
    page.open("", 390)
    page.run("""
        const p = document.createElement("p");
        p.textContent = "faint"; p.style = "color: #999; width: 500px; max-width: none";
        document.querySelector("main").append(p);
    """)
    assert page.run(OVERFLOWING)
    contrast, where = page.run(LEAST_CONTRAST)
    assert contrast < CONTRAST
    assert "faint" in where


def test_the_page_requests_nothing_from_the_network(page: Page) -> None:
    events = [entry["message"] for entry in page.driver.get_log("performance")]
    asked = [re.search(r'"url":"([^"]*)"', one) for one in events if "requestWillBeSent" in one]
    urls = {found[1] for found in asked if found}
    assert urls
    assert all(url.startswith(("file:", "data:")) for url in urls), urls


@pytest.mark.parametrize(("width", "last"), [(1400, ".legend, .top"), (390, ".top svg")])
def test_the_first_screen_holds_what_matters(page: Page, width: int, last: str) -> None:
    page.open("", width)
    matters = f"h1, .sentence, .card, .cell, {last}"
    assert max(page.each(matters, "e.getBoundingClientRect().bottom")) <= WIDTHS[width]


def test_headings_are_in_order_and_everything_is_named(page: Page) -> None:
    levels = [int(tag[1]) for tag in page.each("h1, h2, h3, h4", "e.tagName")]
    assert levels[0] == 1
    assert all(after <= before + 1 for before, after in pairwise(levels))
    named = page.each(
        "svg[role=img], figure img",
        "(e.alt || document.getElementById(e.getAttribute("
        "'aria-labelledby'))?.textContent || '') && document.getElementById("
        "e.getAttribute('aria-describedby'))?.textContent.trim().length > 20",
    )
    assert named
    assert all(named)
    words = "!!(e.ariaLabel || e.labels?.length || e.textContent.trim())"
    assert all(page.each("select, input, button, nav", words))


def test_every_claim_can_be_linked_to(page: Page) -> None:
    cells = page.each(".cell", "e.hash.slice(1)")
    assert cells
    assert sorted(cells) == sorted(page.each("#claims .claim", "e.id"))
    links = page.each("a[href^='#']", "e.hash.slice(1).split('/')[0]")
    assert set(links) <= set(page.each("[id]", "e.id"))
    for id in (cells[0], cells[-1]):
        page.open(f"#{id}")
        ((is_open, top),) = page.each(f"#{id}", "[e.open, e.getBoundingClientRect().top]")
        assert is_open
        assert 0 <= top < 900


def test_filters_show_as_many_as_the_text_says(page: Page) -> None:
    every, counted = page.shown, 0
    for link in page.each(".legend a", "e.hash"):
        page.open(link)
        shown, text = page.shown, page.each("#claims [role=status]", "e.textContent")
        page.open(link.split("/")[0])
        # the mark before the number is no digit
        (told,) = page.each(f".legend a[href='{link}']", "e.lastChild.data.trim()")
        number = int(told.split()[0])
        assert len(shown) == number
        assert text == [f"{number} of {len(every)}"]
        if "verdict" in link:
            counted += number
        else:
            assert link == "#claims/proved"
    assert counted == len(every)


def test_search_and_filters_combine(page: Page) -> None:
    def choose(control: str, value: Any) -> list[str]:
        script = """
            const control = document.querySelector("#claims .tools " + arguments[0]);
            if (control.type === "checkbox") control.checked = arguments[1];
            else control.value = arguments[1];
            control.dispatchEvent(new Event("input", {bubbles: true}));
        """
        page.run(script, control, value)
        return page.shown

    kind, proved, search = "select[name=kind]", "input[name=proved]", "input[type=search]"
    every = page.shown
    assert all(id.startswith("EQ-") for id in choose(kind, "equation"))
    assert choose(proved, True)
    assert all(page.each("#claims .claim:not([hidden])", "'proved' in e.dataset"))
    choose(proved, False)
    assert choose(kind, "") == every
    assert "NUM-02" in choose(search, "NUM-02")
    assert len(page.shown) < len(every)
    assert choose(search, "theta_dot")  # by a symbol's name
    assert choose(search, "no such text anywhere") == []
    assert all(page.each("#claims .group", "e.hidden"))
    page.follow(f"#{every[0]}")  # a link to what is filtered out
    assert every[0] in page.shown


def test_the_keyboard_reaches_everything(page: Page) -> None:
    reached = "a[href], button, select, input, summary"
    assert not any(page.each(reached, "e.tabIndex < 0 ? e.outerHTML.slice(0, 80) : ''"))
    assert not any(page.each(".scroll", "e.tabIndex"))
    assert page.run("return document.hasFocus()")
    page.run("document.querySelector('.skip').focus()")
    assert page.each(".skip", "e.getBoundingClientRect().left >= 0") == [True]


def test_the_contents_follow_the_scroll(page: Page) -> None:
    current = ".contents a[aria-current]"
    assert page.each(current, "e.hash") == ["#overview"]
    page.run(
        "document.documentElement.style.scrollBehavior = 'auto';"
        "document.getElementById('claims').scrollIntoView()"
    )
    assert page.becomes(lambda: page.each(current, "e.hash") == ["#claims"])


def test_the_top_moves_stops_and_can_be_dragged(page: Page) -> None:
    moved = """
        const done = arguments[0], slider = document.getElementById("top-time");
        const first = slider.value;
        setTimeout(() => done(slider.value !== first), 400);
    """
    assert not page.wait(moved)
    page.open(motion="no-preference")
    assert page.becomes(lambda: page.wait(moved))
    page.run("document.getElementById('top-play').click()")
    assert not page.wait(moved)
    assert page.each("#top-play", "e.textContent") == ["Play"]
    drag = """
        const slider = document.getElementById("top-time");
        slider.value = arguments[0];
        slider.dispatchEvent(new Event("input", {bubbles: true}));
        return document.getElementById("top-angle").textContent;
    """
    assert page.run(drag, "0") == f"θ = {180 * 0.1 / 3.141592653589793:.1f}°"
    assert float(page.run(drag, "8").split()[2].rstrip("°")) > 179


def test_print_is_short_and_has_all_errata(page: Page) -> None:
    page.open(scheme="dark")
    printed = page.driver.execute_cdp_cmd("Page.printToPDF", {"preferCSSPageSize": True})
    pages = re.findall(rb"/Type\s*/Page\b(?!s)", base64.b64decode(printed["data"]))
    assert 1 <= len(pages) <= MOST_PAGES
    page.run("dispatchEvent(new Event('beforeprint'))")
    assert all(page.each(".erratum", "e.open"))
    assert page.each("#top-play", "e.textContent") == ["Play"]
    page.run("dispatchEvent(new Event('afterprint'))")
    assert not any(page.each(".erratum", "e.open"))


@pytest.mark.parametrize("page", ["committed"], indirect=True)
def test_the_committed_page_is_no_longer_than_it_should(page: Page) -> None:
    assert COMMITTED.stat().st_size < LARGEST
    assert page.run("return document.documentElement.scrollHeight") <= HIGHEST_AT_1400
    assert len(page.each(".cell")) == len(claims())
    assert len(page.each("figure.picture")) > 20
