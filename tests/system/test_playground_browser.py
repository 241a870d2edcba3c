"""The page that flies in a browser, in Chromium: its numbers beside those of `ahv run`, and how it behaves."""
import base64
import json
import re
import shlex
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("playwright", reason="no Playwright: pip install playwright")
from browser import CHROMIUM, Watched, chromium

from cosim.master.fly import fly
from cosim.playground import write
from cosim.playground.compile import module
from cosim.vehicle.closed_loop import closed_loop
from cosim.vehicle.registry import LAWS, MODELS, PLANTS
from cosim.vehicle.run import run
from cosim.vehicle.scenarios import BUILT_IN

pytestmark = [pytest.mark.slow,
              pytest.mark.skipif(not CHROMIUM.exists(), reason="no Chromium: apt-get install chromium")]

AHV = Path(sys.executable).with_name("ahv")
SIGNALS = """async ([request, names]) => {
  const { column, count } = flown(about, await compiled(about.module), request);
  let text = "";
  for (const name of names) {
    const bytes = new Uint8Array(column(name).slice().buffer);
    for (let i = 0; i < bytes.length; i += 8192) text += String.fromCharCode(...bytes.subarray(i, i + 8192));
  }
  return [count, btoa(text)];
}"""


@pytest.fixture(scope="module")
def file(native_fmus, tmp_path_factory) -> Path:
    out = tmp_path_factory.mktemp("playground") / "page.html"
    subprocess.run([AHV, "playground", "--out", out], check=True)
    return out


@pytest.fixture(scope="module")
def browser():
    with chromium() as found:
        yield found


def opened(browser, file, fragment="", width=1366, flights=1, **options) -> Watched:
    """The page, when it has flown what the fragment says."""
    watched = Watched(browser, width, 900, **options)
    watched.page.goto(f"{file.as_uri()}{fragment}")
    wait(watched, flights)
    return watched


def wait(watched: Watched, flights: int) -> None:
    """Until the page has flown so many flights, and none is under way."""
    watched.page.locator(f'html[data-flights="{flights}"]').wait_for(state="attached", timeout=20_000)


def open_all(page) -> None:
    """Unfold everything."""
    closed = page.locator("details:not([open]) > summary")
    while closed.count():
        closed.first.click()


def test_it_opens_as_a_file_says_nothing_and_asks_for_nothing(browser, file):
    assert file.stat().st_size < 2_000_000
    watched = opened(browser, file)
    watched.page.get_by_role("button", name="Fly the printed gains").click()
    wait(watched, 2)
    assert watched.page.locator("#outcome").inner_text() == "Departed at 19.68 s"
    watched.page.get_by_role("button", name="Fly the repaired gains").click()
    wait(watched, 3)
    assert watched.page.locator("#outcome").inner_text() == "Flew all 100 s"
    assert watched.said == [] and watched.elsewhere() == []


def test_the_module_is_that_of_the_fmus(file, native_fmus):
    data = json.loads(re.search(r'id="about">(.*?)</script>', file.read_text(), re.DOTALL)[1])
    content = base64.b64decode(data["module"])
    assert content == module()
    for name in MODELS:
        with zipfile.ZipFile(native_fmus[name]) as fmu:
            assert re.search(rb'guid="({.*?})"', fmu.read("modelDescription.xml"))[1] in content


@pytest.mark.parametrize("plant", PLANTS)
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("case", ["case1", "case2"])
def test_all_signals_are_those_of_ahv_run_to_the_last_bit(browser, file, case, law, plant):
    watched = opened(browser, file, f"#case={case}&law={law}&plant={plant}", bypass_csp=True)
    flown = fly(closed_loop(BUILT_IN[case], law, plant, flavour="native").system, 0.01, BUILT_IN[case].stop)
    count, text = watched.page.evaluate(SIGNALS, [watched.page.evaluate("request(state)"), list(flown)])
    rows = np.frombuffer(base64.b64decode(text)).reshape(-1, count).T
    took = [watched.page.evaluate("shown.took")]
    for n in range(2, 8):
        watched.page.evaluate("pilot.fly(request(state))")
        wait(watched, n)
        took.append(watched.page.evaluate("shown.took"))
    print(f"{case} {law} {plant}: {np.median(took):.0f} ms a flight")
    assert np.array_equal(rows, flown.signals)


MOVES = [("controller.k_gamma", 700), ("controller.kV1", 300), ("controller.kh", 620), ("controller.mu", 450),
         ("plant.mass", 640), ("plant.CM_elevator", 480), ("scenario.V_command_step", 800),
         ("controller.elevator_max", 690), ("plant.psi_1", 30),
         ("scenario.scale_lift_sine_phase", 200)]


def metrics_of(command: str, out: Path) -> dict:
    """The figures that the command prints."""
    done = subprocess.run([AHV, *shlex.split(command)[1:], "--json", "--out", out], capture_output=True, text=True)
    assert done.returncode in (0, 1), done.stderr
    return {**json.loads(done.stdout), "said": done.stderr}


