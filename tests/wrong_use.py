"""Bad input of every kind, drawn from a seed: command lines, values with units, algorithms, YAML files, expressions,
distributions, descriptions of FMUs. `tried` carries one out and tells how it ended.

What is drawn may happen to be right: then it flies, for 20 ms, or is planned.
"""
import random
import zipfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import yaml
from altered import redescribed
from campaigns import load
from wrong_words import (
    ALGORITHMS,
    ATTRIBUTES,
    BETWEEN,
    CAMPAIGN,
    CAMPAIGNS,
    CHOICES,
    COMMANDS,
    DATA,
    DISTRIBUTIONS,
    ENCODINGS,
    EXPRESSIONS,
    FIELDS,
    NUMBERS,
    OPTIONS,
    SAMPLES,
    SCENARIO,
    STRUCTURE,
    SYNTAX,
    TERMS,
    UNITS,
    VARIABLES,
    WORDS,
)

from cosim.campaign.sampling import drawn as rows
from cosim.cli.app import done
from cosim.errors import UsageError
from cosim.vehicle.closed_loop import fmu_path


@dataclass
class Bad:
    """One bad input: the class that it belongs to, what is done, and how it reads in a message."""
    kind: str
    act: Callable[[], int]
    text: str


def number(r: random.Random) -> str:
    """A word where a number belongs."""
    return r.choice(NUMBERS if r.random() < 0.8 else WORDS)


def assignment(r: random.Random) -> str:
    """A word for --set."""
    value = number(r) + (r.choice(["", " "]) + r.choice(UNITS) if r.random() < 0.6 else "")
    return r.choice(WORDS) if r.random() < 0.1 else f"{r.choice(VARIABLES)}={value}"


def algorithm(r: random.Random) -> str:
    """A word for --algorithm."""
    options = [f"{r.choice(OPTIONS)}{r.choice(['=', '=', '=', '', '=='])}"
               f"{r.choice(CHOICES) if r.random() < 0.5 else number(r)}" for _ in range(r.randint(0, 3))]
    return ",".join([r.choice(ALGORITHMS[:5] if r.random() < 0.8 else ALGORITHMS), *options])


def command_line(r: random.Random, folder: Path) -> list[str]:
    """A command line with wrong values, options that do not exist, arguments that are too many or too few."""
    if r.random() < 0.05:
        return [r.choice(WORDS) for _ in range(r.randint(0, 3))]
    command = r.choice(list(COMMANDS))
    fixed, options = COMMANDS[command]
    words = [command, *fixed]
    for option in r.sample(options, min(len(options), r.randint(1, 3))):
        if option == "!":
            words = [command, r.choice(WORDS), *words[2:]]
            continue
        if option.endswith("!"):
            words.append(option.rstrip("!"))
            continue
        value = number(r) if option.endswith("#") else algorithm(r) if option == "--algorithm" else assignment(r) \
            if option == "--set" else variant(r) if option == "--run" else r.choice(WORDS)
        words += [option.rstrip("#"), value]
    if r.random() < 0.1:
        words.append(r.choice(WORDS + NUMBERS))
    return words


def variant(r: random.Random) -> str:
    """A word for --run."""
    options = [f"{r.choice(['--preset', '--controller', '--plant', '--set', '--uncertainty', '--step', '-x', ''])} "
               f"{assignment(r) if r.random() < 0.4 else number(r) if r.random() < 0.5 else r.choice(WORDS)}"
               for _ in range(r.randint(0, 2))]
    return r.choice(WORDS) if r.random() < 0.1 else \
        f"{r.choice(['mine', 'a b', *WORDS])}{r.choice([':', ':', ':', '='])}{' '.join(options)}"


def variants(r: random.Random, folder: Path) -> list[str]:
    """A comparison of variants, with a plant that is none: what is right does not fly."""
    return ["compare", "hold", "--stop", "0.02", "--plant", "nobody", "--out", str(folder / "set"),
            *(word for _ in range(r.randint(1, 2)) for word in ("--run", variant(r)))]


def axis(r: random.Random) -> str:
    """A word for a variable of `ahv sweep`."""
    if r.random() < 0.4:
        return r.choice(["plant.mass=290:310:3", "controller.k_gamma=0.3,0.4", "plant.start_at_trim=true,false"])
    values = r.choice([f"{number(r)}:{number(r)}:{number(r)}", ",".join(number(r) for _ in range(r.randint(1, 3))),
                       "290:310:3", "true,false", r.choice(WORDS)])
    return r.choice(WORDS) if r.random() < 0.1 else f"{r.choice(VARIABLES)}{r.choice(['=', '=', '=', ''])}{values}"


