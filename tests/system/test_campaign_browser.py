"""The report of a campaign in headless Chromium: it opens from the disk, says nothing, zooms, tells, and opens runs."""
import re
import shlex

import pyarrow.parquet as pq
import pytest
from browser import Watched, chromium
from campaign_pages import made_up, page_of
from test_pages import ATTACKS

from cosim.campaign.plan import load
from cosim.campaign.rerun import command
from cosim.campaign.store import Store
from cosim.campaign.sweep import sweep
from cosim.vehicle.campaigns import Laws

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def files(tmp_path_factory, native_fmus):
    """The pages of 2,000 runs that are made up, of a few that flew, and of a grid."""
    place = tmp_path_factory.mktemp("campaigns")
    store = made_up(place / "many", "many", 2000)
    (place / "many" / "report.html").write_text(page_of(store), encoding="utf-8")
    metric = ["climb=final(plant.h) - min(plant.h)"]
    about = {"scenario": "case1", "stop": 0.5, "signals": {"share": 1}}
    for name, words in (("map", ["controller.k_gamma=0.2:0.6:3", "plant.mass=280,300"]),
                        ("lines", ["controller.k_gamma=0.2:0.6:5"])):
        sweep({"name": name, **about}, words, metric, ["climb < 0.01"], place / name, workers=1, subjects=[Laws])
    return {name: place / name / "report.html" for name in ("many", "map", "lines")}


@pytest.fixture(scope="module")
def browser():
    with chromium() as found:
        yield found


def opened(browser, file, width=1366, **options):
    """The page, when all is drawn."""
    watched = Watched(browser, width, 900, **options)
    watched.page.goto(file.as_uri())
    watched.page.locator('html[data-overview="1"]').wait_for(state="attached", timeout=60_000)
    watched.page.wait_for_timeout(500)
    return watched


def at(page, place, panel=0):
    """Where on the screen the run at a place is in a panel of the scatter."""
    box = page.locator("#clouds .plot").nth(panel).bounding_box()
    x, y = page.evaluate("""([place, panel]) => {
        const {plot, x, d} = look_at.panels[panel], {y} = look_at, along = look_at.log ? Math.log10 : (v) => v;
        const left = (VARIANTS[look_at.v].draws[d].values[place] - x.start) / (x.end - x.start);
        const up = (along(look_at.values[place]) - along(y.start)) / (along(y.end) - along(y.start));
        return [left * plot.inner_width, (1 - up) * plot.inner_height];
    }""", [place, panel])
    return box["x"] + 78 + x, box["y"] + 4 + y


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("width", [390, 1366])
@pytest.mark.parametrize("name", ["many", "map", "lines"])
def test_it_opens_from_the_disk_fits_says_nothing_and_asks_for_nothing(browser, files, name, width, scheme):
    watched = opened(browser, files[name], width, color_scheme=scheme)
    page = watched.page
    assert page.locator("canvas").count() >= 6
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    ink, paper = page.evaluate("[getComputedStyle(document.body).color, "
                               "getComputedStyle(document.body).backgroundColor]")
    light = [sum(map(int, re.findall(r"\d+", colour))) for colour in (ink, paper)]
    assert (light[0] < light[1]) == (scheme == "light")
    assert watched.said == [] and watched.elsewhere() == [] and files[name].stat().st_size < 4_000_000
    watched.context.close()


def test_pointing_tells_a_run_and_a_click_opens_its_command_and_curves(browser, files):
    watched = opened(browser, files["many"])
    page = watched.page
    place = page.evaluate("look_at.runs.find((place) => !succeeded(0, place))")
    x, y = at(page, place)
    page.mouse.move(x, y)
    page.wait_for_timeout(200)
    told = page.locator("#hover").inner_text()
    run = int(re.match(r"run (\d+), neural: departed at", told)[1])  # it, or one as near
    assert "m (many): " in told and "many of x (many): " in told
    page.mouse.click(x, y)
    page.wait_for_timeout(500)
    assert page.locator("#which").inner_text() == f"Run {run}, neural"
    assert page.locator("#ended").inner_text().endswith(f": many at t = {run}.5 s")
    assert page.locator("#command").inner_text().endswith(f"results/run/many-neural-{run}")
    assert page.evaluate("look_at.panels.map(({rings}) => rings[0].data.x.length)") == [1, 1]
    assert page.locator("#opened canvas").count() >= 2
    page.locator("#beside").check()
    page.wait_for_timeout(1500)
    assert "resilient" in page.locator("#charts .key").first.inner_text()
    assert watched.said == []


def test_dragging_narrows_the_runs_and_a_double_click_ends_it(browser, files):
    watched = opened(browser, files["many"])
    page = watched.page
    box = page.locator("#clouds .plot").first.bounding_box()
    page.mouse.move(box["x"] + 100, box["y"] + 30)
    page.mouse.down()
    page.mouse.move(box["x"] + 180, box["y"] + 230, steps=5)
    page.mouse.up()
    page.wait_for_timeout(500)
    within = page.evaluate("listed().places.length")
    assert 0 < within < 1000
    assert page.locator("#listed").inner_text().startswith(f"{within} of 2,000 runs of neural, those within the zoom")
    assert len(set(page.evaluate("look_at.panels.map(({plot}) => plot.y_range.start)"))) == 1
    page.mouse.dblclick(box["x"] + 140, box["y"] + 60)
    page.wait_for_timeout(500)
    assert page.locator("#listed").inner_text() == "2,000 of 2,000 runs of neural: 1 to 12"
    page.locator("#drag").select_option("pan")
    before = page.evaluate("look_at.y.start")
    page.mouse.move(box["x"] + 140, box["y"] + 60)
    page.mouse.down()
    page.mouse.move(box["x"] + 160, box["y"] + 100, steps=5)
    page.mouse.up()
    page.wait_for_timeout(400)
    assert page.evaluate("look_at.y.start") != before and watched.said == []
    page.locator("#reset").click()
    page.wait_for_timeout(400)
    assert page.evaluate("look_at.y.start") == before


