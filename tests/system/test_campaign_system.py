"""Campaigns of any system: two stock FMUs, one of C and one of pythonfmu, from docs/examples/tank."""
import json
import os
import re
import shlex
import shutil
import subprocess
import sys

import numpy as np
import pyarrow.parquet as pq
import pytest
import yaml
from campaigns import fly_here, tables
from places import AHV, ROOT
from test_campaign_cluster import certificates
from test_cases import ahv

from cosim.campaign.plan import load
from cosim.campaign.report import write
from cosim.campaign.resume import prepare
from cosim.campaign.store import Store
from cosim.errors import UsageError
from cosim.vehicle.campaigns import Laws

TANK = ROOT / "docs" / "examples" / "tank"


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    """A folder with the two FMUs, their system and the campaign."""
    folder = tmp_path_factory.mktemp("tank")
    subprocess.run([sys.executable, TANK / "build.py", folder], check=True, capture_output=True)
    for name in ("tank.yaml", "campaign.yaml"):
        shutil.copy(TANK / name, folder)
    return folder


def changed(folder, name="changed.yaml", /, **fields):
    """The example's campaign with other fields; None takes one away."""
    data = yaml.safe_load((TANK / "campaign.yaml").read_text()) | fields
    (folder / name).write_text(yaml.dump({k: v for k, v in data.items() if v is not None}, sort_keys=False))
    return folder / name


def flown(file, out):
    """The rows of a campaign that is flown in this process, as dictionaries, and its plan."""
    plan = load(file)
    out.mkdir()
    store = Store(out, plan)
    prepare(store, False, file.read_text())
    fly_here(store, out.parent / f"{out.name}-work")
    store.finish()
    return pq.read_table(out / "runs.parquet").to_pylist(), plan, store


@pytest.fixture(scope="module")
def campaign(built, tmp_path_factory):
    folder = tmp_path_factory.mktemp("flown") / "out"
    return *flown(changed(built, "flown.yaml", runs=12), folder), folder


def test_the_example_is_the_page_s():
    page = (ROOT / "docs" / "campaigns.md").read_text()
    assert f"```yaml\n{(TANK / 'campaign.yaml').read_text()}```" in page


def test_rows_have_the_variant_the_draws_and_the_metrics_of_the_file(campaign):
    rows, _, _, _ = campaign
    assert list(rows[0]) == [
        "run", "variant", "seed", "tank.area", "tank.outlet", "tank.level_start", "tank.leak", "status", "message",
        "success", "success.level", "success.in time", "ticks", "departed_at_s", "overshoot", "settled", "pumped",
        "full_power"]
    assert [(row["run"], row["variant"]) for row in rows[:4]] == [(0, "calm"), (0, "fast"), (1, "calm"), (1, "fast")]
    assert all(row["status"] == "finished" and row["ticks"] == 400 for row in rows)
    for row in rows:
        assert row["success.level"] is (row["overshoot"] < 0.08)
        assert row["success"] is (row["success.level"] and row["success.in time"])
    for one, two in zip(rows[::2], rows[1::2]):
        assert all(one[name] == two[name] for name in ("tank.area", "tank.leak")) and one["settled"] != two["settled"]
    assert {row["success"] for row in rows} == {True, False}


def test_a_run_obeys_the_equations_with_the_values_that_its_row_names(campaign):
    """The tank steps first: its level needs no input at the same time."""
    row = campaign[0][0]
    level, integral, flow, levels, flows = row["tank.level_start"], 0.0, 0.0, [row["tank.level_start"]], [0.0]
    for _ in range(400):
        for _ in range(10):
            level += 0.01 * (flow - row["tank.leak"] - row["tank.outlet"] * level**0.5) / row["tank.area"]
        asked = 3.0 - level + integral
        flow = max(0.0, min(1.5, asked))
        integral += 0.1 * 0.3 * (3.0 - level) if flow == asked else 0.0
        levels, flows = [*levels, level], [*flows, flow]
    assert row["overshoot"] == pytest.approx(max(levels) - 3.0, abs=1e-12)
    assert row["pumped"] == pytest.approx(np.trapezoid(flows, dx=0.1), abs=1e-9)
    outside = [0.1 * k for k, level in enumerate(levels) if abs(level - 3.0) > 0.1]
    assert outside[-1] < row["settled"] < outside[-1] + 0.1