def same(mine: dict, theirs: dict) -> None:
    """Whether the figures of the page are those of `ahv run --json`."""
    assert mine["finished"] == theirs["finished"]
    assert (None if mine["finished"] else mine["reached"]) == pytest.approx(theirs["departed_at_s"])
    for name, value in mine["metrics"].items():
        quantity, _, kind = name.partition(".")
        expected = theirs[quantity][kind] if kind else theirs[quantity]
        assert value == (expected if expected is None else pytest.approx(expected, rel=1e-6, abs=1e-9)), name


def test_ten_moves_of_sliders_give_what_their_commands_give(browser, file, tmp_path):
    watched = opened(browser, file, bypass_csp=True)
    page = watched.page
    open_all(page)
    for n, (name, position) in enumerate(MOVES):
        page.locator(f'.row:has([id="set-{name}"]) input[type=range]').fill(str(position))
        wait(watched, n + 2)
        command = page.locator("#command").input_value()
        assert f"--set {name}=" in command and command.count("--set") == n + 1
        shown = page.evaluate("({...shown, series: null})")
        theirs = metrics_of(command, tmp_path / str(n))
        same(shown, theirs)
        if not shown["finished"]:
            assert shown["message"] in theirs["said"]
        for remark in shown["remarks"]:
            assert remark in theirs["said"]
    assert watched.said == [] and watched.elsewhere() == []


@pytest.mark.parametrize("fragment", [
    "case=case2&law=resilient&plant=instrumented&plant.elevator_bandwidth=20&plant.V_noise=1&plant.noise_seed=7",
    "case=case1&law=backstepping&step=0.02&stop=60&plant.V_start=8000",
    "case=case1&preset=coupled&plantPreset=estimated-coupling",
    "case=case1&preset=robust&scenario.scale_thrust_sine_phase=3.05&scenario.scale_lift_sine_phase=-2.31"
    "&scenario.scale_drag_sine_phase=-1.11&scenario.scale_moment_sine_phase=-2.42",
    "case=hold&controller.solve_trim=false&plant.start_at_trim=false&plant.theta_start=0.03",
])
def test_links_give_what_their_commands_give(browser, file, fragment, tmp_path):
    watched = opened(browser, file, f"#{fragment}", bypass_csp=True)
    assert watched.page.locator("#link").input_value().partition("#")[2] == fragment
    shown = watched.page.evaluate("({...shown, series: null})")
    theirs = metrics_of(watched.page.locator("#command").input_value(), tmp_path / "out")
    same(shown, theirs)
    if not shown["finished"]:
        assert shown["message"] in theirs["said"]


HOSTILE = [
    "case=<img src=x onerror=alert(1)>", "law=__proto__", "case=constructor", "preset=toString", "plant=hasOwnProperty",
    "step=1e-9", "stop=1e300", "step=NaN&stop=Infinity", "stop=-5", "step=0.03",
    "controller.k_gamma=<script>alert(1)</script>", "controller.__proto__=1", "__proto__.polluted=1",
    "plant.mass=-1", "plant.mass=1e999", "plant.mass=", "scenario.V_command=9000", "javascript:alert(1)",
    "controller.elevator_min=0.3&controller.elevator_max=0.1", "%E0%A4%A&plant.mass=%00", "controls", "&=&==&a=b=c",
    "x=" + "y" * 100_000, "&".join(f"plant.x{i}=1" for i in range(5000)),
]


@pytest.mark.parametrize("fragment", HOSTILE, ids=range(len(HOSTILE)))
def test_a_link_of_a_stranger_does_nothing_but_choose(browser, file, fragment):
    watched = opened(browser, file, f"#{fragment}")
    page = watched.page
    assert page.locator("#outcome").inner_text() == "Flew all 100 s"
    assert re.fullmatch(r"ahv run case1( --step 0\.\d+)?( --stop \d+)?", page.locator("#command").input_value())
    assert (page.locator("img, iframe").count(), page.locator("script").count()) == (0, 3)
    assert watched.said == [] and watched.elsewhere() == []


def test_texts_of_fmus_stay_texts(browser, native_fmus, tmp_path, monkeypatch):
    known = write.about()
    attack = '</script><img src=x onerror="console.log(1)"><b>'
    for fmu in known["fmus"].values():
        for variable in fmu["variables"].values():
            variable["description"] = variable["unit"] = attack
        fmu["presets"][attack] = {}
    for law in known["laws"].values():
        law["summary"] = attack
    monkeypatch.setattr(write, "about", lambda: known)
    (tmp_path / "page.html").write_text(write.page(module()))
    watched = opened(browser, tmp_path / "page.html")
    watched.page.get_by_text("Every parameter").click()
    assert watched.page.locator("img").count() == 0
    assert watched.page.get_by_text(attack).count() > 50
    assert watched.said == [] and watched.elsewhere() == []


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("width", [390, 1366])
def test_it_fits_its_width(browser, file, width, scheme):
    watched = opened(browser, file, "#case=case1&preset=printed", width, bypass_csp=True, color_scheme=scheme)
    open_all(watched.page)
    assert watched.page.evaluate("document.documentElement.scrollWidth") <= width
    ink, paper = watched.page.evaluate("[getComputedStyle(document.body).color, "
                                       "getComputedStyle(document.body).backgroundColor]")
    light = [sum(map(int, re.findall(r"\d+", colour))) for colour in (ink, paper)]
    assert (light[0] < light[1]) == (scheme == "light")
    charts = watched.page.locator("#charts figure")
    assert charts.count() == 8 and charts.first.bounding_box()["width"] <= width