def sweeping(r: random.Random, folder: Path) -> list[str]:
    """A sweep. What is right is not flown: its folder cannot be made."""
    words = ["sweep", "hold", "--stop", "0.02", "--out", "/dev/null/x", *(axis(r) for _ in range(r.randint(1, 3)))]
    for option in r.sample(["--metric", "--success"], r.randint(0, 2)):
        words += [option, r.choice(["", "a=", "high=", "high=max(plant.h) + "]) + expression_text(r)]
    return words


def fitting(r: random.Random, folder: Path) -> list[str]:
    """A fit of one FMU to a table."""
    file = folder / r.choice(["own.csv", "own.csv", "own.parquet"])
    file.write_bytes(cells(r, DATA))
    spans = ["", "=300", "=280:320", f"={number(r)}", f"={number(r)}:{number(r)}", f"={number(r)}:280:320", "::", "=x"]
    names = ["AhvPlant.mass", "AhvPlant.V_start", "own:AhvPlant.mass", *VARIABLES, *WORDS]
    words = ["fit", str(fmu_path("native", "AhvPlant")), str(file), "--step", "0.01", "--out", str(folder / "set")]
    for _ in range(r.randint(1, 2)):
        words += ["--parameter", r.choice(names[:3] if r.random() < 0.7 else names) + r.choice(spans)]
    for option in r.sample(["--signal", "--signal", "--set", "--set", "--start", "--seed"], r.randint(0, 2)):
        words += [option, r.choice(["AhvPlant.h", "AhvPlant.h:0.1", f"AhvPlant.h:{number(r)}", *WORDS]) if option ==
                  "--signal" else assignment(r) if option == "--set" else number(r)]
    return words


def setting(r: random.Random, folder: Path) -> list[str]:
    """A run with values that are set, with units."""
    return ["run", "hold", "--stop", "0.02", "--out", str(folder / "set"),
            *(word for _ in range(r.randint(1, 2)) for word in ("--set", assignment(r)))]


def algorithms(r: random.Random, folder: Path) -> list[str]:
    """A run with an algorithm and its options."""
    return ["run", "hold", "--stop", "0.02", "--out", str(folder / "set"), "--algorithm", algorithm(r)]


def value(r: random.Random) -> object:
    """Something to stand in a YAML file."""
    kind = r.random()
    if kind < 0.3:
        return r.choice([None, True, [], {}, [[]],
            [None], {"a": 1}, 0, -1, 1.5, 2**70, float("nan"), float("inf"), -0.0,
                         1e308, 5e-324, [1, "a", None], {"distribution": "uniform"}, list(range(200))])
    return number(r) if kind < 0.6 else r.choice(WORDS)


def places(data: object, above: tuple = ()) -> list[tuple]:
    """Every place in plain data, as keys from the top."""
    below = data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list) else ()
    return [p for key, child in below for p in ((*above, key), *places(child, (*above, key)))]


def mutated(r: random.Random, good: dict) -> str:
    """The YAML of `good` with one to three mistakes, of data or of syntax."""
    data = yaml.safe_load(yaml.safe_dump(good))
    for _ in range(r.randint(1, 3)):
        place = r.choice(places(data) or [()])
        parent = data
        for key in place[:-1]:
            parent = parent[key]
        if not place:
            break
        change = r.random()
        if change < 0.2 and isinstance(parent, dict):
            del parent[place[-1]]
        elif change < 0.3 and isinstance(parent, dict):
            parent[r.choice([*WORDS, *VARIABLES, 1, None])] = parent.pop(place[-1])
        else:
            parent[place[-1]] = value(r)
    return yaml.safe_dump(data, allow_unicode=True)


def yaml_text(r: random.Random, good: dict) -> bytes:
    """A file: mistakes of data, of syntax, or bytes that are no text."""
    kind = r.random()
    text = mutated(r, good)
    if kind < 0.2:
        text = r.choice(SYNTAX) + ("\n" + text if r.random() < 0.5 else "")
    elif kind < 0.35:
        at = r.randrange(len(text) + 1)
        text = text[:at] + r.choice([*SYNTAX, "\t", ":", "- ", "#", "'", "*x", "&x ", "!x "])[:2000] + text[at:]
    data = text.encode("utf-8", "surrogatepass")
    return data if kind > 0.03 else r.randbytes(200) + data


def scenario_file(r: random.Random, folder: Path) -> list[str]:
    """A run of a scenario file."""
    file = folder / "own.yaml"
    file.write_bytes(yaml_text(r, SCENARIO))
    return [r.choice(["run", "run", "info"]), str(file)]