def test_the_command_of_a_run_repeats_it_to_the_last_bit(campaign, built, tmp_path):
    from cosim.campaign.rerun import command

    rows, plan, _, folder = campaign
    kept = pq.read_table(folder / "signals.parquet").to_pylist()
    row = next(row for row in rows if (row["run"], row["variant"]) == (kept[0]["run"], kept[0]["variant"]))
    words = shlex.split(command(plan, row))
    assert words[:3] == ["ahv", "simulate", str(built / "tank.yaml")]
    assert words[-2:] == ["--out", f"results/run/tank-{row['variant']}-{row['run']}"]
    ahv(*words[1:-2], "--out", tmp_path / "again", "--decimate", 10)
    again = pq.read_table(tmp_path / "again" / "signals.parquet").to_pydict()
    mine = [one for one in kept if (one["run"], one["variant"]) == (row["run"], row["variant"])]
    assert len(mine) == 41
    for name in ("time", "tank.level", "regulator.flow"):
        assert [one[name] for one in mine] == again[name]


def test_the_command_begins_where_the_campaign_does_though_its_file_begins_later(built, tmp_path):
    from cosim.campaign.rerun import command

    late = yaml.safe_load((TANK / "tank.yaml").read_text())
    late["experiment"]["start"] = 1.0
    (built / "late.yaml").write_text(yaml.dump(late, sort_keys=False))
    plan = load(changed(built, "early.yaml", system="late.yaml", start=0, stop=2, runs=2))
    row = {**dict.fromkeys((d.name for d in plan.draws["calm"]), 1.0), "variant": "calm", "run": 0}
    words = shlex.split(command(plan, row))
    assert words[words.index("--start") + 1] == "0.0"


def test_the_report_speaks_of_variants_and_draws_what_the_file_asks_for(campaign):
    _, _, store, folder = campaign
    summary = write(store)
    assert summary["system"] == "tank" and list(summary["variants"]) == ["calm", "fast"]
    assert list(summary["variants"]["calm"]["metrics"]) == ["overshoot", "settled", "pumped", "full_power"]
    assert set(summary["variants"]["calm"]["failures"]) == {"variant", "machinery"}
    page = re.sub("<(script|style).*?</\\1>", "", (folder / "report.html").read_text(), flags=re.DOTALL)
    assert "The variants side by side" in page and "Signals over time" in page and "ahv simulate" in page
    for word in ("altitude", "controller", "law", "Plant"):
        assert word not in page
    errors = pq.read_table(folder / "errors.parquet").to_pylist()
    assert len(errors) == 24 and len(errors[0]["tank.level"]) == 101
    described = json.loads((folder / "campaign.json").read_text())
    assert described["metrics"]["overshoot"] == "max(tank.level) - 3" and described["stop"] == 40.0
    assert described["system"]["connections"][0] == ["tank.level", "regulator.level", 1.0, 0.0]


def test_a_campaign_of_one_fmu_needs_no_metrics_and_no_variants(built, tmp_path):
    file = changed(built, "one.yaml", system="Tank.fmu", variants=None, metrics=None, over_time=None, correlations=None,
                   dispersions={"Tank.leak": {"distribution": "uniform", "low": 0.0, "high": 0.6}}, runs=6, stop=5,
                   step=0.1, start=1, success={"level": "final(Tank.level) > 0.2"}, signals={"share": 0})
    rows, plan, store = flown(file, tmp_path / "out")
    assert plan.laws == ["Tank"] and plan.worst_by is None and rows[0]["ticks"] == 40
    assert {row["variant"] for row in rows} == {"Tank"} and plan.job.start == 1.0
    summary = write(store)
    assert summary["variants"]["Tank"]["metrics"] == {} and not list((tmp_path / "out" / "figures").glob("[!dp]*"))
    assert "Signals over time" not in (tmp_path / "out" / "report.html").read_text()


