"""`ahv run --live`: what its server refuses, and flights whose inputs are stepped while they fly."""
import http.client
import json
import threading
import time

import numpy as np
import psutil
import pytest

from cosim.errors import UsageError
from cosim.live.board import Board, Lever
from cosim.live.show import Show
from cosim.master.desk import MOST, Desk
from cosim.master.fly import fly
from cosim.master.isolated import launch
from cosim.vehicle import scenarios
from cosim.vehicle.closed_loop import closed_loop
from cosim.vehicle.look import looked_at

LIFT = "plant.scale_lift"


# --- the server ---------------------------------------------------------------------------------------------------

@pytest.fixture(scope="module")
def show():
    """A page that is served, of a flight that does not move."""
    from flights import made

    found = []
    with Show(Board("<b>a flight</b>", 1.0, 1.0, (), [Lever("Lift", LIFT, 0.1, 0.5)], ()), found.append) as shown:
        shown.begun(made([0.0], {LIFT: 1.0}))
        shown.rows(np.array([0.0]), np.array([[1.0]]))
        assert found == [shown.server.address]
        yield shown


def ask(show, path, body=None, method=None, token=None, **headers):
    """The status, the answer and its headers; as the page asks, unless headers say otherwise (None: left out)."""
    connection = http.client.HTTPConnection(show.server.host, timeout=5)
    content = body if isinstance(body, bytes) or body is None else json.dumps(body).encode()
    usual = {"Host": show.server.host}
    if content is not None:
        usual |= {"Content-Type": "application/json", "Content-Length": str(len(content)),
                  "Origin": f"http://{show.server.host}"}
    given = {name: value for name, value in (usual | {n.replace("_", "-"): v for n, v in headers.items()}).items()
             if value is not None}
    token = show.server.token if token is None else token
    connection.putrequest(method or ("GET" if content is None else "POST"), f"{path}{token and f'?token={token}'}",
                          skip_host=True, skip_accept_encoding=True)
    for name, value in given.items():
        connection.putheader(name, value)
    connection.endheaders(content)
    answer = connection.getresponse()
    told = answer.read() if answer.headers.get_content_type() != "text/event-stream" else answer.readline()
    connection.close()
    return answer.status, told.decode(), answer.headers


STEP = {"input": LIFT, "value": 0.1}


@pytest.mark.parametrize("path, body", [("/", None), ("/events", None), ("/step", STEP)])
@pytest.mark.parametrize("wrong", [
    {"token": ""}, {"token": "x" * 22}, {"token": "%00"}, {"token": "%C3%BC"},
    {"Host": None}, {"Host": "evil.example"}, {"Host": "localhost"}, {"Host": "127.0.0.1:1"},
    {"Origin": "http://evil.example"}, {"Origin": "null"}, {"Origin": "http://127.0.0.1"}])
def test_strangers_get_nothing(show, path, body, wrong):
    status, told, headers = ask(show, path, body, **wrong)
    assert status == 403 and json.loads(told).keys() == {"error"} and LIFT not in told
    assert not show.desk.wanted.any() and "Access-Control-Allow-Origin" not in headers


def test_a_step_without_an_origin_is_refused(show):
    assert ask(show, "/step", STEP, Origin=None)[0] == 403


@pytest.mark.parametrize("body, status, told", [
    (b"", 400, "not JSON"), (b"[" * 990, 400, "not JSON"), (b'{"input":NaN', 400, "not JSON"), ([], 400, "A step is"),
    ({"input": LIFT}, 400, "A step is"), (STEP | {"more": 1}, 400, "A step is"),
    (STEP | {"input": "plant.V"}, 400, "plant.V is no input that can be stepped; there are plant.scale_lift."),
    (STEP | {"input": ["a"]}, 400, "no input"), (STEP | {"input": "<b>" * 200}, 400, "no input"),
    (STEP | {"value": 0.51}, 400, "offset 0.51 is not allowed; it must be a number from -0.5 to 0.5."),
    (STEP | {"value": float("nan")}, 400, "not allowed"), (STEP | {"value": float("inf")}, 400, "not allowed"),
    (STEP | {"value": True}, 400, "not allowed"), (STEP | {"value": "0.1"}, 400, "not allowed"),
    (STEP | {"value": None}, 400, "not allowed"), (STEP | {"value": 10 ** 400}, 400, "not allowed"),
    (b" " * 1001, 413, "at most 1000 bytes")])
