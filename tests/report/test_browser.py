"""The report in a real browser: every width and scheme, filters, deep links, print, motion."""

from __future__ import annotations

import base64
import re
import shutil
from collections.abc import Iterator
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
CONTRAST = 4.5  # of letters, WCAG 2 AA

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
    yield browser
    browser.quit()


@pytest.fixture(params=["small", "committed"])
def page(request: pytest.FixtureRequest, small_report: Report, tmp_path: Path) -> str:
    if request.param == "committed":
        return COMMITTED.as_uri()
    file = tmp_path / "report.html"
    file.write_text(render.html(small_report), "utf-8")
    return file.as_uri()


def look(driver: Any, width: int = 1400, scheme: str = "light", motion: str = "reduce") -> None:
    """Set the window's size and what the reader prefers."""
    features = {"prefers-color-scheme": scheme, "prefers-reduced-motion": motion}
    driver.execute_cdp_cmd(
        "Emulation.setEmulatedMedia",
        {"features": [{"name": name, "value": value} for name, value in features.items()]},
    )
    metrics = {"width": width, "height": WIDTHS[width], "deviceScaleFactor": 1, "mobile": False}
    driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)


def opened(driver: Any, page: str, hash: str = "") -> None:
    driver.get("about:blank")
    driver.get_log("browser")
    driver.get_log("performance")
    driver.get(page + hash)


def in_page(driver: Any, selector: str, what: str = "e") -> Any:
    script = f"return [...document.querySelectorAll(arguments[0])].map(e => {what})"
    return driver.execute_script(script, selector)


def shown(driver: Any) -> list[str]:
    return driver.execute_script(
        "return [...document.querySelectorAll('#claims .claim')].filter(e => !e.hidden)"
        ".map(e => e.id)"
    )


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("width", WIDTHS)
def test_is_clean_at_every_width(driver: Any, page: str, width: int, scheme: str) -> None:
    look(driver, width, scheme)
    opened(driver, page)
    assert driver.get_log("browser") == []
    assert driver.execute_script("return document.documentElement.scrollWidth") <= width
    assert driver.execute_script(OVERFLOWING) == []
    contrast, where = driver.execute_script(LEAST_CONTRAST)
    assert contrast >= CONTRAST, where
    # with everything unfolded, too
    driver.execute_script("document.querySelectorAll('details').forEach(d => d.open = true)")
    assert driver.execute_script("return document.documentElement.scrollWidth") <= width
    assert driver.execute_script(OVERFLOWING) == []


def test_the_overflow_and_the_contrast_would_be_seen(driver: Any, page: str) -> None:
    look(driver, 390)
    opened(driver, page)
    driver.execute_script("""
        const p = document.createElement("p");
        p.textContent = "faint"; p.style = "color: #999; width: 500px; max-width: none";
        document.querySelector("main").append(p);
    """)
    assert driver.execute_script(OVERFLOWING)
    contrast, where = driver.execute_script(LEAST_CONTRAST)
    assert contrast < CONTRAST
    assert "faint" in where


def test_asks_nobody_for_anything(driver: Any, page: str) -> None:
    look(driver)
    opened(driver, page)
    events = [entry["message"] for entry in driver.get_log("performance")]
    asked = [re.search(r'"url":"([^"]*)"', one) for one in events if "requestWillBeSent" in one]
    urls = {found[1] for found in asked if found}
    assert urls
    assert all(url.startswith(("file:", "data:")) for url in urls), urls


def test_the_first_screen_holds_what_matters(driver: Any, page: str) -> None:
    look(driver)
    opened(driver, page)
    bottoms = in_page(
        driver, "h1, .sentence, .card, .cell, .legend, .top", "e.getBoundingClientRect().bottom"
    )
    assert max(bottoms) <= WIDTHS[1400]
    look(driver, 390)
    opened(driver, page)
    bottoms = in_page(
        driver, "h1, .sentence, .card, .cell, .top svg", "e.getBoundingClientRect().bottom"
    )
    assert max(bottoms) <= WIDTHS[390]


