"""The page taken apart: a parser that checks it, and the cells of its tables."""

from __future__ import annotations

import re
from html import unescape
from html.parser import HTMLParser
from pathlib import Path

from pipeline import report

FOLDERS = {name: Path("reports") / name for name in ("rankings", "branches", "anchors", "pictures")}
FOLDERS |= {
    "people": Path("reports/people.json"),
    "points": Path("data/people"),
    "coverage": Path("data/coverage.csv"),
    "tried": Path("data/tried.csv"),
    "record": Path("reports/paper"),
    "searches": Path("reports/searches"),
    "ablations": Path("reports/ablations"),
}
PAGE, TABLES = Path("reports/index.html"), Path("reports/tables")
VOID = {"meta", "img", "source", "br", "hr", "link", "input"}


def build() -> str:
    """Runs the stage `report` in the working directory and returns the page."""
    report.main(**FOLDERS, out=PAGE, tables=TABLES)
    return PAGE.read_text(encoding="utf-8")


def rows(html: str, label: str) -> list[list[str]]:
    """The cells of the table in the region of that name."""
    table = html.split(f'aria-label="{label}"', 1)[1].split("</table>", 1)[0]
    body = table.split("<tbody>", 1)[1]
    cells = [
        re.findall(r"<t[hd][^>]*>(.*?)</t[hd]>", row, re.DOTALL) for row in re.split("<tr[^>]*>", body)[1:]
    ]
    return [[unescape(re.sub(r"<[^>]+>", "", cell)).strip() for cell in row] for row in cells]


class Page(HTMLParser):
    """Checks that tags balance, and collects what a page would load, its identifiers and its text."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.attributes: list[tuple[str, str, str]] = []
        self.text = ""
        self.rows: dict[str, list[str]] = {}
        self._row = ""
        self.feed(html)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.attributes += [(tag, name, value or "") for name, value in attrs]
        if tag not in VOID:
            self.open.append(tag)
        if tag == "tr":
            self._row = dict(attrs).get("data-view") or ""
        if tag in ("td", "th") and self._row:
            self.rows.setdefault(self._row, []).append("")

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.attributes += [(tag, name, value or "") for name, value in attrs]

    def handle_endtag(self, tag: str) -> None:
        assert self.open and self.open[-1] == tag, f"</{tag}> closes {self.open[-1:]}"
        self.open.pop()
        if tag == "tr":
            self._row = ""

    def handle_data(self, data: str) -> None:
        if self.open and self.open[-1] != "style":
            self.text += data
        if self._row and self.open[-1] != "tr":
            self.rows[self._row][-1] += data

    def values(self, name: str) -> list[str]:
        return [value for _, attribute, value in self.attributes if attribute == name]