def test_a_variant_may_have_another_fmu_and_its_command_names_it(built, tmp_path):
    from cosim.campaign.rerun import command

    other = tmp_path / "other"
    other.mkdir()
    (other / "regulator.py").write_text((TANK / "regulator.py").read_text().replace(
        "min(self.pump_max, asked)", "min(self.pump_max, 0.5 * asked)"))
    subprocess.run([sys.executable, "-m", "pythonfmu", "build", "-f", other / "regulator.py", "-d", other], check=True)
    file = changed(built, "others.yaml", variants=[
        {"name": "stock"}, {"name": "half", "fmus": {"regulator": str(other / "Regulator.fmu")}}], runs=3)
    rows, plan, _ = flown(file, tmp_path / "out")
    assert len(plan.fmus) == 3 and rows[0]["pumped"] > rows[1]["pumped"]
    words = shlex.split(command(plan, rows[1]))
    assert f"regulator={other / 'Regulator.fmu'}" in words
    ahv(*words[1:-2], "--out", tmp_path / "again")
    again = pq.read_table(tmp_path / "again" / "signals.parquet").to_pydict()
    assert max(again["tank.level"]) - 3 == rows[1]["overshoot"]


@pytest.mark.parametrize("kind", ["Tank.fmu", "tank.yaml", "tank.ssp", "tank.ssd"])
def test_the_system_may_be_a_file_of_any_kind(built, kind, tmp_path):
    if not (built / kind).exists():
        ahv("ssp", built / "tank.yaml", "--out", built / "tank.ssp")
        shutil.unpack_archive(built / "tank.ssp", built / "unpacked", "zip")
        if kind == "tank.ssd":
            kind = "unpacked/SystemStructure.ssd"
    prefix = "Tank" if kind == "Tank.fmu" else "tank"
    file = changed(built, "kind.yaml", system=kind, variants=None, metrics=None, over_time=[f"{prefix}.level"], runs=2,
                   correlations=None, dispersions={f"{prefix}.area": {"distribution": "uniform", "low": 1, "high": 2}},
                   success={"level": f"max({prefix}.level) < 3"}, stop=5, step=0.1)
    rows, plan, _ = flown(file, tmp_path / "out")
    assert [row["status"] for row in rows] == ["finished"] * 2 and rows[0][f"{prefix}.area"] < 2
    assert plan.subject.systems and len(plan.job.systems) == 1


