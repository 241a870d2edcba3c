"""Draws the pages as browsers show them, wide and narrow, light and dark: docs/pictures/page_*.png, playground.png and
live.png.

    .venv/bin/python docs/draw_pages.py [PAGE]...     # else all of them
"""
import io
import shlex
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from PIL import Image
from playwright.sync_api import Browser, Page

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent / "tests"))
from browser import Watched, chromium  # noqa: E402

AHV = Path(sys.executable).with_name("ahv")
# Rows of views: px, scheme, and what is at the top of the window.
VIEWS = (((1366, "light", "header"), (390, "dark", "header")), ((1366, "dark", "header"), (390, "light", "#charts")))
HEIGHT, GAP, SCALE = 800, 16, 0.75  # px, px, 1
# The commands that make each page, in a folder that has the examples and the scenarios.
PAGES = {
    "page_run": (["run case1 --preset printed --out run"], "run/report.html"),
    "page_compare": (["compare uncertain.yaml --controller neural --controller resilient --out compared"],
                     "compared/report.html"),
    "page_view": (["run case1 --preset printed --out printed", "run case1 --out calibrated",
                   "run case1 --preset robust --out robust", "run case1 --controller resilient --out resilient",
                   "run case1 --controller backstepping --out backstepping",
                   "view printed calibrated robust resilient backstepping --out view.html"], "view.html"),
    "page_simulate": (["build spring_model.py pid_model.py valve_model.py --flavour native --fmi 2 --out fmus",
                       "simulate positioner.yaml --out positioner"], "positioner/report.html"),
    "page_check": (["build spring_model.py pid_model.py valve_model.py --flavour native --fmi 2 --out fmus",
                    "check fmus/native/Spring.fmu fmus/native/Pid.fmu fmus/native/Valve.fmu --out check.html"],
                   "check.html"),
    "page_campaign": (["campaign case1_campaign.yaml --out campaign"], "campaign/report.html"),
    "playground": (["playground --out playground.html"], "playground.html"),
    "live": (["run case1 --real-time 1 --live --out live"], ""),
}
STEPS = ("Pitching moment −10 %", "Pitching moment −10 %", "Lift +10 %")  # on the live page
AT = {"page_run": "12", "page_compare": "6", "page_view": "15", "page_simulate": "0.2"}  # s, where the cursor is


@contextmanager
def address(name: str, place: Path) -> Iterator[str]:
    """Where the page is: a file, or what the last command serves while it runs."""
    *before, last = PAGES[name][0]
    for command in before if name == "live" else [*before, last]:
        done = subprocess.run([AHV, *shlex.split(command)], cwd=place, capture_output=True, text=True)
        if done.returncode > 1:  # a departure is 1
            sys.exit(done.stderr)
    if name != "live":
        yield (place / PAGES[name][1]).as_uri()
        return
    with subprocess.Popen([AHV, *shlex.split(last)], cwd=place, stderr=subprocess.PIPE, text=True) as process:
        assert process.stderr
        yield next(line.strip() for line in process.stderr if line.startswith("http"))
        process.terminate()


def ready(name: str, page: Page) -> None:
    """Wait for the curves, and do what the picture shows."""
    if name == "playground":
        page.locator('html[data-flights="1"]').wait_for(state="attached")
        page.get_by_role("button", name="Fly the printed gains").click()
        page.locator('html[data-flights="2"]').wait_for(state="attached")
        page.mouse.move(0, 0)
    elif name == "live":
        page.locator('html[data-state="flying"]').wait_for(state="attached")
        for step in STEPS if page.get_by_text("Steps made (0)").count() else ():
            page.wait_for_timeout(2500)
            page.get_by_role("button", name=step).click()
            page.mouse.move(0, 0)
        page.wait_for_timeout(4000)
    elif name in AT:
        page.locator('html[data-drawn="1"]').wait_for(state="attached")
        page.locator("#at").fill(AT[name])
    page.wait_for_timeout(500)


def shot(browser: Browser, name: str, url: str, width: int, scheme: str, top: str) -> Image.Image:
    """The window, with the element `top` at its top where the page has one."""
    watched = Watched(browser, width, HEIGHT, color_scheme=scheme)
    watched.page.goto(url)
    ready(name, watched.page)
    watched.page.evaluate("top => document.querySelector(top)?.scrollIntoView()", top)
    watched.page.wait_for_timeout(300)
    picture = Image.open(io.BytesIO(watched.page.screenshot()))
    watched.context.close()
    return picture.convert("RGB")


def composed(rows: list[list[Image.Image]]) -> Image.Image:
    """Rows of pictures of the same height, as one."""
    width = sum(one.width for one in rows[0]) + GAP * (len(rows[0]) - 1)
    picture = Image.new("RGB", (width, len(rows) * (HEIGHT + GAP) - GAP), "#808080")
    for r, row in enumerate(rows):
        x = 0
        for one in row:
            picture.paste(one, (x, r * (HEIGHT + GAP)))
            x += one.width + GAP
    size = round(picture.width * SCALE), round(picture.height * SCALE)
    small = picture.resize(size, Image.Resampling.LANCZOS)
    return small.quantize(256, Image.Quantize.MAXCOVERAGE, kmeans=4, dither=Image.Dither.NONE)


def main(names: list[str]) -> None:
    """Draw these pages into docs/pictures."""
    with tempfile.TemporaryDirectory() as made, chromium() as browser:
        place = Path(made)
        for file in (*HERE.glob("examples/*.*"), *HERE.glob("scenarios/*.yaml")):
            shutil.copy(file, place)
        text = (HERE / "campaigns" / "case1.yaml").read_text()
        (place / "case1_campaign.yaml").write_text(text.replace("runs: 2000", "runs: 200").replace("0.01", "0.2"))
        for name in names:
            with address(name, place) as url:
                rows = [[shot(browser, name, url, *view) for view in row] for row in VIEWS]
            composed(rows).save(HERE / "pictures" / f"{name}.png", optimize=True)


if __name__ == "__main__":
    main(sys.argv[1:] or list(PAGES))
