"""Draws the live page of a flight as browsers show it, one in light and one in dark: docs/pictures/live.png."""
import io
import sys
import tempfile
import threading
from pathlib import Path

from PIL import Image
from playwright.sync_api import Browser, Page, sync_playwright

from cosim.vehicle.run import run

PICTURES = Path(__file__).parent / "pictures"
VIEWS = ((1366, 1000, "light"), (390, 1000, "dark"))  # px, px, scheme
GAP = 24     # px
WAIT_S = 7.0


def opened(browser: Browser, address: str, width: int, height: int, scheme: str) -> Page:
    """The page, when it shows the flight."""
    view = browser.new_context(viewport={"width": width, "height": height}, color_scheme=scheme).new_page()
    view.goto(address)
    view.locator('html[data-state="flying"]').wait_for(state="attached")
    return view


def flown(address: str, shots: list[Image.Image]) -> None:
    """Look at the flight at `address`, and step two coefficient groups."""
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path="/usr/bin/chromium", args=["--no-sandbox"])
        views = [opened(browser, address, *view) for view in VIEWS]
        for name in ("Pitching moment −10 %", "Pitching moment −10 %", "Lift +10 %"):
            views[0].wait_for_timeout(1000 * WAIT_S / 3)
            views[0].get_by_role("button", name=name).click()
        views[0].wait_for_timeout(1000 * WAIT_S)
        views[0].mouse.move(0, 0)
        shots += [Image.open(io.BytesIO(view.screenshot())) for view in views]
        browser.close()


def main(folder: Path) -> None:
    """Draw it into `folder`."""
    shots: list[Image.Image] = []
    watching: list[threading.Thread] = []

    def watch(address: str) -> None:
        watching.append(threading.Thread(target=flown, args=(address, shots)))
        watching[0].start()

    with tempfile.TemporaryDirectory() as made:
        run("case1", stop=25.0, live=watch, out=Path(made))
        watching[0].join()
    width = sum(one.width for one in shots) + GAP * (len(shots) - 1)
    picture, at = Image.new("RGB", (width, shots[0].height), "white"), 0
    for one in shots:
        picture.paste(one, (at, 0))
        at += one.width + GAP
    picture.quantize(256).save(folder / "live.png", optimize=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else PICTURES)