REFUSED = {
    "a controller": ({"controllers": ["neural"]}, "controllers: this belongs to scenario, and the file has system"),
    "a plant": ({"plant": "ideal"}, "plant: this belongs to scenario, and the file has system"),
    "presets": ({"presets": {"plant": "x"}}, "presets: this belongs to scenario, and the file has system"),
    "a flavour": ({"flavour": "native"}, "flavour: this belongs to scenario, and the file has system"),
    "both": ({"scenario": "case1"}, "either scenario or system is wanted, not both"),
    "neither": ({"system": None, "variants": None, "over_time": None}, "line 1: scenario or system is missing"),
    "a misspelt field beside it": ({"sytem": "tank.yaml"}, "sytem: there is no such field; did you mean system?"),
    "a misspelt field": ({"system": None, "variants": None, "over_time": None, "sytem": "tank.yaml"},
                         "sytem: there is no such field; did you mean system?"),
    "variants of a scenario": ({"scenario": "case1", "system": None},
                               "variants: this belongs to system, and the file has scenario"),
    "no such file": ({"system": "tnak.yaml"}, "system: There is no system file"),
    "no system": ({"system": "campaign.txt"}, "system: .*campaign.txt is not a system: its name must end with"),
    "no stop": ({"system": "Tank.fmu"}, "system: Tank.fmu does not say when to stop: stop is missing"),
    "a stop that does not fit": ({"stop": 0.15}, "stop: --stop 0.15 s is not a whole number"),
    "an unknown component": ({"set": {"tnak.area": 2}}, "set.tnak.area: There is no component tnak"),
    "an unknown variable": ({"set": {"tank.aera": 2}},
                            "set.tank.aera: Tank.fmu has no variable aera; did you mean area?"),
    "a variant's variable": ({"variants": [{"name": "a", "set": {"tank.aera": 2}}]},
                             "variants.0.set.tank.aera: Tank.fmu has no variable aera; did you mean area?"),
    "a variant's component": ({"variants": [{"name": "a", "fmus": {"tnak": "Tank.fmu"}}]},
                              "variants.0.fmus.tnak: There is no component tnak; did you mean tank?"),
    "a variant's file": ({"variants": [{"name": "a", "fmus": {"tank": "none.fmu"}}]},
                         "variants.0.fmus.tank: There is no file .*none.fmu"),
    "a variant's fmu that does not fit": ({"variants": [{"name": "a", "fmus": {"tank": "Regulator.fmu"}}]},
                                          "variants.0: tank.level is not an output that a connection can start from"),
    "one variant twice": ({"variants": [{"name": "a"}, {"name": "a"}]}, "two variants are called a"),
    "a variant without a name": ({"variants": [{"set": {}}]}, "name is missing"),
    "an input that is driven": ({"dispersions": {"tank.inflow": {"distribution": "uniform", "low": 0, "high": 1}},
                                 "correlations": None},
                                "dispersions.tank.inflow: tank.inflow cannot be dispersed: regulator.flow drives it"),
    "an output": ({"dispersions": {"tank.level": {"distribution": "uniform", "low": 0, "high": 1}},
                   "correlations": None}, "tank.level is an output and cannot be set"),
    "a wave": ({"dispersions": {"tank.leak": {"distribution": "sinusoid", "amplitude": 1, "period": 2}},
                "correlations": None}, "tank.leak cannot be a sinusoid: it is no output with parameters "),
    "a metric's signal": ({"metrics": {"a": "max(tank.lvl)"}},
                          "metrics.a: 'max.tank.lvl.': there is no metric or signal tank.lvl; did you mean tank.level"),
    "a metric that is a signal": ({"metrics": {"a": "tank.level"}}, "metrics.a: 'tank.level' is a signal: say which"),
    "a metric that is true": ({"metrics": {"a": "max(tank.level) < 3"}}, "metrics.a: .* is true or false, not"),
    "a metric of a later one": ({"metrics": {"a": "b + 1", "b": "max(tank.level)"}},
                                "metrics.a: 'b . 1': b is no metric yet"),
    "a metric with the name of a column": ({"metrics": {"tank.area": "max(tank.level)"}},
                                           "metrics.tank.area: there is a column or a signal of this name already"),
    "a metric of no name": ({"metrics": {"a b": "max(tank.level)"}}, "metrics.a b"),
    "a criterion that is a number": ({"success": {"a": "max(tank.level)"}}, "success.a: .* is neither true nor false"),
    "a criterion of a metric that is not there": ({"success": {"a": "overshot < 1"}},
                                                  "success.a: .* did you mean overshoot?"),
    "an unknown worst": ({"worst_by": "level"}, "worst_by: there is no level; there are overshoot, settled, pumped"),
    "an unknown signal over time": ({"over_time": ["tank.lvl"]},
                                    "over_time.0: there is no signal tank.lvl; did you mean tank.level?"),
}


@pytest.mark.parametrize("fields, sentence", REFUSED.values(), ids=REFUSED)
def test_what_does_not_belong_is_refused_with_line_and_field(built, fields, sentence):
    file = changed(built, **{"metrics": {"overshoot": "max(tank.level) - 3", "settled": "settling(tank.level, 3, 0.1)",
                                         "pumped": "integral(regulator.flow)"}, **fields})
    with pytest.raises(UsageError, match=sentence) as error:
        load(file, Laws)
    assert len(str(error.value).splitlines()) == 1 and "changed.yaml, line " in str(error.value)