def test_the_keyboard_finds_filters_and_opens(browser, files):
    watched = opened(browser, files["many"])
    page, reached = watched.page, []
    for _ in range(11):
        page.keyboard.press("Tab")
        reached.append(page.evaluate("document.activeElement.id || document.activeElement.textContent"))
    assert reached[1].startswith("run ") and reached[3:9] == ["variant", "figure", "drag", "reset", "number", "open"]
    page.locator("#number").fill("1234")
    page.keyboard.press("Enter")
    page.wait_for_timeout(300)
    assert page.locator("#which").inner_text() == "Run 1234, neural"
    page.locator("#number").fill("5000")
    page.keyboard.press("Enter")
    assert page.locator("#unknown").inner_text() == "The page has no run 5000."
    page.locator("#which-runs").select_option("successes")
    first = page.locator("#list tbody button").first
    first.focus()
    page.keyboard.press("Enter")
    page.wait_for_timeout(300)
    assert page.locator("#ended").inner_text() == "success"
    page.locator("#better").focus()
    rank = int(page.locator("#rank").inner_text().split()[0].replace(",", ""))
    page.keyboard.press("Enter")
    assert page.locator("#rank").inner_text().startswith(f"{rank + 1:,} of 2,000")
    page.locator("#list th button").last.press("Enter")
    values = [float(cell) for cell in page.locator("#list td:last-child").all_inner_texts()]
    assert values == sorted(values, reverse=True) and len(values) == 12
    assert watched.said == []


def test_every_command_is_that_of_the_terminal(browser, files):
    folder = files["map"].parent
    plan = load(folder / "campaign.yaml", Laws)
    rows = pq.read_table(Store(folder, plan).file("runs")).to_pylist()
    watched = opened(browser, files["map"])
    assert watched.page.evaluate("Array.from(FLOWN.keys(), (place) => command(0, place))") == [
        command(plan, row) for row in rows]
    numbers = [0.1, 1e-4, 1e-5, 12345678.9, 1e15, 1e16, 1.5e17, 5e-324, -0.0, 0.0, -3.0, 1 / 3, 1e22, 2.5e-7]
    assert watched.page.evaluate("(numbers) => numbers.map(written)", numbers) == [repr(x) for x in numbers]
    words = ["a", "it's", "", "a b", "x[1]=2.0", "-1", "é"]
    assert watched.page.evaluate("(words) => words.map(quoted)", words) == [shlex.quote(word) for word in words]


@pytest.mark.parametrize("name", ["map", "lines"])
def test_a_cell_of_a_grid_tells_its_run_and_opens_it(browser, files, name):
    watched = opened(browser, files[name])
    page = watched.page
    box = page.locator("#sweep .plot").first.bounding_box()
    page.mouse.move(box["x"] + box["width"] - 30, box["y"] + 20)
    page.wait_for_timeout(200)
    told = page.locator("#hover").inner_text()
    run = int(re.match(r"run (\d+), neural", told)[1])
    assert "climb: " in told and "controller.k_gamma (1/s): 0.6" in told
    page.mouse.click(box["x"] + box["width"] - 30, box["y"] + 20)
    page.wait_for_timeout(300)
    assert page.locator("#which").inner_text() == f"Run {run}, neural" and "--set controller.k_gamma=0.6" in \
        page.locator("#command").inner_text()
    assert page.locator("#charts canvas").count() >= 5 and watched.said == []


def test_it_prints(browser, files, tmp_path):
    watched = opened(browser, files["map"], color_scheme="dark")
    watched.page.pdf(path=tmp_path / "page.pdf")
    assert (tmp_path / "page.pdf").read_bytes().count(b"/Subtype /Image") >= 4 and watched.said == []
    watched.page.emulate_media(media="print")
    assert not watched.page.locator("#pick").is_visible() and watched.page.locator("#command").is_visible()


def test_texts_of_strangers_run_nowhere(browser, tmp_path):
    for i, attack in enumerate([*ATTACKS, "$$x$$ \\(y\\) \\[z\\]"]):
        file = tmp_path / f"{i}.html"
        file.write_text(page_of(made_up(tmp_path / "made", attack, 40, (attack, f"{attack} 2"))), encoding="utf-8")
        watched = opened(browser, file)
        page = watched.page
        page.locator("#list tbody button").first.click()
        page.mouse.move(*at(page, page.evaluate("opened.place")))
        page.wait_for_timeout(200)
        assert page.locator("img, iframe, b, svg:not(.key svg), a:not(.skip)").count() == 0, attack
        assert watched.said == [] and watched.elsewhere() == [], attack
        watched.context.close()
