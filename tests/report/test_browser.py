"""The report in a real browser: no console error, no sideways scrolling, filters that work."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tt_precise.report import render
from tt_precise.report.document import Report

pytestmark = pytest.mark.browser
COMMITTED = Path(__file__).parents[2] / "reports" / "precision-report.html"
QUIET = (
    "--headless=new", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync",
)  # fmt: skip


@pytest.fixture(scope="module")
def driver(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    selenium = pytest.importorskip("selenium.webdriver", reason="needs selenium: make browser")
    if not shutil.which("chromedriver"):
        pytest.skip("needs chromedriver: make browser")
    options = selenium.ChromeOptions()
    for flag in (*QUIET, f"--user-data-dir={tmp_path_factory.mktemp('profile')}"):
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
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


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("width", [390, 1400])
def test_opens_clean_at_every_width(driver: Any, page: str, width: int, scheme: str) -> None:
    feature = {"name": "prefers-color-scheme", "value": scheme}
    driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [feature]})
    metrics = {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": False}
    driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
    driver.get(page)
    assert driver.get_log("browser") == []
    wide = "return document.documentElement.scrollWidth"
    assert driver.execute_script(wide) <= width
    ink = driver.execute_script("return getComputedStyle(document.body).color")
    channels = [int(part) for part in ink.split("(")[1].rstrip(")").split(",")[:3]]
    assert (sum(channels) > 3 * 128) == (scheme == "dark")


def test_filters_and_search_choose_rows(driver: Any, page: str) -> None:
    driver.get(page)
    rows = "return [...document.querySelectorAll('#claims-table tbody tr')]"
    every = len(driver.execute_script(rows))
    shown = rows + ".filter(r => !r.hidden)"
    choose = """
        const tools = document.querySelector('#claims-table').parentElement.previousElementSibling;
        const control = tools.querySelector(arguments[0]);
        control.value = arguments[1];
        control.dispatchEvent(new Event('input', {bubbles: true}));
    """
    driver.execute_script(choose, "select[aria-label='choose kind']", "equation")
    equations = driver.execute_script(shown + ".map(r => r.cells[1].textContent)")
    assert equations
    assert set(equations) == {"equation"}
    driver.execute_script(choose, "select[aria-label='choose kind']", "")
    assert len(driver.execute_script(shown)) == every
    driver.execute_script(choose, "input", "NUM-02")
    found = driver.execute_script(shown + ".map(r => r.cells[0].textContent)")
    assert "NUM-02" in found
    assert len(found) < every
    driver.execute_script(choose, "input", "no such text anywhere")
    assert driver.execute_script(shown) == []