def test_headings_are_in_order_and_everything_is_named(driver: Any, page: str) -> None:
    look(driver)
    opened(driver, page)
    levels = [int(tag[1]) for tag in in_page(driver, "h1, h2, h3, h4", "e.tagName")]
    assert levels[0] == 1
    assert all(after <= before + 1 for before, after in pairwise(levels))
    unnamed = in_page(
        driver, "svg[role=img], figure img",
        "(e.alt || document.getElementById(e.getAttribute("
        "'aria-labelledby'))?.textContent || '') && document.getElementById("
        "e.getAttribute('aria-describedby'))?.textContent.trim().length > 20",
    )  # fmt: skip
    assert unnamed
    assert all(unnamed)
    assert all(in_page(driver, "select, input, button, nav", "!!(e.ariaLabel || e.labels?.length "
                       "|| e.textContent.trim())"))  # fmt: skip


def test_every_claim_can_be_linked_to(driver: Any, page: str) -> None:
    look(driver)
    opened(driver, page)
    cells = in_page(driver, ".cell", "e.hash.slice(1)")
    assert cells
    assert sorted(cells) == sorted(in_page(driver, "#claims .claim", "e.id"))
    broken = driver.execute_script(
        "return [...document.querySelectorAll('a[href^=\"#\"]')].map(a => a.hash.slice(1)"
        ".split('/')[0]).filter(id => !document.getElementById(id))"
    )
    assert broken == []
    for id in (cells[0], cells[-1]):
        opened(driver, page, f"#{id}")
        where = in_page(driver, f"#{id}", "[e.open, e.getBoundingClientRect().top]")
        ((is_open, top),) = where
        assert is_open
        assert 0 <= top < 900


def test_filters_show_as_many_as_the_text_says(driver: Any, page: str) -> None:
    look(driver)
    opened(driver, page)
    every = shown(driver)
    legend = in_page(driver, ".legend a", "[e.hash, parseInt(e.textContent)]")
    counted = 0
    for link, number in legend:
        opened(driver, page, link)
        found = shown(driver)
        text = in_page(driver, "#claims [role=status]", "e.textContent")
        opened(driver, page, link.split("/")[0])
        if "verdict" not in link:  # the mark before the number is no digit
            assert link == "#claims/proved"
        number = int(in_page(driver, f".legend a[href='{link}']", "e.lastChild.data.trim()")[0]
                     .split()[0])  # fmt: skip
        assert len(found) == number
        assert text == [f"{number} of {len(every)}"]
        counted += number if "verdict" in link else 0
    assert counted == len(every)


def test_search_and_filters_combine(driver: Any, page: str) -> None:
    look(driver)
    opened(driver, page)
    every = shown(driver)
    choose = """
        const control = document.querySelector("#claims .tools " + arguments[0]);
        if (control.type === "checkbox") control.checked = arguments[1];
        else control.value = arguments[1];
        control.dispatchEvent(new Event("input", {bubbles: true}));
    """
    driver.execute_script(choose, "select[name=kind]", "equation")
    assert all(id.startswith("EQ-") for id in shown(driver))
    driver.execute_script(choose, "input[name=proved]", True)
    equations = shown(driver)
    assert equations
    assert in_page(driver, "#claims .claim:not([hidden])", "'proved' in e.dataset") == (
        [True] * len(equations)
    )
    driver.execute_script(choose, "input[name=proved]", False)
    driver.execute_script(choose, "select[name=kind]", "")
    driver.execute_script(choose, "input[type=search]", "NUM-02")
    assert "NUM-02" in shown(driver)
    assert len(shown(driver)) < len(every)
    driver.execute_script(choose, "input[type=search]", "theta_dot")  # by a symbol's name
    assert shown(driver)
    driver.execute_script(choose, "input[type=search]", "no such text anywhere")
    assert shown(driver) == []
    assert in_page(driver, "#claims .group", "e.hidden") == [True] * len(
        in_page(driver, "#claims .group")
    )
    driver.get(f"{driver.current_url.split('#')[0]}#{every[0]}")  # a link to what is filtered out
    assert every[0] in shown(driver)


