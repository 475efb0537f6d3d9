"""What a participant reads: texts.yaml, checked as a whole before the station opens.

A laboratory may translate or replace the file. A text that is missing, a key that is not known and a word in
braces that the page would not fill in are refused, so that no participant sees a gap.
"""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field

from pipeline.contract.errors import BelvedereError
from pipeline.contract.params import Section, section
from pipeline.station import text_sections as sections

TEXTS_FILE = Path(__file__).with_name("texts.yaml")

# Which words in braces the page fills in, by the text's place; a last * stands for any key.
FILLED = {
    "instructions.extent": {"trials", "blocks", "least", "most"},
    "gamepad.connected": {"device"},
    "gamepad.unsupported": {"device"},
    "gamepad.pressed": {"count"},
    "gamepad.outside": {"percent"},
    "gamepad.drift": {"drift", "zone"},
    "gamepad.drift_bad": {"drift", "zone"},
    "practice.left_over": {"time"},
    "practice.most_left": {"time"},
    "ready.place": {"block", "blocks", "trial", "trials"},
    "trial.heading": {"block", "blocks", "trial", "trials"},
    "axes.moves": {"axes"},
    "feedback.grasped": {"time", "distance"},
    "break.paragraphs.*": {"block", "blocks"},
    "tlx.lede": {"name"},
    "tlx.value": {"value"},
    "tlx.missing": {"scales"},
    "thanks.code": {"code"},
    "bar.rate": {"fps"},
    "bar.latency": {"p50", "p95"},
    "bar.factor": {"factor"},
}


class Texts(Section):
    """All of texts.yaml, page by page."""

    language: sections.Language
    title: sections.Words
    consent: sections.Consent
    instructions: sections.Instructions
    controls: sections.Controls
    gamepad: sections.Gamepad
    practice: sections.Practice
    ready: sections.Ready
    trial: sections.Trial
    axes: sections.FreeAxes
    tasks: Annotated[dict[str, sections.Task], Field(min_length=1)]
    feedback: sections.Feedback
    paused: sections.Paused
    break_: Annotated[sections.Break, Field(alias="break")]
    tlx: sections.Tlx
    thanks: sections.Thanks
    errors: sections.Errors
    bar: sections.Bar

    def consent_sha256(self) -> str:
        """A hash of the consent's wording, so that a changed text under an old version shows."""
        return hashlib.sha256(self.consent.model_dump_json().encode()).hexdigest()

    def page_json(self) -> str:
        """All texts, as ``/web/texts.json`` hands them to the page."""
        return json.dumps(self.model_dump(by_alias=True), ensure_ascii=False)


def read_texts(path: Path = TEXTS_FILE) -> Texts:
    """The texts of a file.

    Raises:
        BelvedereError: a text is missing, unknown or empty, no default stands under ``tasks``, or a text has
            a word in braces that the page does not fill in.
    """
    texts = section(Texts, path=path)
    if "default" not in texts.tasks:
        raise BelvedereError(f"{path}: tasks has no entry 'default', which scenes without an own entry need.")
    for place, text in _leaves(texts.model_dump(by_alias=True), ""):
        _check_braces(path, place, text)
    return texts


def _leaves(node: Any, place: str) -> Iterator[tuple[str, str]]:
    """The texts below a node, each with its place, such as ``break.paragraphs.0``."""
    entries = node.items() if isinstance(node, dict) else enumerate(node)
    for key, entry in entries:
        here = f"{place}.{key}".lstrip(".")
        if isinstance(entry, str):
            yield here, entry
        else:
            yield from _leaves(entry, here)


def _check_braces(path: Path, place: str, text: str) -> None:
    known = FILLED.get(place) or FILLED.get(f"{place.rpartition('.')[0]}.*") or set()
    for word in re.findall(r"\{([^}]*)\}", text):
        if word not in known:
            valid = ", ".join(sorted(f"{{{name}}}" for name in known)) or "no word in braces"
            raise BelvedereError(
                f"{path}: {place} has {{{word}}}, which the page does not fill in; valid: {valid}."
            )
