"""The command line `ahv`: words and JSON keys are a contract, see the README."""
import json
import re
import sys
from pathlib import Path
from typing import Annotated

import typer

from ..errors import RunError, UsageError
from ..vehicle.closed_loop import CONTROLLERS, assignments, choice, chosen_presets, fmu_path, planned
from .show import report, report_rows, short

app = typer.Typer(add_completion=False, no_args_is_help=True, pretty_exceptions_enable=False,
                  help="An air-breathing hypersonic vehicle and its controllers as FMUs, and a master that flies them.")

Json = Annotated[bool, typer.Option("--json", help="One JSON object on stdout.")]
Algorithm = Annotated[str, typer.Option(metavar="NAME[,OPTION=VALUE]...", help="gauss-seidel, jacobi, multi-rate, "
                                        "variable or iterated; such as multi-rate,controller=5,hold=linear.")]
Set = Annotated[list[str], typer.Option("--set", metavar="COMPONENT.VARIABLE=VALUE", help="May be repeated.")]


def main() -> None:
    """Entry point: errors become one sentence on stderr and an exit status, 1 (run) or 2 (use)."""
    try:
        app(args=with_factor(sys.argv[1:]))
    except UsageError as error:
        sys.exit(complain(error, 2))
    except RunError as error:
        sys.exit(complain(error, 1))
    except ModuleNotFoundError as error:
        sys.exit(complain(f"{error}. `make setup` installs all packages; so does pip install 'ahv[all]'.", 2))


def with_factor(words: list[str]) -> list[str]:
    """`--real-time` with its factor, which is 1 where none is given."""
    for i, word in enumerate(words):
        if word == "--real-time" and not re.fullmatch(r"\d*\.?\d+", words[i + 1] if i + 1 < len(words) else ""):
            return [*words[:i + 1], "1", *words[i + 1:]]
    return words


def complain(error: object, status: int) -> int:
    print(f"ahv: {error}", file=sys.stderr)
    return status


@app.command()
def build(
    flavour: Annotated[str, typer.Option(help="python, native or all.")] = "all",
    arm: Annotated[bool, typer.Option("--arm", help="Also binaries for Arm (native flavour).")] = False,
) -> None:
    """Write the FMU files to fmus/dist/FLAVOUR/."""
    from fmus.build import FLAVOURS as known
    from fmus.build import build_all

    for path in build_all(list(known) if flavour == "all" else [choice("flavour", flavour, [*known, "all"])], arm):
        print(path, file=sys.stderr)


