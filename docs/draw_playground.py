"""Draws the playground as browsers show it, one in light and one in dark: docs/pictures/playground.png."""
import io
import sys
import tempfile
from pathlib import Path

from PIL import Image
from playwright.sync_api import Browser, sync_playwright

from cosim.playground.write import playground

PICTURES = Path(__file__).parent / "pictures"
VIEWS = ((1366, 960, "light"), (390, 960, "dark"))  # px, px, scheme
GAP = 24  # px


def shot(browser: Browser, page: Path, width: int, height: int, scheme: str) -> Image.Image:
    """The page after a flight with the repaired gains and one with the printed ones."""
    view = browser.new_context(viewport={"width": width, "height": height}, color_scheme=scheme).new_page()
    view.goto(page.as_uri())
    view.locator('html[data-flights="1"]').wait_for(state="attached")
    view.get_by_role("button", name="Fly the printed gains").click()
    view.locator('html[data-flights="2"]').wait_for(state="attached")
    view.mouse.move(0, 0)
    return Image.open(io.BytesIO(view.screenshot()))


def main(folder: Path) -> None:
    """Draw it into `folder`."""
    with tempfile.TemporaryDirectory() as made, sync_playwright() as playwright:
        page = playground(Path(made) / "page.html")
        browser = playwright.chromium.launch(executable_path="/usr/bin/chromium", args=["--no-sandbox"])
        shots = [shot(browser, page, *view) for view in VIEWS]
        browser.close()
    width = sum(one.width for one in shots) + GAP * (len(shots) - 1)
    picture, at = Image.new("RGB", (width, shots[0].height), "white"), 0
    for one in shots:
        picture.paste(one, (at, 0))
        at += one.width + GAP
    picture.save(folder / "playground.png", optimize=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else PICTURES)
