"""A live flight in headless Chromium: gauges and curves move, buttons step the vehicle, and everything has an end."""
import http.client
import json
import os
import re
import signal
import subprocess
import time

import numpy as np
import psutil
import pyarrow.parquet
import pytest
from browser import Watched, chromium
from places import AHV

pytestmark = pytest.mark.slow

SITE = re.compile(r"http://127\.0\.0\.1:\d+/\?token=[\w-]{22}\n")


@pytest.fixture(scope="module")
def browser():
    with chromium() as found:
        yield found


class Flight:
    """A command `ahv run … --live` that runs, and the address that it printed."""

    def __init__(self, folder, *words):
        self.out = folder / "out"
        self.process = subprocess.Popen([AHV, "run", *words, "--live", "--json", "--out", self.out], cwd=folder,
                                        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.said = ""
        while not SITE.search(self.said):
            line = self.process.stderr.readline()
            assert line, self.said
            self.said += line
        self.address = SITE.search(self.said)[0].strip()
        self.host = self.address.removeprefix("http://").partition("/")[0]

    def ended(self) -> tuple[int, dict, str]:
        """The exit status, what it printed, and what run.json says."""
        printed, said = self.process.communicate(timeout=60)
        return self.process.returncode, json.loads((self.out / "run.json").read_text()), said + printed

    def status(self, path="/", **headers) -> int:
        """How the server answers a request."""
        connection = http.client.HTTPConnection(self.host, timeout=5)
        connection.request("POST" if path.startswith("/step") else "GET", path,
                           '{"input":"plant.scale_drag","value":0.3}' if path.startswith("/step") else None, headers)
        return connection.getresponse().status


def opened(browser, flight, width=1366, **options) -> Watched:
    """A page of the flight, when its first rows are shown."""
    watched = Watched(browser, width, 900, **options)
    watched.page.goto(flight.address)
    watched.page.locator('html[data-state="flying"]').wait_for(state="attached", timeout=20_000)
    return watched


def until(watched, state) -> None:
    watched.page.locator(f'html[data-state="{state}"]').wait_for(state="attached", timeout=60_000)


def test_a_step_made_by_the_button_is_in_the_signals_and_in_the_page(browser, native_fmus, tmp_path):
    flight = Flight(tmp_path, "case1", "--stop", "20")
    page, other = opened(browser, flight), opened(browser, flight, 390, color_scheme="dark")
    token, here = flight.address.partition("?")[2], f"http://{flight.host}"
    command = psutil.Process(flight.process.pid)
    listening = {c.laddr for p in (command, *command.children(recursive=True)) for c in p.net_connections()
                 if c.status == psutil.CONN_LISTEN}
    assert {f"{a.ip}:{a.port}" for a in listening} == {flight.host}
    for path in ("/", "/events", "/step"):
        for wrong in ({}, {"Host": "evil.example", "Origin": here}, {"Origin": "http://evil.example"}):
            query = f"?{token}" if wrong else "?token=wrong"
            assert flight.status(path + query, **wrong) == 403
        assert flight.status(path, Origin=here) == 403
    page.page.wait_for_timeout(3000)
    before = float(page.page.locator("#time").inner_text().removesuffix(" s"))
    page.page.get_by_role("button", name="Lift +10 %").press("Enter")
    other.page.get_by_role("button", name="Drag −10 %").click()
    other.page.get_by_text("Lift", exact=True).wait_for()
    page.page.wait_for_timeout(1500)
    page.page.get_by_role("button", name="Lift back").click()
    for watched in (page, other):
        until(watched, "written")
        assert watched.page.locator("#made").text_content().count("Lift") == 2
        assert "The flight ended at 20 s. The results are in" in watched.page.locator("#state").inner_text()
        assert watched.said == [] and {url.partition("/?")[0].partition("/e")[0].partition("/s")[0]
                                       for url in watched.asked if url.startswith("http")} == {here}
    assert "now 1." in page.page.locator("#levers").inner_text()
    status, record, said = flight.ended()
    assert status == 0 and "Traceback" not in said, said
    lift, drag, back = record["live"]
    assert (lift["input"], lift["value"]) == ("plant.scale_lift", 0.1) and before < lift["time"] < before + 1.5
    assert (drag["input"], drag["value"], back["input"], back["value"]) == ("plant.scale_drag", -0.1,
                                                                            "plant.scale_lift", 0.0)
    assert lift["time"] + 1.4 < back["time"] < 20
    rows = pyarrow.parquet.read_table(flight.out / "signals.parquet").to_pandas()
    for name, steps in (("lift", [(lift, 0.1), (back, 0.0)]), ("drag", [(drag, -0.1)]), ("moment", [])):
        wanted = np.zeros(len(rows))
        for step, offset in steps:
            wanted[rows["time"] > step["time"] + 1e-6] = offset
        assert np.abs(rows[f"plant.scale_{name}"] - rows[f"scenario.scale_{name}"] - wanted).max() < 1e-12
    report = (flight.out / "report.html").read_text()
    assert "plant.scale_lift +0.1" in report and "plant.scale_lift back" in report
    with pytest.raises(ConnectionRefusedError):
        flight.status("/")


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_the_flight_and_the_page_says_so(browser, native_fmus, tmp_path, number):
    flight = Flight(tmp_path, "case2")
    watched = opened(browser, flight)
    watched.page.wait_for_timeout(500)
    flight.process.send_signal(number)
    until(watched, "written")
    assert "Interrupted at t = " in watched.page.locator("#state").inner_text()
    status, record, _ = flight.ended()
    assert status == 128 + number and record["live"] == []


def test_a_server_that_is_gone_and_buttons_after_the_end(browser, native_fmus, tmp_path):
    flight = Flight(tmp_path, "hold")
    watched = opened(browser, flight)
    below = psutil.Process(flight.process.pid).children(recursive=True)
    os.kill(flight.process.pid, signal.SIGKILL)
    until(watched, "lost")
    assert below and psutil.wait_procs(below, timeout=5)[1] == []
    assert "The connection to ahv is lost" in watched.page.locator("#state").inner_text()
    watched.page.get_by_role("button", name="Lift +10 %").click(force=True)
    assert "nothing can be stepped" in watched.page.locator("#refused").inner_text()
    flight.process.communicate()


def test_a_closed_page_ends_nothing_and_two_flights_go_side_by_side(browser, native_fmus, tmp_path):
    folders = [tmp_path / name for name in ("one", "two")]
    for folder in folders:
        folder.mkdir()
    flights = [Flight(folder, "case1", "--stop", "20", "--controller", law, "--stream")
               for folder, law in zip(folders, ("backstepping", "resilient"))]
    assert flights[0].host != flights[1].host
    opened(browser, flights[0]).context.close()
    second = opened(browser, flights[1])
    second.page.get_by_role("button", name="Pitching moment −10 %").click()
    assert flights[0].status(f"/?{flights[1].address.partition('?')[2]}") == 403
    until(second, "written")
    done = [flight.ended() for flight in flights]
    assert [status for status, _, _ in done] == [0, 0] and [len(record["live"]) for _, record, _ in done] == [0, 1]


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("width", [390, 1366])
def test_it_fits_its_width_and_the_keyboard_reaches_it(browser, native_fmus, tmp_path, width, scheme):
    flight = Flight(tmp_path, "case1", "--preset", "printed", "--real-time", "1")
    watched = opened(browser, flight, width, color_scheme=scheme, reduced_motion="reduce")
    page, reached = watched.page, []
    for _ in range(20):
        page.keyboard.press("Tab")
        reached.append(page.evaluate("document.activeElement.getAttribute('aria-label') || document.activeElement.id"))
    assert "Lift +10 %" in reached and "Generalised forces back" in reached and "window" in reached
    until(watched, "written")
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    assert re.match(r"Departed at 19.\d+ s: plant ", page.locator("#state").inner_text()) and watched.said == []
    assert page.get_by_role("meter", name="Elevator").get_attribute("aria-valuetext").endswith("at its upper limit")
    page.locator("#window").select_option("0")
    assert flight.ended()[0] == 1


def test_it_is_not_later_than_a_flight_without_a_page(browser, native_fmus, tmp_path):
    plain = subprocess.run([AHV, "run", "case1", "--stop", "20", "--real-time", "--json", "--out", tmp_path / "plain"],
                           capture_output=True, text=True)
    flight = Flight(tmp_path, "case1", "--stop", "20")
    opened(browser, flight)
    time.sleep(1)
    found = {"without": json.loads(plain.stdout)["lateness"], "with a page": flight.ended()[1]["lateness"]}
    print(json.dumps(found))
    assert found["with a page"]["mean_s"] < 0.01