def test_the_keyboard_does_it_all(browser, file):
    watched = opened(browser, file)
    page = watched.page
    page.keyboard.press("Tab")
    assert page.locator("a.skip:focus").count() == 1
    page.keyboard.press("Tab")
    assert page.locator("button:focus").inner_text() == "Fly the printed gains"
    page.keyboard.press("Enter")
    wait(watched, 2)
    assert page.locator("#outcome").inner_text().startswith("Departed")
    page.locator("#choice-law").focus()
    page.keyboard.press("ArrowDown")
    wait(watched, 3)
    assert "--controller resilient" in page.locator("#command").input_value()
    assert page.locator("#choice-law:focus").count() == 1
    slider = page.locator("#controls input[type=range]").first
    slider.focus()
    page.keyboard.press("ArrowRight")
    wait(watched, 4)
    assert "--set controller.k_gamma=" in page.locator("#command").input_value()
    page.locator("#spoken", has_text="Flew all").wait_for(state="attached")


def test_zoom_shows_a_part_of_the_time(browser, file):
    watched = opened(browser, file)
    page = watched.page
    over = page.locator("#charts .u-over").first
    box = over.bounding_box()
    page.mouse.move(box["x"] + 0.25 * box["width"], box["y"] + 20)
    page.mouse.down()
    page.mouse.move(box["x"] + 0.75 * box["width"], box["y"] + 20, steps=4)
    page.mouse.up()
    assert float(page.locator("#from").input_value()) == pytest.approx(25, abs=1)
    assert float(page.locator("#to").input_value()) == pytest.approx(75, abs=1)
    said = page.locator("#charts [role=img]").last.get_attribute("aria-label")
    assert re.search(r"from 2[456](\.\d+)? s to 7[456]", said)
    page.get_by_role("button", name="Whole flight").click()
    assert page.locator("#to").input_value() == "100"
    page.locator("#choice-case").select_option("case2")
    wait(watched, 2)
    assert page.locator("#to").input_value() == "300"


def test_without_a_worker_the_page_flies_itself(browser, file):
    watched = Watched(browser)
    watched.page.add_init_script("delete window.Worker")
    watched.page.goto(file.as_uri())
    wait(watched, 1)
    assert watched.page.locator("#outcome").inner_text() == "Flew all 100 s" and watched.said == []


def test_what_cannot_be_flown_is_said(browser, file, tmp_path):
    watched = opened(browser, file)
    page = watched.page
    page.locator("#choice-step").fill("0.03")
    page.locator("#choice-step").press("Enter")
    assert page.locator("#outcome").inner_text() == "Not flown"
    assert page.locator("#why").inner_text() == "The end, 100 s, is not a whole number of steps of 0.03 s."
    page.evaluate("change({...state, step: 0.01, set: {'controller.k_gamma': 0.3}}); change({...state, step: 0.03})")
    page.wait_for_timeout(1500)  # the flight before what is refused would be done by now
    assert page.locator("#outcome").inner_text() == "Not flown" and page.locator("#command").input_value() == ""
    page.get_by_role("button", name="Fly the repaired gains").click()
    wait(watched, 2)
    page.get_by_text("Vehicle", exact=True).click()
    page.locator('[id="set-plant.mass"]').fill("0")
    page.locator('[id="set-plant.mass"]').press("Enter")
    assert page.locator("#why").inner_text() == ("plant.mass = 0 is not allowed: it must be between 0.3 and 300000 "
                                                 "slug/ft.")
    assert page.locator('[id="set-plant.mass"]').get_attribute("aria-invalid") == "true"


def test_the_readout_has_the_figures_of_the_flight(browser, file, tmp_path):
    watched = opened(browser, file)
    cells = watched.page.locator("#metrics tbody tr").all_inner_texts()
    shown = {row.split("\t")[0]: row.split("\t")[2] for row in cells}
    theirs = run("case1", out=tmp_path / "out").summary
    assert float(shown["altitude_error_ft.max_abs"]) == pytest.approx(theirs["altitude_error_ft"]["max_abs"], rel=1e-4)
    assert float(shown["elevator_deg.travel"]) == pytest.approx(theirs["elevator_deg"]["travel"], rel=1e-4)
    assert shown["protected_s"] == "–"


def test_the_site_has_the_same_page(file, tmp_path):
    root = Path(__file__).parents[2]
    subprocess.run([sys.executable, "-m", "mkdocs", "build", "--quiet", "--strict", "--site-dir", tmp_path / "site"],
                   cwd=root, check=True, env={"PATH": "", "PYTHONPATH": str(root)})
    assert (tmp_path / "site" / "fly.html").read_bytes() == file.read_bytes()
    assert 'href="fly.html"' in (tmp_path / "site" / "playground.html").read_text()
