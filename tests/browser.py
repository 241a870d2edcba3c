"""Pages in Debian's headless Chromium, through Playwright."""
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from playwright.sync_api import Browser, Page, sync_playwright

CHROMIUM = Path("/usr/bin/chromium")


@contextmanager
def chromium() -> Iterator[Browser]:
    """A browser, which is closed at the end."""
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        try:
            yield browser
        finally:
            browser.close()


class Watched:
    """A page, with what it says on the console and asks for, which a test wants to be nothing."""

    def __init__(self, browser: Browser, width: int = 1366, height: int = 900, **options: object):
        self.context = browser.new_context(viewport={"width": width, "height": height}, **options)
        self.page: Page = self.context.new_page()
        self.said: list[str] = []
        self.asked: list[str] = []
        self.page.on("console", lambda message: self.said.append(message.text))
        self.page.on("pageerror", lambda error: self.said.append(str(error)))
        self.page.on("dialog", lambda dialog: (self.said.append(f"dialog {dialog.message}"), dialog.dismiss()))
        self.context.on("request", lambda request: self.asked.append(request.url))

    def elsewhere(self) -> list[str]:
        """What it asked for that is neither the file nor made by itself."""
        return [url for url in self.asked if not url.startswith(("file:", "blob:", "data:"))]


FOCUSABLE = "a[href], button, input, select, textarea, summary, [tabindex='0']"
STOPS = f"""() => {{
  const reached = document.activeElement, style = getComputedStyle(reached);
  const all = [...document.querySelectorAll("{FOCUSABLE}")].filter((e) => !e.disabled && e.checkVisibility());
  return [all.indexOf(reached), all.length, style.outlineStyle !== "none" && parseFloat(style.outlineWidth) >= 2];
}}"""


def tabbed(page: Page) -> list[bool]:
    """Press Tab through a page: for each control, whether it is reached in its order and shows that it is."""
    page.locator("body").evaluate("(body) => { body.tabIndex = -1; body.focus(); }")
    count, found = page.evaluate(STOPS)[1], []
    for i in range(count):
        page.keyboard.press("Tab")
        at, _, shown = page.evaluate(STOPS)
        found.append(at == i and shown)
    return found
