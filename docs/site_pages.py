"""A hook of mkdocs: the pages at the root of the project (README.md and others) are pages of the site too, and so is
the playground, which is made anew."""
import re
from pathlib import Path

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page

from cosim.playground import write

ROOT = Path(__file__).parent.parent
PAGES = {"README.md": "index.md", "CONTRIBUTING.md": "contributing.md", "CHANGELOG.md": "changelog.md",
         "SECURITY.md": "security.md", "LICENSE": "license.md"}
PLAYGROUND = "fly.html"


def moved(link: re.Match[str]) -> str:
    """A link as it has to be in the site: pages of docs/ lie beside it, those of the root under their names here."""
    target = link[1].removeprefix("docs/")
    name, mark, anchor = target.partition("#")
    return f"]({PAGES.get(name, name)}{mark}{anchor})"


def on_files(files: Files, config: MkDocsConfig) -> Files:
    for name, target in PAGES.items():
        text = (ROOT / name).read_text()
        content = f"# Licence\n\n```text\n{text}```\n" if name == "LICENSE" else re.sub(r"\]\(([^)]+)\)", moved, text)
        files.append(File.generated(config, target, content=content))
    if config.extra["playground"]:
        files.append(File.generated(config, PLAYGROUND, content=write.page(write.module())))
    return files


def on_page_markdown(markdown: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Links from docs/ to the root, as they are on a repository's page; and to the playground, which the site has."""
    if page.file.src_uri == "playground.md" and config.extra["playground"]:
        markdown = markdown.replace("\n\n", f"\n\n[Open the playground]({PLAYGROUND}){{ .md-button }}\n\n", 1)
    return re.sub(r"\]\((?:\.\./)+(README|CONTRIBUTING|CHANGELOG|SECURITY)\.md", lambda m: f"]({PAGES[m[1] + '.md']}",
                  markdown)
