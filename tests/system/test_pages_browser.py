"""Pages of runs in headless Chromium: they open from the disk, say nothing, zoom, and show what is under the cursor."""
import re
from pathlib import Path
from xml.sax.saxutils import quoteattr

import pytest
from altered import redescribed
from browser import Watched, chromium, tabbed
from test_pages import ATTACKS, made_up

from cosim.pages.flown import Panel
from cosim.pages.write import page, plain
from cosim.systems.simulate import simulate
from cosim.vehicle.compare import compare
from cosim.vehicle.run import run
from cosim.vehicle.variants import variant
from cosim.vehicle.view import view

pytestmark = pytest.mark.slow

NUMBER = r"-?\d[\d.e+-]*"
# The pages with curves: how many panels each has at least, and how many signals.
CURVES = {"case2": (12, 20), "printed": (12, 20), "five": (12, 80), "compared": (12, 20), "simulated": (2, 5)}


@pytest.fixture(scope="module")
def files(tmp_path_factory, native_fmus) -> dict[str, Path]:
    """The page of a whole run, of one that departs, of five runs, of a comparison, of a simulated FMU, of a check."""
    place = tmp_path_factory.mktemp("pages")
    for preset in ("printed", "robust", "calibrated"):
        run("case1", preset=preset, out=place / preset)
    for amplitude in (0.2, 0.3):
        run("case1", uncertainty=amplitude, out=place / f"amplitude {amplitude}")
    run("case2", out=place / "case2")
    view([path for path in sorted(place.iterdir()) if path.name != "case2"], place / "five.html")
    compare("hold", [], stop=2, out=place / "compared", runs=[variant("mine:--preset robust")])
    simulate(native_fmus["AhvScenario"], 0.1, 20.0, None, place / "simulated")
    (place / "check").mkdir()
    checked = plain("Check of x.fmu", [("x.fmu", "<p>passed</p>", True)], "ahv check")
    (place / "check" / "report.html").write_text(checked)
    return {name: place / name / "report.html" for name in (*CURVES, "check")} | {"five": place / "five.html"}


@pytest.fixture(scope="module")
def browser():
    with chromium() as found:
        yield found


def opened(browser, file: Path, width: int = 1366, **options) -> Watched:
    """The page, when its curves are drawn."""
    watched = Watched(browser, width, 900, **options)
    watched.page.goto(file.as_uri())
    drawn(watched, 1)
    return watched


def drawn(watched: Watched, turns: int) -> None:
    """Until the curves were drawn so many times."""
    watched.page.locator(f'html[data-drawn="{turns}"]').wait_for(state="attached", timeout=30_000)
    watched.page.wait_for_timeout(300)


def shown(page) -> list[float]:
    """The time that the page shows, and every panel."""
    times = page.evaluate("state.panels.map(({plot}) => [plot.x_range.start, plot.x_range.end])")
    assert all(one == times[0] for one in times)
    return times[0]


@pytest.mark.parametrize("name", CURVES)
def test_zoom_and_hover_on_every_page_which_says_nothing_and_asks_for_nothing(browser, files, name):
    watched = opened(browser, files[name])
    page, (panels, signals) = watched.page, CURVES[name]
    assert page.locator("#charts canvas").count() >= panels and files[name].stat().st_size < 3_000_000
    start, end = shown(page)
    tops = [figure.bounding_box()["y"] for figure in page.locator("#charts figure").all()]
    box = page.locator("#charts .plot").last.bounding_box()
    page.mouse.wheel(0, box["y"] - 300)
    page.wait_for_timeout(300)
    box = page.locator("#charts .plot").last.bounding_box()
    left, width = box["x"] + 78, box["width"] - 90
    page.mouse.move(left + 0.5 * width, box["y"] + 60)
    page.wait_for_timeout(200)
    values = page.locator("#charts output").all_inner_texts()
    assert len(values) >= signals and sum(bool(re.fullmatch(NUMBER, value)) for value in values) >= signals / 2
    assert all(re.fullmatch(f"{NUMBER}|–", value) for value in values)
    assert page.locator("#now").inner_text().startswith("At ") and page.locator("#now").bounding_box()["y"] < 900
    moved = page.evaluate("scrollY")
    assert [figure.bounding_box()["y"] + moved for figure in page.locator("#charts figure").all()] == tops
    page.mouse.down()
    page.mouse.move(left + 0.75 * width, box["y"] + 90, steps=5)
    page.mouse.up()
    page.wait_for_timeout(300)
    assert shown(page) == pytest.approx([start + 0.5 * (end - start), start + 0.75 * (end - start)],
                                        abs=0.02 * (end - start))
    page.mouse.dblclick(left + 0.5 * width, box["y"] + 60)
    page.wait_for_timeout(300)
    assert shown(page) == [start, end]
    assert watched.said == [] and watched.elsewhere() == []


