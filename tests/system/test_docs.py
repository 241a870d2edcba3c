"""What the pages say: their links, commands and tests exist, their examples fly, the site loads nothing remote."""
import json
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
import typer
from command import carried_out

from cosim.cli.app import app
from cosim.vehicle.registry import LAWS

ROOT = Path(__file__).parents[2]
PAGES = sorted([*(ROOT / "docs").rglob("*.md"), *ROOT.glob("*.md")])
COMMANDS = typer.main.get_command(app).commands
SCENARIOS = dict(re.findall(r"<!-- example: (\S+) -->\n```yaml\n(.*?)```", (ROOT / "docs" / "scenarios.md").read_text(),
                            re.DOTALL))


def ident(page: Path) -> str:
    return page.relative_to(ROOT).as_posix()


def command_lines(text: str) -> list[str]:
    """Commands that a reader may paste: in indented code, in fences, and `ahv ...` in a sentence."""
    lines = re.findall(r"^(?:    )?(?:you\$\s+)?(ahv [^\n`]*)$", text, re.MULTILINE)
    return [line.partition("  #")[0].strip() for line in lines] + re.findall(r"`(ahv [a-z][^`\n]*)`", text)


@pytest.mark.parametrize("page", PAGES, ids=ident)
def test_links_lead_to_files(page):
    targets = [target.partition("#")[0] for target in re.findall(r"\]\(([^)\s]+)\)", page.read_text())]
    missing = [t for t in targets if t and "://" not in t and not (page.parent / t).exists()]
    assert missing == []


@pytest.mark.parametrize("page", PAGES, ids=ident)
def test_commands_and_their_options_exist(page):
    for line in command_lines(page.read_text()):
        word, *rest = shlex.split(line)[1:]
        if word.startswith("--"):
            assert word in ("--version", "--install-completion"), line
            continue
        assert word in COMMANDS, line
        known = {option for parameter in COMMANDS[word].params
                 for option in [*parameter.opts, *parameter.secondary_opts]}
        used = {option.partition("=")[0] for option in rest if option.startswith("--")}
        assert word == "bench" or used <= known, line


def test_tests_that_the_pages_name_exist():
    defined = set(re.findall(r"^def (test_\w+)", "".join(p.read_text() for p in (ROOT / "tests").rglob("*.py")),
                             re.MULTILINE))
    named = {name for page in PAGES for name in re.findall(r"`(test_\w+)`", page.read_text())}
    assert len(named) > 20
    assert named <= defined


@pytest.mark.parametrize("page", [page for page in PAGES if page.parent != ROOT], ids=ident)
def test_a_page_begins_with_what_its_reader_will_be_able_to_do(page):
    first = page.read_text().split("\n\n")[1]
    assert first.startswith(("After this page you ", "With this page you "))


@pytest.mark.parametrize("law", LAWS)
def test_every_law_has_its_page_and_block_diagram(law):
    text = (ROOT / "docs" / "laws" / f"{law}.md").read_text()
    assert f"{LAWS[law].fmu}.fmu" in text and f"../pictures/blocks_{law}.svg" in text
    headings = ("Equations", "Start", "Saturation and anti-windup", "Saving the state", "Linearisation", "Real time",
                "Why gains are `fixed`")
    assert [heading for heading in headings if f"\n## {heading}\n" not in text] == []


@pytest.mark.parametrize("name", SCENARIOS)
def test_the_scenarios_of_the_page_fly_and_their_figures_have_plain_names(name, native_fmus, tmp_path):
    (tmp_path / name).write_text(SCENARIOS[name])
    plant = ["--plant", "instrumented"] if "delay" in SCENARIOS[name] else []
    done = carried_out("run", name, *plant, "--json", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    told = json.loads(done.stdout)
    assert told["finished"] and told["altitude_error_ft"]["max_abs"] < 10
    assert (tmp_path / told["out"] / "figures" / "velocity.png").is_file()


def test_an_empty_scenario_is_level_flight_where_the_vehicle_starts(native_fmus, tmp_path):
    (tmp_path / "empty.yaml").write_text("name: empty\nstop: 5\n")
    done = carried_out("run", "empty.yaml", "--set", "plant.V_start=9000", "--json", cwd=tmp_path)
    assert json.loads(done.stdout)["velocity_error_fps"]["max_abs"] < 1e-6, done.stderr


def test_the_campaign_of_the_page_is_one_also_with_its_own_metrics(tmp_path):
    from campaigns import load

    page = (ROOT / "docs" / "campaigns.md").read_text()
    first, own = (re.search(rf"```yaml\n({begin}\n.*?)```", page, re.DOTALL)[1]
                  for begin in ("name: mass", "metrics:"))
    path = tmp_path / "campaign.yaml"
    path.write_text(first)
    assert load(path).campaign.runs == 200
    path.write_text(first.partition("success:")[0] + own)
    assert list(load(path).campaign.metrics) == ["worst", "late", "share"]


@pytest.mark.parametrize("script", ["draw_blocks", "draw_vehicle", "draw_stepping", "draw_campaign"])
def test_pictures_can_be_drawn_again(script, tmp_path):
    subprocess.run([sys.executable, ROOT / "docs" / f"{script}.py", tmp_path], check=True)
    drawn = sorted(path.name for path in tmp_path.iterdir())
    assert drawn and all((ROOT / "docs" / "pictures" / name).is_file() for name in drawn)
    assert all(path.stat().st_size > 10_000 for path in tmp_path.iterdir())


def test_the_site_builds_and_loads_nothing_from_elsewhere(tmp_path):
    pytest.importorskip("mkdocs", reason="the site is built with the extra `docs`")
    pytest.importorskip("mkdocstrings", reason="the site is built with the extra `docs`")
    done = subprocess.run([sys.executable, "-m", "mkdocs", "build", "--strict", "--site-dir", tmp_path / "site"],
                          cwd=ROOT, capture_output=True, text=True,
                          env={"PATH": "", "PYTHONPATH": str(ROOT), "PLAYGROUND": "false"})
    assert done.returncode == 0, done.stderr
    pages = list((tmp_path / "site").rglob("*.html"))
    assert len(pages) > 10
    for page in pages:
        tags = re.findall(r"<(?:script|link|img|iframe|source)\b[^>]*>", page.read_text())
        assert [tag for tag in tags if re.search(r"""(?:src|href)=["']?(?:https?:)?//""", tag)] == [], page.name
    for sheet in (tmp_path / "site").rglob("*.css"):
        assert not re.search(r"""(?:@import|url\()\s*["']?(?:https?:)?//""", sheet.read_text()), sheet.name