@app.command()
def run(
    scenario: Annotated[str, typer.Argument(help="case1, case2, hold, or a YAML file.")],
    controller: Annotated[str, typer.Option(help="neural or backstepping.")] = "neural",
    preset: Annotated[str, typer.Option(help="Of the controller; COMPONENT=NAME,... for others too.")] = "calibrated",
    flavour: Annotated[str, typer.Option(help="native or python.")] = "native",
    plant: Annotated[str, typer.Option(help="ideal, or instrumented: actuators and sensors as they are.")] = "ideal",
    step: Annotated[float, typer.Option(help="Communication step, s.")] = 0.01,
    stop: Annotated[float | None, typer.Option(help="End, s; else the scenario's.")] = None,
    algorithm: Algorithm = "gauss-seidel",
    plain: Annotated[bool, typer.Option("--plain", help="Tick in plain Python, not in compiled code.")] = False,
    real_time: Annotated[float | None, typer.Option(metavar="[FACTOR]", help="Pace the run, FACTOR (1) times.")] = None,
    isolate: Annotated[bool, typer.Option("--isolate", help="Fly in a process of its own, which may crash.")] = False,
    time_limit: Annotated[float | None, typer.Option(metavar="S", help="Of one FMU call; isolates.")] = None,
    stream: Annotated[bool, typer.Option("--stream", help="Write signals.parquet as it flies, for long runs; no CSV, "
                                         "and metrics and figures from a part of the rows.")] = False,
    set_: Set = [],  # noqa: B006  (typer wants a list)
    decimate: Annotated[int, typer.Option(help="Write every N-th tick.", min=1)] = 1,
    out: Annotated[Path | None, typer.Option(help="Folder; else results/SCENARIO.")] = None,
    as_json: Json = False,
) -> None:
    """Fly a scenario and write signals, run.json and figures."""
    from ..master.flight import progress_bar
    from ..master.isolated import launch
    from ..master.results import prepare_folder, write
    from ..vehicle import scenarios
    from ..vehicle.metrics import metrics

    plan = scenarios.load(scenario)
    presets = {**plan.presets, **chosen_presets(preset)}
    system = planned(plan, controller, presets, flavour, set_, plant)
    folder = out or Path("results") / plan.name
    prepare_folder(folder)

    end = plan.stop if stop is None else stop
    bar, progress = progress_bar(f"{plan.name}", end)
    with bar:
        flight = launch(system, step, end, algorithm, progress, isolate, time_limit, plain=plain, real_time=real_time,
                        **({"decimate": decimate, "stream": folder / "signals.parquet"} if stream else {}))
    ticks = flight.ticks
    summary = {
        "scenario": plan.name, "controller": controller, "preset": presets["controller"], "flavour": flavour,
        "algorithm": algorithm, "step_s": step, "stop_s": end, "ticks": ticks, "finished": flight.finished,
        "departed_at_s": None if flight.finished else float(flight.time[-1]),
        **metrics(flight),
        "real_time_factor": float(flight.time[-1]) / flight.wall_s if ticks else 0.0, "out": str(folder),
        **({"lateness": flight.lateness} if flight.lateness else {}),
    }
    write(folder, flight, summary, decimate, stream)
    from ..vehicle.figures import write as write_figures  # matplotlib takes its time

    write_figures(folder, flight, f"{plan.name}, {controller} ({presets['controller']})", plan.first_figure)
    report(summary, as_json)
    if not flight.finished:
        raise RunError(flight.message)


@app.command()
def compare(
    scenario: Annotated[str, typer.Argument(help="case1, case2, hold, or a YAML file.")],
    flavour: Annotated[str, typer.Option(help="python or native.")] = "native",
    plant: Annotated[str, typer.Option(help="ideal, or instrumented: actuators and sensors as they are.")] = "ideal",
    step: Annotated[float, typer.Option(help="Communication step, s.")] = 0.01,
    stop: Annotated[float | None, typer.Option(help="End, s; else the scenario's.")] = None,
    out: Annotated[Path | None, typer.Option(help="Folder; else results/compare_SCENARIO.")] = None,
    as_json: Json = False,
) -> None:
    """Fly every control law on the same scenario: a table, and figures with a curve for each.

    The backstepping law is a reconstruction of the one that the paper compares with. It and the neural law's preset
    `robust` were tuned by the same script with the same cost and budget.
    """
    from ..master.results import prepare_folder
    from ..vehicle import scenarios
    from ..vehicle.compare import COMPARED, verdict
    from ..vehicle.compare import compare as fly_both
    from ..vehicle.compare import write as write_figures

    plan = scenarios.load(scenario)
    folder = out or Path("results") / f"compare_{plan.name}"
    prepare_folder(folder)
    systems = {name: planned(plan, law, {**plan.presets, "controller": preset}, flavour, [], plant)
               for name, (law, preset) in COMPARED.items()}
    presets = {name: preset for name, (_, preset) in COMPARED.items()}
    flights, rows = fly_both(systems, presets, step, plan.stop if stop is None else stop)
    write_figures(folder, flights, plan.name)
    summary = {"scenario": plan.name, "flavour": flavour, "step_s": step, "controllers": rows,
               "verdict": verdict(rows), "out": str(folder)}
    (folder / "compare.json").write_text(json.dumps(summary, indent=2) + "\n")
    if as_json:
        print(json.dumps(summary))
    else:
        report_rows(rows)
        print(f"{summary['verdict']} Figures: {folder}")
    if not all(flight.finished for flight in flights.values()):
        raise RunError(" ".join(f"{law}: {flight.message}" for law, flight in flights.items() if flight.message))