def test_the_time_is_chosen_by_mouse_and_keyboard(browser, files):
    watched = opened(browser, files["case2"])
    page = watched.page
    box = page.locator("#charts .plot").first.bounding_box()
    left, right = box["x"] + 78, box["x"] + box["width"] - 12
    page.mouse.move(left + 0.25 * (right - left), box["y"] + 60)
    page.mouse.down()
    page.mouse.move(left + 0.5 * (right - left), box["y"] + 90, steps=5)
    page.mouse.up()
    page.wait_for_timeout(200)
    assert shown(page) == pytest.approx([75, 150], abs=3)
    assert float(page.locator("#from").input_value()) == pytest.approx(75, abs=3)
    low, high = page.evaluate("[state.panels[0].plot.y_range.start, state.panels[0].plot.y_range.end]")
    assert 7900 < low < high < 8500  # the values within this time fill the panel
    page.locator("#from").fill("100")
    page.locator("#from").press("Enter")
    page.locator("#to").fill("120")
    page.locator("#to").press("Tab")
    assert shown(page) == [100, 120]
    assert watched.said == []


def test_the_cursor_tells_the_values_of_all_curves(browser, files):
    watched = opened(browser, files["case2"])
    page = watched.page
    box = page.locator("#charts .plot").nth(2).bounding_box()
    page.mouse.move(box["x"] + 78 + (box["width"] - 90) * 0.25, box["y"] + 60)
    page.wait_for_timeout(200)
    assert float(page.locator("#charts output").first.inner_text()) == pytest.approx(8030, abs=10)
    told = page.locator("#now").inner_text()
    assert "scales of the coefficients: thrust, lift, drag, moment, forces 0.6 to 1.4" in told
    page.locator("#at").fill("120")
    assert "At 120 s: nothing is marked." in page.locator("#now").inner_text()


def test_signals_are_chosen_by_name_and_angles_by_unit(browser, files):
    watched = opened(browser, files["case2"])
    page = watched.page
    elevator = "state.panels.find((p) => p.title === 'Elevator').curves[0].course.y"
    assert 15 < page.evaluate(f"Math.max(...{elevator})") < 25
    page.locator("#angles").select_option("rad")
    drawn(watched, 2)
    assert 0.2 < page.evaluate(f"Math.max(...{elevator})") < 0.4
    page.get_by_text("Signals (").click()
    page.locator("#none").click()
    drawn(watched, 3)
    assert page.locator("#charts figure").count() == 0
    page.locator("#search").fill("scale lift")
    page.locator("#names input").first.focus()
    page.keyboard.press("Space")
    drawn(watched, 4)
    assert page.locator("#charts h3").all_inner_texts() == ["Scales of the coefficients"]
    page.locator("#first").click()
    drawn(watched, 5)
    assert page.locator("#charts figure").count() == 12 and watched.said == []


# 683 px with two device pixels each is a zoom of 200 % at 1366 px.
@pytest.mark.parametrize("width, scale, scheme", [(320, 1, "light"), (390, 1, "dark"), (683, 2, "light"),
                                                  (1366, 1, "dark")])
