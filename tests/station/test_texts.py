"""texts.yaml: what a laboratory may change, and what is refused before a participant could see it."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest
import yaml

from pipeline.contract.errors import BelvedereError
from pipeline.contract.yamls import read_yaml
from pipeline.station.texts import FILLED, TEXTS_FILE, read_texts

WEB = TEXTS_FILE.parent / "web"


def written(folder: Path, tree: dict[str, Any]) -> Path:
    path = folder / "texts.yaml"
    path.write_text(yaml.safe_dump(tree, allow_unicode=True), encoding="utf-8")
    return path


def leaves(node: Any, place: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """The places of all texts of a tree."""
    if isinstance(node, str):
        return [place]
    entries = node.items() if isinstance(node, dict) else enumerate(node)
    return [leaf for key, entry in entries for leaf in leaves(entry, (*place, key))]


def set_at(tree: Any, place: tuple[Any, ...], value: Any) -> None:
    for key in place[:-1]:
        tree = tree[key]
    tree[place[-1]] = value


TREE = read_yaml(TEXTS_FILE)
PLACES = leaves(TREE)


def test_the_page_gets_every_text_as_it_stands_in_the_file() -> None:
    assert json.loads(read_texts().page_json()) == TREE


def test_a_translation_is_taken(tmp_path: Path) -> None:
    tree = read_yaml(TEXTS_FILE)
    tree["language"] = "de-CH"
    set_at(tree, ("consent", "paragraphs"), ["Sie steuern einen Roboterarm.", "Fragen?"])
    texts = read_texts(written(tmp_path, tree))
    assert texts.consent.paragraphs[1] == "Fragen?"


def test_another_wording_of_the_consent_has_another_hash(tmp_path: Path) -> None:
    before = read_texts().consent_sha256()
    assert read_texts(written(tmp_path, read_yaml(TEXTS_FILE))).consent_sha256() == before
    tree = read_yaml(TEXTS_FILE)
    tree["consent"]["agree"] += " "
    assert read_texts(written(tmp_path, tree)).consent_sha256() != before
    other = read_yaml(TEXTS_FILE)
    other["thanks"]["heading"] = "Danke"
    assert read_texts(written(tmp_path, other)).consent_sha256() == before


@pytest.mark.parametrize("place", PLACES, ids=lambda place: ".".join(map(str, place)))
def test_no_text_may_be_empty_or_have_a_word_that_is_not_filled_in(
    tmp_path: Path, place: tuple[Any, ...]
) -> None:
    for value in (" ", "{nobody} knows"):
        tree = read_yaml(TEXTS_FILE)
        set_at(tree, place, value)
        with pytest.raises(BelvedereError) as caught:
            read_texts(written(tmp_path, tree))
        assert ".".join(map(str, place)) in str(caught.value) and "\n" not in str(caught.value)


@pytest.mark.parametrize("key", sorted(set(TREE) - {"tasks"}))
def test_a_section_that_lacks_is_named(tmp_path: Path, key: str) -> None:
    tree = read_yaml(TEXTS_FILE)
    del tree[key]
    with pytest.raises(BelvedereError, match=key):
        read_texts(written(tmp_path, tree))


def test_an_unknown_key_and_a_missing_default_are_named(tmp_path: Path) -> None:
    tree = read_yaml(TEXTS_FILE)
    tree["ready"]["heeding"] = "?"
    with pytest.raises(BelvedereError, match=r"ready\.heeding"):
        read_texts(written(tmp_path, tree))
    tree = read_yaml(TEXTS_FILE)
    del tree["tasks"]["default"]
    with pytest.raises(BelvedereError, match="default"):
        read_texts(written(tmp_path, tree))


def test_the_words_that_are_filled_in_are_those_of_the_texts() -> None:
    """Every place of FILLED is one of the file's, and the file uses each of its words."""
    used: dict[str, set[str]] = {}
    for place in PLACES:
        node: Any = TREE
        for key in place:
            node = node[key]
        name = ".".join(map(str, place))
        name = name if name in FILLED else f"{name.rpartition('.')[0]}.*"
        used.setdefault(name, set()).update(re.findall(r"\{(\w+)\}", node))
    assert {name: used.get(name) for name in FILLED} == FILLED


def test_the_page_reads_every_text() -> None:
    """Each key's name stands in the page's modules; of what is gone through as a whole, the whole's does."""
    code = "".join(path.read_text(encoding="utf-8") for path in WEB.glob("*.js"))
    whole = {"rows", "scales", "errors", "steps", "tasks", "flags"}
    outcomes = {"grasped", "timeout"}  # `words[data.outcome]`
    for place in PLACES:
        names = [part for part in place if isinstance(part, str)]
        read = next((name for name in names if name in whole), names[-1])
        assert read in outcomes or re.search(rf"""\.{read}\b|"{read}"|\b{read}:""", code), place