def test_only_known_inputs_and_bounded_numbers_are_taken(show, body, status, told):
    found = ask(show, "/step", body)
    assert found[0] == status and told in json.loads(found[1])["error"] and len(found[1]) < 400
    assert not show.desk.wanted.any()


@pytest.mark.parametrize("headers, status", [({"Content_Length": None}, 411), ({"Content_Length": "-1"}, 411),
                                             ({"Content_Length": "9" * 30}, 413), ({"Content_Type": "text/plain"}, 415),
                                             ({"Transfer_Encoding": "chunked"}, 411)])
def test_a_body_says_what_it_is(show, headers, status):
    assert ask(show, "/step", STEP, **headers)[0] == status


def test_the_page_runs_its_own_script_only_and_events_tell_all(show):
    status, page, headers = ask(show, "/")
    assert status == 200 and "&lt;b&gt;a flight&lt;/b&gt;" in page and "<b>a flight" not in page
    policy = headers["Content-Security-Policy"]
    assert policy.startswith("default-src 'none'; script-src 'sha256-") and "unsafe" not in policy
    assert headers["Cache-Control"] == "no-store" and headers["X-Content-Type-Options"] == "nosniff"
    status, told, _ = ask(show, "/events")
    told = json.loads(told.removeprefix("data: "))
    assert status == 200 and told["rows"] == [[0.0, 1.0]] and told["about"]["columns"] == [LIFT]
    assert [ask(show, path)[0] for path in ("/step", "/../etc/passwd", "/favicon.ico")] == [404] * 3
    assert ask(show, "/", STEP)[0] == 404 and ask(show, "/", method="OPTIONS")[0] == 501


def test_pages_and_connections_have_an_end(show):
    while show.server.readers:  # of the test before: noticed when there are news
        with show.feed.news:
            show.feed.tell()
        time.sleep(0.01)
    many = [http.client.HTTPConnection(show.server.host, timeout=5) for _ in range(5)]
    for connection in many:
        connection.request("GET", f"/events?token={show.server.token}")
    assert sorted(connection.getresponse().status for connection in many) == [200] * 4 + [503]
    idle = [http.client.HTTPConnection(show.server.host, timeout=5) for _ in range(20)]
    for connection in idle:
        connection.connect()
    time.sleep(0.1)
    assert any(connection.sock.recv(1) == b"" for connection in idle[-2:])
    for connection in (*many, *idle):
        connection.close()


def test_it_is_bound_to_this_machine_only(show):
    found = [c.laddr for c in psutil.Process().net_connections() if c.status == psutil.CONN_LISTEN]
    assert [a.ip for a in found if a.port == show.server.server_address[1]] == ["127.0.0.1"]


# --- steps --------------------------------------------------------------------------------------------------------

def loop():
    return closed_loop(scenarios.load("hold"), flavour="native").system


class Asking(threading.Thread):
    """Asks for a step once the desk shows that the flight has begun."""

    def __init__(self, desk):
        super().__init__(daemon=True)
        self.desk = desk

    def run(self):
        while not self.desk.late.any():
            time.sleep(0.001)
        self.desk.ask(LIFT, 0.1)


@pytest.mark.parametrize("options", [
    {}, {"plain": True, "algorithm": "jacobi,hold=linear"}, {"algorithm": "multi-rate,plant=5"},
    {"algorithm": "variable"}, {"algorithm": "iterated", "decimate": 7}], ids=str)