@pytest.mark.parametrize("name", ["case2", "five", "simulated"])
def test_it_fits_its_width_and_scheme(browser, files, name, width, scale, scheme):
    watched = opened(browser, files[name], width, color_scheme=scheme, device_scale_factor=scale,
                     reduced_motion="reduce")
    watched.page.evaluate("document.querySelectorAll('details').forEach((details) => { details.open = true; })")
    assert watched.page.evaluate("[document.documentElement.scrollWidth <= innerWidth, document.getAnimations().length]"
                                 ) == [True, 0]
    ink, paper = watched.page.evaluate("[getComputedStyle(document.body).color, "
                                       "getComputedStyle(document.body).backgroundColor]")
    light = [sum(map(int, re.findall(r"\d+", colour))) for colour in (ink, paper)]
    assert (light[0] < light[1]) == (scheme == "light")


@pytest.mark.parametrize("name, least", [("case2", 15), ("five", 15), ("simulated", 8), ("check", 3)])
def test_tab_reaches_every_control_and_shows_which(browser, files, name, least):
    watched = opened(browser, files[name]) if name in CURVES else Watched(browser)
    if name not in CURVES:
        watched.page.goto(files[name].as_uri())
    reached = tabbed(watched.page)
    assert len(reached) >= least and all(reached)


def test_it_prints_dark_curves_in_light_colours(browser, files, tmp_path):
    watched = opened(browser, files["printed"], color_scheme="dark")
    watched.page.pdf(path=tmp_path / "page.pdf")
    assert (tmp_path / "page.pdf").read_bytes().count(b"/Subtype /Image") >= 12 and watched.said == []
    watched.page.emulate_media(media="print")
    assert "invert" in watched.page.evaluate("getComputedStyle(document.querySelector('.plot')).filter")
    watched.page.screenshot(path=tmp_path / "print.png")


def test_texts_of_strangers_run_nowhere(browser, tmp_path):
    for i, attack in enumerate(ATTACKS):
        file = tmp_path / f"{i}.html"
        file.write_text(page(attack, [made_up(attack), made_up(attack)], [Panel(attack, (attack,))], attack, [attack]),
                        encoding="utf-8")
        watched = opened(browser, file)
        watched.page.get_by_text("Signals (").click()
        assert watched.page.locator("img, iframe, b, svg:not(.key svg), a:not(.skip)").count() == 0
        assert watched.said == [] and watched.elsewhere() == []
        watched.context.close()
    (tmp_path / "check.html").write_text(plain(ATTACKS[1], [(ATTACKS[2], "<p></p>", True)]), encoding="utf-8")
    watched = Watched(browser)
    watched.page.goto((tmp_path / "check.html").as_uri())
    assert watched.page.locator("img").count() == 0 and watched.said == []


def test_names_of_files_folders_variants_and_variables_run_nothing(browser, native_fmus, tmp_path):
    attacks = [attack for attack in ATTACKS if "\0" not in attack]
    names = [attack.replace("/", "\\") for attack in attacks]
    place = tmp_path / "a<" / "script><img src=x onerror=alert(1)>"  # a path with </script>
    place.mkdir(parents=True)
    description, told, unit = (quoteattr(attacks[i]) for i in (1, 2, 3))
    fmu = redescribed(native_fmus["AhvScenario"], place / "<svg onload=alert(1)>.fmu",
                      ('name="V_command"', f"name={told}"), ('name="ft/s"', f"name={unit}"),
                      ('unit="ft/s"', f"unit={unit}"), ('generationTool="', f"generationTool={description[:-1]}"))
    simulate(fmu, 0.1, 1.0, None, place / "simulated", command=attacks[1])
    for i, name in enumerate(names):
        run("hold", stop=0.1, out=place / name / str(i))
    view([place / "simulated", *(place / name / str(i) for i, name in enumerate(names))], place / "view.html", names[1])
    compare("hold", [], stop=0.1, out=place / "compared",
            runs=[variant(f"{attack}:--preset robust") for attack in ATTACKS if not re.search(r"[:\0]", attack)])
    pages = list(place.glob("*.html")) + [place / name / "report.html" for name in ("simulated", "compared")]
    assert len(pages) == 3
    for file in pages:
        watched = opened(browser, file)
        watched.page.evaluate("document.querySelectorAll('details').forEach((details) => { details.open = true; })")
        assert watched.page.locator("img, iframe, b, svg:not(.key svg), a:not(.skip)").count() == 0
        assert watched.said == [] and watched.elsewhere() == []
