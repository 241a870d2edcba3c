"""Draws a campaign's report as browsers show it, one in light and one in dark: docs/pictures/campaign_report.png.

python docs/draw_campaign_report.py [RESULTS], the folder of the campaign `case1`, which is flown where there is none.
"""
import io
import sys
import tempfile
from pathlib import Path

from PIL import Image
from playwright.sync_api import Browser

from cosim.campaign.campaign import campaign
from cosim.vehicle.campaigns import Laws

DOCS = Path(__file__).parent
sys.path.insert(0, str(DOCS.parent / "tests"))
from browser import chromium  # noqa: E402

VIEWS = ((1366, 1000, "light"), (390, 1000, "dark"))  # px, px, scheme
GAP = 24  # px


def shot(browser: Browser, page: Path, width: int, height: int, scheme: str) -> Image.Image:
    """The runs, with one open whose signals were kept; another one is pointed at."""
    view = browser.new_context(viewport={"width": width, "height": height}, color_scheme=scheme).new_page()
    view.goto(page.as_uri())
    view.locator('html[data-overview="1"]').wait_for(state="attached", timeout=60_000)
    view.evaluate("() => { const {variant, place} = PAGE.curves.signals[0]; open_run(variant, place, false); }")
    view.wait_for_timeout(2000)
    view.evaluate("scrollTo(0, document.getElementById('explore').getBoundingClientRect().top + scrollY)")
    view.wait_for_timeout(500)
    if width > 1000:
        box = view.locator("#clouds .plot").nth(1).bounding_box()
        assert box is not None
        view.mouse.move(box["x"] + box["width"] * 0.32, box["y"] + box["height"] * 0.62)
    else:
        view.evaluate("scrollTo(0, document.getElementById('pick').getBoundingClientRect().bottom + scrollY)")
    view.wait_for_timeout(1000)
    return Image.open(io.BytesIO(view.screenshot()))


def main(results: Path) -> None:
    """Draw the report of `results`."""
    with chromium() as browser:
        shots = [shot(browser, results / "report.html", *view) for view in VIEWS]
    width = sum(one.width for one in shots) + GAP * (len(shots) - 1)
    picture, at = Image.new("RGB", (width, shots[0].height), "white"), 0
    for one in shots:
        picture.paste(one, (at, 0))
        at += one.width + GAP
    picture.quantize(256).save(DOCS / "pictures" / "campaign_report.png", optimize=True)


if __name__ == "__main__":
    if len(sys.argv) > 1:
        main(Path(sys.argv[1]))
    else:
        with tempfile.TemporaryDirectory() as folder:
            campaign(DOCS / "campaigns" / "case1.yaml", Path(folder) / "case1", subjects=[Laws])
            main(Path(folder) / "case1")