def test_metrics_of_a_scenario_stand_beside_its_own(tmp_path):
    file = tmp_path / "own.yaml"
    data = {"name": "own", "scenario": "case1", "runs": 2, "seed": 1, "stop": 1, "success": {"near": "far < 20"},
            "metrics": {"far": "max(abs(plant.h - controller.h_reference))"},
            "dispersions": {"plant.mass": {"distribution": "uniform", "low": 290, "high": 310}}}
    file.write_text(yaml.dump(data))
    plan = load(file, Laws)
    assert [*plan.metrics][-2:] == ["alpha_margin_deg.min", "far"] and plan.worst_by == "far"
    store = Store(tmp_path, plan)
    prepare(store, False, "")
    fly_here(store, tmp_path / "work")
    store.finish()
    for row in pq.read_table(tmp_path / "runs.parquet").to_pylist():
        assert row["far"] == row["altitude_error_ft.max_abs"] and row["success"]
    file.write_text(yaml.dump({**data, "metrics": {"protected_s": "max(plant.h)"}}))
    with pytest.raises(UsageError, match=r"metrics.protected_s: there is a metric of this name already"):
        load(file, Laws)


NAMESPACES = """
set -e
ip link set lo up
trap 'kill $(jobs -p) 2>/dev/null' EXIT
tls="--tls-ca-file $CERT/ca.pem --tls-cert $CERT/ca.pem --tls-key $CERT/key.pem"
$BIN/dask scheduler --host tls://0.0.0.0 --port 8786 --no-dashboard $tls 2>/dev/null &
for k in 1 2; do
    unshare -n sleep 3600 & other=$!
    sleep 0.5
    ip link add here$k type veth peer name there
    ip link set there netns $other
    ip addr add 10.214.$k.1/24 dev here$k; ip link set here$k up
    on_other="nsenter -t $other -n"
    $on_other ip link set lo up; $on_other ip addr add 10.214.$k.2/24 dev there; $on_other ip link set there up
    $on_other $BIN/dask worker tls://10.214.$k.1:8786 --host tls://10.214.$k.2 --nthreads 1 --no-dashboard $tls \
        --local-directory $OUT/worker$k 2>/dev/null &
done
fly() { $BIN/ahv campaign $1 --out $OUT/flown --scheduler tls://10.214.1.1:8786 --tls-ca $CERT/ca.pem \
        --tls-cert $CERT/ca.pem --tls-key $CERT/key.pem --json $2 >>$OUT/said; }
fly $SMALL & client=$!
until [ $(ls $OUT/flown/parts 2>/dev/null | grep -c receipt) -ge 20 ]; do sleep 0.02; kill -0 $client; done
kill -9 $(ps -o pid= --ppid $client); wait $client || true
[ ! -e $OUT/flown/runs.parquet ]
fly $SMALL --resume
fly $LARGE --resume
ls $OUT/worker1 $OUT/worker2 >$OUT/workers
"""


@pytest.mark.slow
def test_on_two_hosts_killed_resumed_and_grown_it_is_the_campaign_that_is_flown_at_once(built, tmp_path):
    isolated = ["unshare", "-Urn"]
    if not shutil.which("ip") or subprocess.run([*isolated, "ip", "link"], capture_output=True).returncode:
        pytest.skip("needs iproute2 and user namespaces")
    certificates(tmp_path)
    files = {name: changed(built, f"{name}.yaml", runs=runs) for name, runs in (("SMALL", 500), ("LARGE", 2000))}
    done = subprocess.run([*isolated, "bash", "-c", NAMESPACES], text=True, timeout=3000, capture_output=True, env={
        **os.environ, "BIN": str(AHV.parent), "CERT": str(tmp_path), "OUT": str(tmp_path),
        **{name: str(file) for name, file in files.items()}})
    assert done.returncode == 0, done.stderr
    small, large = map(json.loads, (tmp_path / "said").read_text().splitlines())
    assert small["runs"] == 500 and 0 < small["runs_flown_now"] < 1000 and large["runs_flown_now"] == 3000
    ahv("campaign", files["LARGE"], "--out", tmp_path / "expected")
    assert tables(tmp_path / "flown") == tables(tmp_path / "expected")
    for name in ("campaign.json", "campaign.yaml", "receipt.json"):
        assert (tmp_path / "flown" / name).read_bytes() == (tmp_path / "expected" / name).read_bytes()
    report = json.loads((tmp_path / "flown" / "report.json").read_text())
    for variant in report["variants"].values():
        assert variant["judged"] == 2000 and 0.2 < variant["probability"] < 1
        assert set(variant["drivers"]) == {"tank.area", "tank.level_start", "tank.leak", "tank.outlet"}