def system_file(r: random.Random, folder: Path) -> list[str]:
    """A simulation of a system file."""
    file = folder / "own.yaml"
    plant, scenario = (str(fmu_path("native", name)) for name in ("AhvPlant", "AhvScenario"))
    file.write_bytes(yaml_text(r, {
        "name": "own", "components": {"plant": {"fmu": plant, "set": {"mass": 300.0}}, "scenario": scenario},
        "connections": ["scenario.scale_lift -> plant.scale_lift", ["scenario.scale_drag", "plant.scale_drag"],
                        {"from": "scenario.scale_moment", "to": "plant.scale_moment", "factor": 1.0, "offset": 0.0}],
        "parameters": {"plant.V_start": 7700.0},
        "experiment": {"start": 0, "stop": 0.02, "step": 0.01, "algorithm": "jacobi", "tolerance": 1e-6}}))
    return ["simulate", str(file), "--out", str(folder / "set")]


def cells(r: random.Random, good: list[list[str]]) -> bytes:
    """A CSV file of the rows `good` with one or two mistakes, or with bytes that are no text."""
    lines = [list(line) for line in good]
    for _ in range(r.randrange(1, 3)):
        line = r.choice(lines)
        line[r.randrange(len(line))] = r.choice(r.choice([NUMBERS, WORDS, VARIABLES]))
    data = "\n".join(map(",".join, lines)).encode("utf-8", "surrogatepass")
    return data if r.random() < 0.9 else r.randbytes(100) + data


def table(r: random.Random, folder: Path) -> list[str]:
    """A simulation of one FMU with a table of inputs."""
    file = folder / r.choice(["own.csv", "own.csv", "own.csv", "own.parquet"])
    file.write_bytes(cells(r, [["time", "fuel_ratio", "elevator"],
                               *([str(0.01 * i), "0.3", "0.1"] for i in range(3))]))
    return ["simulate", str(fmu_path("native", "AhvPlant")), "--input", str(file), "--stop", "0.02", "--step", "0.01",
            "--out", str(folder / "set")]


def distribution(r: random.Random) -> dict:
    """A distribution that may not be possible: mostly of numbers, so that the later checks are reached."""
    numbers = [0.0, 1.0, -1.0, 1e308, -1e308, 5e-324, 1e-300, 1e9, 0.5, 2.0, 100.0, 40.0, -40.0, 300.0, 320.0, 4.5]
    odd = [float("nan"), float("inf"), "x", None, True, 2**53, 2**60, [], 3, 5]
    kind = r.choice(DISTRIBUTIONS[:-1] if r.random() < 0.95 else DISTRIBUTIONS)
    wanted = {"uniform": ["low", "high"], "integer": ["low", "high"], "normal": ["mean", "std", "low", "high"],
              "log-normal": ["median", "sigma"], "choice": ["values", "weights"],
              "sinusoid": ["amplitude", "period", "phase"]}.get(kind, [])
    found: dict = {"distribution": kind}
    for key in [*wanted, *(["relative"] if r.random() < 0.3 else []), *(["also"] if r.random() < 0.1 else [])]:
        pool = [True] if key == "relative" else odd if r.random() < 0.03 else [0, 1, 7, -3, 2**53, 2**60] \
            if kind == "integer" else numbers
        found[key] = [r.choice(pool) for _ in range(r.choice([2, 2, 2, 0, 1]))] if key in ("values", "weights") \
            else ["plant.chord"] if key == "also" else r.choice(pool)
    for low, high in [("low", "high")] if r.random() < 0.7 else []:
        if isinstance(found.get(low), int | float) and isinstance(found.get(high), int | float):
            found[low], found[high] = sorted((found[low], found[high]))
    return found


def campaign_data(r: random.Random) -> bytes:
    """A campaign file: mistakes anywhere, or in its distributions."""
    if r.random() < 0.4:
        return yaml_text(r, CAMPAIGN)
    good = dict(CAMPAIGN, correlations=[], dispersions={
        r.choice(["plant.mass", "plant.CL_alpha", "scenario.scale_lift", "controller.kV", "plant.start_at_trim",
                  "plant.V_start", "plant.beta_1",
                  "scenario.h_command_base"]): distribution(r) for _ in range(r.randint(1, 2))})
    return yaml.safe_dump(good).encode()


def planned(file: Path) -> int:
    """Plan the campaign in `file` and draw from it, without flying: the exit status."""
    try:
        made = load(file)
    except UsageError as error:
        print(f"ahv: {error}")
        return 2
    for k in {0, made.campaign.runs - 1}:
        for draws in made.job.draws.values():
            for row in rows(made.job.sampler, draws, k, k + 1):
                assert all(not isinstance(v, float) or np.isfinite(v) for v in row.values()), row
    return 0


def campaign_file(r: random.Random, folder: Path) -> Callable[[], int]:
    """A campaign, planned."""
    file = folder / "own_campaign.yaml"
    file.write_bytes(campaign_data(r))
    return lambda: planned(file)


