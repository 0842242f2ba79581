"""The committed report in a real browser: widths and schemes, filters, links, print, motion."""

from __future__ import annotations

import base64
import re
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tt_precise.claims import claims

pytestmark = pytest.mark.browser
PAGE = Path(__file__).parents[2] / "reports" / "precision-report.html"
QUIET = (
    "--headless=new", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync",
)  # fmt: skip
WIDTHS = {390: 844, 768: 1024, 1400: 900}
HIGHEST_AT_1400 = 15_000  # Pixels of the page while everything is folded.
LARGEST = 2_500_000  # Bytes of the page.
MOST_PAGES = 40  # Printed pages.

# Elements that stick out to the right, and formulas of errata that are cut off.
OVERFLOWING = """
return [...document.querySelectorAll("main *")].filter(e => e.checkVisibility()
  && !e.closest("svg, .scroll, .formula") && e.getBoundingClientRect().right > innerWidth + 1
  || e.matches(".erratum > summary .formula") && e.scrollWidth > e.clientWidth + 1
  ).map(e => e.outerHTML.slice(0, 120));
"""


class Page:
    """The report in the browser."""

    def __init__(self, driver: Any) -> None:
        self.driver, self.run = driver, driver.execute_script

    def open(self, hash: str = "", width: int = 1400, scheme: str = "light") -> None:
        """Open the page anew in a window of that width, for a reader who prefers a scheme."""
        wishes = {"color-scheme": scheme, "reduced-motion": "reduce"}
        features = [{"name": f"prefers-{name}", "value": value} for name, value in wishes.items()]
        self.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": features})
        size = {"width": width, "height": WIDTHS[width], "deviceScaleFactor": 1, "mobile": False}
        self.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
        self.driver.get("about:blank")
        self.driver.get_log("browser")
        self.driver.get(PAGE.as_uri() + hash)

    def each(self, selector: str, value: str = "e.id") -> Any:
        script = f"return [...document.querySelectorAll(arguments[0])].map(e => {value})"
        return self.run(script, selector)


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Page]:
    selenium = pytest.importorskip("selenium.webdriver", reason="needs selenium: make browser")
    if not shutil.which("chromedriver"):
        pytest.skip("needs chromedriver: make browser")
    options = selenium.ChromeOptions()
    for flag in (*QUIET, f"--user-data-dir={tmp_path_factory.mktemp('profile')}"):
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    service = selenium.ChromeService(shutil.which("chromedriver"))
    browser = selenium.Chrome(options=options, service=service)
    yield Page(browser)
    browser.quit()


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("width", WIDTHS)
def test_the_page_is_clean_at_every_width(page: Page, width: int, scheme: str) -> None:
    page.open("", width, scheme=scheme)
    assert page.driver.get_log("browser") == []
    screen = "h1, .sentence, .card, .cell, .top svg"
    if width != 768:  # a tablet scrolls
        assert max(page.each(screen, "e.getBoundingClientRect().bottom")) <= WIDTHS[width]
    for unfold in ("", "document.querySelectorAll('details').forEach(d => d.open = true)"):
        page.run(unfold)
        assert page.run("return document.documentElement.scrollWidth") <= width
        assert page.run(OVERFLOWING) == []


def test_an_overflow_is_seen(page: Page) -> None:
    page.open("", 390)
    page.run("""
        const p = document.createElement("p");
        p.style = "width: 500px; max-width: none";
        document.querySelector("main").append(p);
    """)
    assert page.run(OVERFLOWING)


def test_links_lead_to_claims_and_filters_show_as_many_as_they_say(page: Page) -> None:
    page.open()
    cells, every = page.each(".cell", "e.hash.slice(1)"), page.each("#claims .claim")
    assert sorted(cells) == sorted(every) == sorted(claims())
    assert {hash.split("/")[0] for hash in page.each("a[href^='#']", "e.hash.slice(1)")} <= {
        *page.each("[id]")
    }
    for link, label in page.each(".legend a", "[e.hash, e.lastChild.data.trim()]"):
        page.open(link)
        assert len(page.each("#claims .claim:not([hidden])")) == int(label.split()[0])
    page.open(f"#{cells[-1]}")
    ((is_open, top),) = page.each(f"#{cells[-1]}", "[e.open, e.getBoundingClientRect().top]")
    assert is_open
    assert 0 <= top < 900
    page.run("""
        const search = document.querySelector("#claims .tools input[type=search]");
        search.value = "NUM-02"; search.dispatchEvent(new Event("input", {bubbles: true}));
    """)
    assert "NUM-02" in page.each("#claims .claim:not([hidden])")
    assert len(page.each("#claims .claim:not([hidden])")) < len(every)


def test_the_page_is_short_and_has_all_errata_on_paper(page: Page) -> None:
    page.open(scheme="dark")
    assert PAGE.stat().st_size < LARGEST
    assert page.run("return document.documentElement.scrollHeight") <= HIGHEST_AT_1400
    pdf = page.driver.execute_cdp_cmd("Page.printToPDF", {"preferCSSPageSize": True})
    sheets = re.findall(rb"/Type\s*/Page\b(?!s)", base64.b64decode(pdf["data"]))
    assert 1 <= len(sheets) <= MOST_PAGES
    page.run("dispatchEvent(new Event('beforeprint'))")
    assert all(page.each(".erratum", "e.open"))