def test_the_keyboard_reaches_everything(driver: Any, page: str) -> None:
    look(driver)
    opened(driver, page)
    unreachable = in_page(
        driver, "a[href], button, select, input, summary",
        "e.tabIndex < 0 ? e.outerHTML.slice(0, 80) : ''",
    )  # fmt: skip
    assert not any(unreachable)
    assert in_page(driver, ".scroll", "e.tabIndex") == [0] * len(in_page(driver, ".scroll"))
    driver.execute_script("document.querySelector('.skip').focus()")
    assert in_page(driver, ".skip", "e.getBoundingClientRect().left >= 0") == [True]


def test_the_contents_follow_the_scroll(driver: Any, page: str) -> None:
    look(driver)
    opened(driver, page)
    current = ".contents a[aria-current]"
    assert in_page(driver, current, "e.hash") == ["#overview"]
    driver.execute_script(
        "document.documentElement.style.scrollBehavior = 'auto';"
        "document.getElementById('claims').scrollIntoView()"
    )
    driver.execute_async_script("requestAnimationFrame(() => requestAnimationFrame(arguments[0]))")
    assert in_page(driver, current, "e.hash") == ["#claims"]


def test_the_top_moves_stops_and_can_be_dragged(driver: Any, page: str) -> None:
    moved = """
        const done = arguments[0], slider = document.getElementById("top-time");
        const first = slider.value;
        setTimeout(() => done(slider.value !== first), 400);
    """
    look(driver, motion="no-preference")
    opened(driver, page)
    assert driver.execute_async_script(moved)
    driver.execute_script("document.getElementById('top-play').click()")
    assert not driver.execute_async_script(moved)
    assert in_page(driver, "#top-play", "e.textContent") == ["Play"]
    drag = """
        const slider = document.getElementById("top-time");
        slider.value = arguments[0];
        slider.dispatchEvent(new Event("input", {bubbles: true}));
        return document.getElementById("top-angle").textContent;
    """
    start, end = (driver.execute_script(drag, t) for t in ("0", "8"))
    assert start == f"θ = {180 * 0.1 / 3.141592653589793:.1f}°"
    assert float(end.split()[2].rstrip("°")) > 179
    look(driver, motion="reduce")
    opened(driver, page)
    assert not driver.execute_async_script(moved)


def test_print_is_short_and_has_all_errata(driver: Any, page: str) -> None:
    look(driver, scheme="dark")
    opened(driver, page)
    pdf = base64.b64decode(
        driver.execute_cdp_cmd("Page.printToPDF", {"preferCSSPageSize": True})["data"]
    )
    pages = len(re.findall(rb"/Type\s*/Page\b(?!s)", pdf))
    assert 1 <= pages <= MOST_PAGES
    driver.execute_script("dispatchEvent(new Event('beforeprint'))")
    assert all(in_page(driver, ".erratum", "e.open"))
    assert in_page(driver, "#top-play", "e.textContent") == ["Play"]
    driver.execute_script("dispatchEvent(new Event('afterprint'))")
    assert not any(in_page(driver, ".erratum", "e.open"))


def test_the_committed_page_is_no_longer_than_it_should(driver: Any) -> None:
    assert COMMITTED.stat().st_size < LARGEST
    look(driver)
    opened(driver, COMMITTED.as_uri())
    assert driver.execute_script("return document.documentElement.scrollHeight") <= HIGHEST_AT_1400
    assert len(in_page(driver, ".cell")) == len(claims())
    assert len(in_page(driver, "figure.picture")) > 20