def other_campaign(r: random.Random, folder: Path) -> Callable[[], int]:
    """A campaign of samples, a grid, a rule, rare failures or any system, planned."""
    file = folder / "own_campaign.yaml"
    if not (folder / "AhvPlant.fmu").exists():
        (folder / "AhvPlant.fmu").symlink_to(fmu_path("native", "AhvPlant"))
    good = r.choice(CAMPAIGNS)
    right = b"\n".join(",".join(line).encode() for line in SAMPLES)
    wrong = "samples" in good and r.random() < 0.6
    (folder / "draws.csv").write_bytes(cells(r, SAMPLES) if wrong else right)
    file.write_bytes(yaml.safe_dump(good).encode() if wrong else yaml_text(r, good))
    return lambda: planned(file)


def expression_text(r: random.Random) -> str:
    """An expression, or what is none."""
    if r.random() < 0.2:
        return r.choice(EXPRESSIONS)
    return "".join(r.choice(["", "-", "not ",
        "("]) + r.choice(TERMS) + r.choice(BETWEEN) for _ in range(r.randint(1, 6))) \
        + r.choice(TERMS)


def expression(r: random.Random, folder: Path) -> list[str]:
    """A campaign whose criterion may be none, and whose plant is none."""
    file = folder / "own_expression.yaml"
    data = dict(CAMPAIGN, plant="nobody", success={"it": expression_text(r)})
    file.write_text(yaml.safe_dump(data, allow_unicode=True), errors="surrogatepass")
    return ["campaign", str(file)]


def odd(r: random.Random, xml: bytes, fields: list[str]) -> tuple[str, str]:
    """A text in `xml`, and what to put in its place: another encoding, or one of `fields` with an odd value."""
    if r.random() < 0.25:
        return 'encoding="UTF-8"', f'encoding="{r.choice(ENCODINGS)}"'
    field = r.choice([field for field in fields if field.encode() in xml])
    name = field.partition("=")[0] if field.endswith('"') else field
    begin = f'{name}="' if field.endswith('"') else field
    end = '"' if field.endswith('"') else ""
    values = [begin + value + end for value in ATTRIBUTES]
    return field, r.choice([*values, "", f"{field} {field}", "<!--", "<a>" * 5000, "<!DOCTYPE a>"])


def description(r: random.Random, folder: Path) -> list[str]:
    """An FMU whose modelDescription.xml is odd."""
    fmu = fmu_path("native", "AhvController")
    file = redescribed(fmu, folder / "odd.fmu", odd(r, text_of(fmu, "modelDescription.xml"), FIELDS))
    return r.choice([["info", str(file)], ["check", "--no-dynamic", str(file)],
                     ["ssp", "hold", "--controller", f"odd={file}"],
                     ["run", "hold", "--stop", "0.02", "--out", str(folder / "set"), "--controller", f"odd={file}"]])


def structure(r: random.Random, folder: Path) -> list[str]:
    """An SSP whose SystemStructure.ssd is odd."""
    whole = folder / "whole.ssp"
    if not whole.exists():
        ended(["ssp", "hold", "--out", str(whole)])
    xml = text_of(whole, "SystemStructure.ssd")
    file = redescribed(whole, folder / "odd.ssp", odd(r, xml, STRUCTURE), member="SystemStructure.ssd")
    return ["simulate", str(file), "--stop", "0.02", "--step", "0.01", "--out", str(folder / "set")]


def text_of(archive: Path, member: str) -> bytes:
    """A member of an FMU or SSP."""
    with zipfile.ZipFile(archive) as file:
        return file.read(member)


KINDS = {"command lines": (command_line, 600), "values with units": (setting, 250), "algorithms": (algorithms, 200),
         "scenario files": (scenario_file, 300), "campaign files": (campaign_file, 400),
         "expressions": (expression, 300),
         "descriptions": (description, 150),
         "systems": (structure, 100), "system files": (system_file, 200), "tables": (table, 150),
         "variants": (variants, 150), "sweeps": (sweeping, 200), "fits": (fitting, 200),
         "other campaigns": (other_campaign, 400)}


def drawn(kind: str, k: int, folder: Path) -> Bad:
    """Bad input number k of a kind; files go to `folder`."""
    r = random.Random(f"{kind} {k}")
    made = KINDS[kind][0](r, folder)
    if callable(made):
        return Bad(kind, made, f"{kind} {k}")
    return Bad(kind, lambda: ended(made), f"{kind} {k}: {[w if len(w) < 100 else w[:60] + '...' for w in made]}")


def ended(words: list[str]) -> int:
    """The exit status of a command line, in this process."""
    try:
        return done(words)
    except SystemExit as end:
        return int(end.code or 0)
