"""A hook of mkdocs: the pages at the root of the project (README.md and others) are pages of the site too."""
import re
from pathlib import Path

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files

ROOT = Path(__file__).parent.parent
PAGES = {"README.md": "index.md", "CONTRIBUTING.md": "contributing.md", "CHANGELOG.md": "changelog.md",
         "SECURITY.md": "security.md", "LICENSE": "license.md"}


def moved(link: re.Match[str]) -> str:
    """A link as it has to be in the site: pages of docs/ lie beside it, those of the root under their names here."""
    target = link[1].removeprefix("docs/")
    name, mark, anchor = target.partition("#")
    return f"]({PAGES.get(name, name)}{mark}{anchor})"


def on_files(files: Files, config: MkDocsConfig) -> Files:
    for name, page in PAGES.items():
        text = (ROOT / name).read_text()
        content = f"# Licence\n\n```text\n{text}```\n" if name == "LICENSE" else re.sub(r"\]\(([^)]+)\)", moved, text)
        files.append(File.generated(config, page, content=content))
    return files


def on_page_markdown(markdown: str, page: object, config: MkDocsConfig, files: Files) -> str:
    """Links from docs/ to the root, as they are on a repository's page."""
    return re.sub(r"\]\((?:\.\./)+(README|CONTRIBUTING|CHANGELOG|SECURITY)\.md", lambda m: f"]({PAGES[m[1] + '.md']}",
                  markdown)