def test_a_step_is_in_the_signals_from_its_time_on(native_fmus, options):
    desk = Desk([LIFT, "plant.scale_drag"])
    Asking(desk).start()
    flight = fly(loop(), 0.01, 0.8, real_time=4.0, desk=desk, **options)
    [step] = desk.made()
    assert step == {"time": step["time"], "input": LIFT, "value": 0.1} and 0 <= step["time"] < 0.7
    given = np.asarray(flight[LIFT] - flight["scenario.scale_lift"])
    first = flight.time[np.flatnonzero(given)[0]]
    longest = {"multi-rate,plant=5": 0.1, "variable": 1.0, "iterated": 0.07}.get(options.get("algorithm"), 0.01)
    assert step["time"] < first <= step["time"] + longest + 1e-9
    assert given[flight.time >= first] == pytest.approx(0.1) and not given[flight.time < first].any()
    assert not np.asarray(flight["plant.scale_drag"] - 1.0).any() and np.ptp(np.asarray(flight["plant.h"])) > 0


def test_a_flight_without_a_step_is_the_same_to_the_last_bit(native_fmus):
    record = ["plant.V", "plant.h", "controller.elevator", "plant.scale_*", "scenario.scale_*"]
    found = []
    with Show(Board("", 1.0, 20.0, (), [Lever("Lift", LIFT, 0.1, 0.5)], ()), found.append) as show:
        flights = [launch(loop(), 0.01, 1.0, isolate=True, real_time=20.0, record=record, **options)
                   for options in ({}, {"desk": show.desk, "watch": show})]
    assert found and flights[0].columns == flights[1].columns and flights[0].time.tobytes() == flights[1].time.tobytes()
    assert flights[0].signals.tobytes() == flights[1].signals.tobytes() and show.desk.made() == []


def test_steps_are_marks_of_the_page(native_fmus):
    flight = fly(loop(), 0.01, 0.1)
    made = [{"time": 0.05, "input": LIFT, "value": 0.1}, {"time": 0.07, "input": LIFT, "value": 0.0}]
    found = [mark for mark in looked_at("x", flight, {"live": made}).marks if mark.kind == "step made by hand"]
    assert [(mark.begin, mark.text) for mark in found] == [(0.05, f"{LIFT} +0.1"), (0.07, f"{LIFT} back")]


def test_a_desk_has_inputs_that_are_connected_and_finite_offsets(native_fmus):
    for name in ("plant.V", "plant.mass", "nobody.x", "controller.kV"):
        with pytest.raises(UsageError, match=rf"{name} cannot be stepped"):
            fly(loop(), 0.01, 0.1, desk=Desk([name]))
    desk = Desk([LIFT])
    with pytest.raises(UsageError, match="must be a finite number"):
        desk.ask(LIFT, float("nan"))
    with pytest.raises(UsageError, match=rf"no input that can be stepped; there are {LIFT}"):
        desk.ask("plant.scale_drag", 0.1)
    desk.count[0] = MOST
    with pytest.raises(UsageError, match="at most 10000 steps"):
        desk.ask(LIFT, 0.1)


def test_a_watch_is_told_rows_of_another_process(native_fmus):
    class Counting:
        times, columns = (), ()

        def begun(self, flight):
            self.columns = list(flight)

        def rows(self, times, rows):
            self.times = [*self.times, *times]
            desk.ask(LIFT, 0.1)

    desk, watch = Desk([LIFT]), Counting()
    flight = launch(loop(), 0.01, 0.3, isolate=True, real_time=3.0, desk=desk, watch=watch)
    assert watch.times == flight.time.tolist() and watch.columns == list(flight)
    [step] = desk.made()
    assert np.flatnonzero(np.asarray(flight[LIFT]) != 1.0)[0] == round(step["time"] / 0.01) + 1
