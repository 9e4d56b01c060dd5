"""Reading a page: its tags, the numbers of its figures, what a browser makes of it."""

from __future__ import annotations

import base64
import gzip
import json
import re
import shutil
import subprocess
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np

BROWSER = next(
    filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None
)
VOID = {"meta", "br", "img", "link", "input", "hr"}


class Page(HTMLParser):
    """Tags with their attributes; fails where they do not close in turn."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.text = path.read_text(encoding="utf-8")
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.words: list[str] = []
        self.open: list[str] = []
        self.feed(self.text)
        self.close()
        assert not self.open, self.open

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        if not {"script", "style"} & set(self.open):
            self.words.append(data)

    @property
    def shown(self) -> str:
        """Text that a reader sees, without the figures."""
        return " ".join(" ".join(self.words).split())

    def loads(self) -> list[str]:
        """Addresses that the browser would fetch."""
        asked = [attrs.get(name) for _, attrs in self.tags for name in ("src", "href", "srcset")]
        return [one for one in asked if one] + re.findall(
            r"@import|url\(", self.text.split("</style>")[0]
        )

    def figures(self) -> dict[str, dict[str, Any]]:
        """Columns of each source of each figure, by the title of the figure and its name."""
        numbers = re.search(r'id="numbers">([^<]*)<', self.text)
        assert numbers is not None
        page = json.loads(numbers[1])
        names = {
            attrs["data-plot"]: attrs["data-name"]
            for tag, attrs in self.tags
            if tag == "button" and "data-plot" in attrs
        }
        roots = page["documents"]["page"]["roots"]
        assert [root["id"] for root in roots] and set(names) == {root["id"] for root in roots}
        return {str(names[root["id"]]): dict(sources(root)) for root in roots}


def sources(node: Any) -> Any:
    """Names and columns of all sources with a name below a node of a document."""
    if isinstance(node, dict):
        attributes = node.get("attributes", {})
        if node.get("name") == "ColumnDataSource" and attributes.get("name") is not None:
            entries = attributes["data"].get("entries", [])
            yield attributes["name"], {name: plain(values) for name, values in entries}
        for part in node.values():
            yield from sources(part)
    elif isinstance(node, list):
        for part in node:
            yield from sources(part)


def plain(values: Any) -> Any:
    """An array of a document; those of a map as a list of one."""
    if isinstance(values, list):
        return [plain(one) for one in values]
    if isinstance(values, dict) and values.get("type") == "ndarray":
        data = gzip.decompress(base64.b64decode(values["array"]["data"]))
        kind = np.dtype(values["dtype"]).newbyteorder("<" if values["order"] == "little" else ">")
        return np.frombuffer(data, kind).reshape(values["shape"])
    return values


def browsed(path: Path, script: str, *options: str) -> tuple[str, str]:
    """What a script puts out in the page once it is drawn, and what the console said."""
    copy = path.with_name(f"browsed-{path.name}")
    wait = (
        "<script>(function look(){if(!document.documentElement.dataset.ready)"
        "return setTimeout(look,50);"
        f"const out=document.createElement('pre');out.id='out';out.textContent=({script})();"
        "document.body.replaceChildren(out);})()</script></body>"
    )
    copy.write_text(path.read_text(encoding="utf-8").replace("</body>", wait), encoding="utf-8")
    call = [
        str(BROWSER),
        "--headless",
        "--no-sandbox",
        "--disable-gpu",
        "--enable-logging=stderr",
        "--virtual-time-budget=20000",
        f"--user-data-dir={path.parent / 'profile'}",
        *options,
        "--dump-dom",
        copy.as_uri(),
    ]
    done = subprocess.run(call, capture_output=True, text=True, check=False, timeout=120)
    found = re.search(r'<pre id="out">(.*?)</pre>', done.stdout, re.DOTALL)
    assert found is not None, done.stderr[-2000:]
    console = "\n".join(line for line in done.stderr.splitlines() if "CONSOLE" in line)
    return found[1], console