@app.command()
def linearize(
    V: Annotated[float, typer.Option("--V", help="Velocity, ft/s.")] = 7700.0,
    h: Annotated[float, typer.Option("--h", help="Altitude, ft.")] = 85000.0,
    controller: Annotated[str, typer.Option(help="neural or backstepping.")] = "neural",
    preset: Annotated[str, typer.Option(help="Of the controller.")] = "calibrated",
    scale: Annotated[float, typer.Option(help="Factor on every coefficient group.")] = 1.0,
    step: Annotated[float, typer.Option(help="Communication step, s.")] = 0.01,
    set_: Set = [],  # noqa: B006
    as_json: Json = False,
) -> None:
    """Open and closed loop about level flight: poles, zeros, damping, margins at each actuator and sensor."""
    from fmus.linear_report import linear_report, preset_gains
    from fmus.linearize import GROUPS, NoTrim

    model = CONTROLLERS[choice("controller", controller, CONTROLLERS)]
    try:
        gains = preset_gains(model, preset)
        given = {name: {k: float(v) for k, v in pairs.items()} for name, pairs in assignments(set_).items()}
        found = linear_report(model, {**gains, **given.get("controller", {})}, V, h, step,
                              dict.fromkeys(GROUPS, scale), given.get("plant", {}))
    except KeyError:
        raise UsageError(f"The {controller} controller has no preset {preset}.") from None
    except NoTrim as error:
        raise RunError(str(error)) from None
    except ValueError as error:
        raise UsageError(str(error)) from None
    found = {"controller": controller, "preset": preset, **found}
    if as_json:
        print(json.dumps(found))
        return
    report({k: v for k, v in found.items() if not isinstance(v, dict)}, False)
    report_rows({"open loop": short(found["open_loop"]), "closed loop": short(found["closed_loop"])})
    margins = found["margins"] or {}
    report_rows({key: {place: m[key] for place, m in margins.items()} for key in next(iter(margins.values()), {})})


@app.command()
def ssp(
    scenario: Annotated[str, typer.Argument(help="case1, case2, hold, or a YAML file.")] = "case1",
    controller: Annotated[str, typer.Option(help="neural or backstepping.")] = "neural",
    preset: Annotated[str, typer.Option(help="Of the controller; COMPONENT=NAME,... for others too.")] = "calibrated",
    flavour: Annotated[str, typer.Option(help="native or python.")] = "native",
    plant: Annotated[str, typer.Option(help="ideal, or instrumented: actuators and sensors as they are.")] = "ideal",
    step: Annotated[float, typer.Option(help="Communication step to suggest, s.")] = 0.01,
    set_: Set = [],  # noqa: B006
    out: Annotated[Path | None, typer.Option(help="File; else results/SCENARIO.ssp.")] = None,
) -> None:
    """Write the closed loop as SSP 1.0, for any tool that reads it."""
    from ..master.flight import tick_count
    from ..ssp.write import write
    from ..vehicle import scenarios

    plan = scenarios.load(scenario)
    tick_count(step, plan.stop)
    system = planned(plan, controller, {**plan.presets, **chosen_presets(preset)}, flavour, set_, plant)
    path = out or Path("results") / f"{plan.name}.ssp"
    write(path, plan.name, system, step, plan.stop)
    print(path, file=sys.stderr)


@app.command()
def simulate(
    file: Annotated[Path, typer.Argument(help="An SSP 1.0 file.")],
    step: Annotated[float | None, typer.Option(help="Communication step, s; else as the file suggests.")] = None,
    stop: Annotated[float | None, typer.Option(help="End, s; else as the file suggests.")] = None,
    algorithm: Algorithm = "gauss-seidel",
    out: Annotated[Path | None, typer.Option(help="Folder; else results/FILE.")] = None,
    as_json: Json = False,
) -> None:
    """Fly anybody's system of FMI 2.0 co-simulation FMUs; write signals and run.json."""
    from ..ssp.simulate import simulate as fly_file

    summary, message = fly_file(file, step, stop, algorithm, out)
    report(summary, as_json)
    if message:
        raise RunError(message)


