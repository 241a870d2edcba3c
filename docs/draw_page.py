"""Draws the page of a run as browsers show it, one in light and one in dark: docs/pictures/page.png."""
import io
import sys
import tempfile
from pathlib import Path

from PIL import Image
from playwright.sync_api import Browser, sync_playwright

from cosim.vehicle.run import run

PICTURES = Path(__file__).parent / "pictures"
VIEWS = ((1100, 900, "light"), (390, 900, "dark"))  # px, px, scheme
GAP = 24  # px


def shot(browser: Browser, page: Path, width: int, height: int, scheme: str) -> Image.Image:
    """The page with the cursor in a window in which much is marked."""
    view = browser.new_context(viewport={"width": width, "height": height}, color_scheme=scheme).new_page()
    view.goto(page.as_uri())
    view.locator('html[data-drawn="1"]').wait_for(state="attached")
    view.locator("#at").fill("12")
    view.wait_for_timeout(500)
    return Image.open(io.BytesIO(view.screenshot()))


def main(folder: Path) -> None:
    """Draw it into `folder`."""
    with tempfile.TemporaryDirectory() as made, sync_playwright() as playwright:
        page = run("case1", preset="printed", out=Path(made)).out / "report.html"
        browser = playwright.chromium.launch(executable_path="/usr/bin/chromium", args=["--no-sandbox"])
        shots = [shot(browser, page, *view) for view in VIEWS]
        browser.close()
    width = sum(one.width for one in shots) + GAP * (len(shots) - 1)
    picture, at = Image.new("RGB", (width, shots[0].height), "white"), 0
    for one in shots:
        picture.paste(one, (at, 0))
        at += one.width + GAP
    picture.quantize(256).save(folder / "page.png", optimize=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else PICTURES)
