"""The loop in C equals the plain one, to the last bit: random programs, FMUs of both versions, whatever they answer."""
from contextlib import closing

import numpy as np
import pytest
import small
import small3
from hypothesis import given, settings
from hypothesis import strategies as st

from cosim.master import loop_compiled, loop_plain
from cosim.master import program as P
from cosim.master.loaded import Master, open_files
from cosim.master.system import Component, Connection, System

STEP_S, TICKS = 0.05, 12
WHOLES = [kind for kind in small3.TYPES if not kind.startswith("Float")]
LINKS = [("real.y", "three.u"), ("three.y", "real.u", 0.8, 0.1), ("three.Float32_out", "eventful.u"),
         ("real.y1", "three.Float32_in", -1.5), ("three.y2", "eventful.vector_in[2]"),
         *((f"three.{kind}_out", f"eventful.{kind}_in") for kind in WHOLES),
         *((f"eventful.{kind}_out", f"three.{kind}_in") for kind in WHOLES),
         ("eventful.text_out", "three.text_in"), ("real.text_out", "eventful.text_in"),
         ("real.whole_out", "eventful.level_in"), ("eventful.count", "real.whole_in")]
FAULTS = {"real": ("discard", "error", "end", "refuse_get"),
          "three": ("discard", "end", "error"),
          "eventful": ("end", "end_in_event", "restless", "stuck", "refuse_event", "refuse_update")}


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    folder = tmp_path_factory.mktemp("programs")
    paths = {"real": small.build(folder, direct=True, interpolates=True), "three": small3.build(folder),
             "eventful": small3.build(folder, events=True)}
    with open_files(System([Component(name, path) for name, path in paths.items()])) as found:
        yield paths, found


@st.composite
def flights(draw):
    """Values of the components, and how rows, signals and times are to be drawn."""
    values = {"real": small.oscillator(), "three": {"early": draw(st.sampled_from([0.0, 0.02]))},
              "eventful": {"period": draw(st.sampled_from([0.0, 0.03, 0.1])),
                           "early": draw(st.sampled_from([0.0, 0.02]))}}
    name = draw(st.sampled_from(["", *FAULTS]))
    if name:
        fault = draw(st.sampled_from(FAULTS[name]))
        kinds = small.FAULTS if name == "real" else small3.FAULTS
        values[name] |= {"fault": kinds.index(fault), "fault_time": draw(st.sampled_from([0.12, 0.3]))}
    return values, draw(st.integers(0, 2**32 - 1)), draw(st.sampled_from([0, 1, 1, 3]))


def rows_of(master, random):
    """A random program: each component steps on as it should, most of the time; anything else comes anywhere."""
    wiring, few = master.wiring, random.choice([1, 3])
    periods = random.choice([1, 1, 2, 3], len(master.instances))
    rows = [P.row(P.STEP, i, int(p), 0, int(p)) for i, p in enumerate(periods)]
    for group in wiring.every_group:
        codes = [P.GET] if group.verb == "Get" else [P.OFFER] if group.in_events else [P.SET, P.PREDICT]
        codes += [P.SLOPE] * group.interpolates
        for _ in range(random.integers(0, 3)):
            period = int(random.choice([1, 1, few]))
            rows.append(P.row(int(random.choice(codes)), group.number, period, int(random.integers(period)),
                              int(random.integers(3))))
    rows += [P.row(P.MARK, int(random.integers(3)), 1, 0, int(random.integers(3))) for _ in range(random.integers(4))]
    random.shuffle(rows)
    if random.random() < 0.3:  # a step that is repeated, as `iterated` does
        chosen, period = int(random.integers(3)), int(random.choice([1, 5]))
        rows = [P.row(P.SAVE, chosen), *rows, P.row(P.RESTORE, chosen, period, 0),
                P.row(P.STEP, chosen, period, 0, int(periods[chosen]))]
    return P.program(rows)


def left_by(loop_of, files, values, seed, decimate):
    """All that a loop leaves: status, cursor, rows, times, the wiring's vectors and what the FMUs show."""
    paths, found = files
    random = np.random.default_rng(seed)
    system = System([Component(name, path, values[name]) for name, path in paths.items()],
                    [Connection(*link) for link in LINKS])
    with closing(Master(system, found, plain=True)) as master:
        master.initialise(0.0, None)
        w = master.wiring
        ops = rows_of(master, random)
        w.signals[:] = random.normal(0.0, 10.0, len(w.signals))
        w.before[:] = w.signals + random.normal(0.0, 1.0, len(w.signals)) * (random.random(len(w.signals)) < 0.7)
        w.exact[:] = random.integers(-2**62, 2**62, len(w.exact))
        w.clock[:, 1] = w.clock[:, 0] - random.choice([0.0, 0.05, 0.1], len(w.clock))
        rows, times = np.zeros((TICKS, len(master.columns))), np.zeros(TICKS)
        status = loop_of(w).run(ops, rows, times, master.cursor, 0, TICKS, 0.0, STEP_S, decimate)
        texts = [group.number for group in w.every_group if group.kind == P.TEXT]
        buffers = [w.buffers[a:a + n].tobytes() for g, (a, n) in enumerate(w.groups[:, [P.FIRST, P.VALUES]])
                   if g not in texts]
        shown = [w.signals, w.exact, w.before, w.clock, w.slopes, w.texts, w.states != 0, w.events, rows, times]
        alive = status in (0, P.DISCARD, P.ERROR, P.TOO_LONG, P.RESTLESS)
        outputs = [repr(i.get([n for n in i.file.names("output") if n != "bytes_out"])) for i in master.instances
                   if alive and not values[i.name].get("fault")]
        return status, master.cursor.tolist(), [a.tobytes() for a in shown], buffers, outputs


SEEN: list[int] = []


@settings(max_examples=60)
@given(flight=flights())
def test_random_programs(files, flight):
    library = loop_compiled.library()
    assert library is not None
    compiled = left_by(lambda wiring: loop_compiled.Loop(wiring, library), files, *flight)
    assert compiled == left_by(loop_plain.Loop, files, *flight)
    SEEN.append(compiled[0])


def test_many_of_them_flew_to_the_end_and_some_did_not():
    assert SEEN.count(0) >= 5 and len({*SEEN}) >= 3