@app.command()
def campaign(
    file: Annotated[Path, typer.Argument(help="A campaign file, see docs/campaigns.md.")],
    scheduler: Annotated[str | None, typer.Option(metavar="ADDRESS", help="Of a Dask cluster; else one here.")] = None,
    workers: Annotated[int | None, typer.Option(help="Processes here; else one for each core.", min=1)] = None,
    resume: Annotated[bool, typer.Option("--resume", help="Continue what was interrupted.")] = False,
    out: Annotated[Path | None, typer.Option(help="Folder; else results/NAME.")] = None,
    as_json: Json = False,
) -> None:
    """Fly many uncertain runs on Dask, and report how often they succeed."""
    from ..campaign.command import campaign as fly_campaign
    from ..campaign.command import table

    summary = fly_campaign(file, out, scheduler, resume, workers)
    if as_json:
        print(json.dumps(summary))
    else:
        report(table(summary), False)


@app.command()
def trim(
    V: Annotated[float, typer.Option("--V", help="Velocity, ft/s.")] = 7700.0,
    h: Annotated[float, typer.Option("--h", help="Altitude, ft.")] = 85000.0,
    flavour: Annotated[str, typer.Option(help="native or python.")] = "native",
    as_json: Json = False,
) -> None:
    """Level flight as the plant FMU solves it."""
    from math import degrees

    from ..master.fmu import FmuFile, Instance

    file = FmuFile.open(fmu_path(flavour, "AhvPlant"))
    instance = None
    try:
        values = {name: file.checked(name, value, "plant") for name, value in (("V_start", V), ("h_start", h))}
        instance = Instance(file, "plant")
        instance.set(values)
        instance.setup(0.0, 1.0)
        instance.simple("fmi2EnterInitializationMode")
        names = ("theta_trim", "eta1", "eta2", "fuel_ratio_trim", "elevator_trim", "trim_residual")
        theta, eta1, eta2, fuel_ratio, elevator, residual = instance.get(names)
    finally:
        if instance:
            instance.close()
        file.close()
    report({"V_fps": V, "h_ft": h, "theta_deg": degrees(theta), "eta1": eta1, "eta2": eta2,
            "fuel_ratio": fuel_ratio, "elevator_deg": degrees(elevator), "residual": residual}, as_json)


@app.command()
def check(
    fmus: Annotated[list[Path], typer.Argument(metavar="FMU...", help="FMI 2.0 co-simulation FMUs, anybody's.")],
    dynamic: Annotated[bool, typer.Option(help="Also run the FMU, in child processes.")] = True,
    time_limit: Annotated[float, typer.Option(help="Seconds that one call of the FMU may take.")] = 30.0,
    as_json: Json = False,
) -> None:
    """Check FMUs against FMI 2.0: their files, and what they do when they run."""
    from ..conformance import check as examine
    from ..conformance.report import findings_table, not_tested_table, to_dict

    missing = [str(path) for path in fmus if not path.is_file()]
    if missing:
        raise UsageError(f"There is no file {', '.join(missing)}.")
    reports = [examine(path, dynamic, time_limit) for path in fmus]
    if as_json:
        print(json.dumps({"passed": all(r.passed for r in reports), "fmus": [to_dict(r) for r in reports]}))
    else:
        from rich.console import Console

        for one in reports:
            Console().print(findings_table(one), not_tested_table(one))
    failed = [one.fmu.name for one in reports if not one.passed]
    if failed:
        raise RunError(f"{', '.join(failed)} breaks FMI 2.0.")


@app.command(context_settings={"allow_extra_args": True, "ignore_unknown_options": True})
def bench(
    context: typer.Context,
    what: Annotated[str, typer.Argument(help="masters, orders, memory, step or campaign.")] = "masters",
) -> None:
    """Measure, side by side; --json and further options go to the measurement (benchmarks/*.py)."""
    import subprocess

    folder = Path(__file__).parent.parent / "benchmarks"
    scripts = {"masters": "masters.py", "orders": "orders.py", "memory": "memory.py", "step": "native_step.py",
               "campaign": "campaign.py"}
    script = folder / scripts[choice("what", what, scripts)]
    if not script.is_file():
        raise UsageError(f"There is no {script}: measurements come with the sources, not with the package.")
    if subprocess.run([sys.executable, script, *context.args]).returncode:
        raise RunError(f"The measurement {what} failed, see above.")
