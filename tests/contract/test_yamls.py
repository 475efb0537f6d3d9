"""YAML is read as DVC reads it, and what cannot be meant is refused."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml
from dvc.utils.serialize import _yaml

from pipeline.contract.errors import BelvedereError
from pipeline.contract.yamls import parse, read_yaml


@pytest.mark.parametrize(
    "text", ["a: 1\na: 1", "a: {b: 1, c: {d: 1, d: 2}}", "- {1: a, 1: b}", "a: 1\n'a': 2"]
)
def test_a_key_that_stands_twice_is_refused_as_by_dvc(text: str) -> None:
    with pytest.raises(_yaml.YAMLFileCorruptedError):
        _yaml.parse_yaml(text, "params.yaml")
    with pytest.raises(yaml.YAMLError, match="stands twice"):
        parse(text)


@pytest.mark.parametrize(
    "text", ["a: 1\nb: {a: 1}", "x: &x {a: 1}\ny: {<<: *x, a: 2}", "- a\n- a", "1: a\n'1': b"]
)
def test_equal_keys_of_different_mappings_are_not(text: str) -> None:
    assert parse(text) == _yaml.parse_yaml(text, "params.yaml")


@pytest.mark.parametrize(
    ("content", "told"),
    [
        (b"a: \xfc", "byte 3 is 0xfc"),
        ("a: 1".encode("utf-16"), "not UTF-8"),
        (b"a: [", "not valid YAML"),
        (b"a: !!python/name:os.system", "not valid YAML"),
        (b"a: " + b"9" * 5000, "not valid YAML"),
        (b"[" * 3000, "not valid YAML"),
    ],
)
def test_no_text_or_no_yaml_is_told_with_the_file(tmp_path: Path, content: bytes, told: str) -> None:
    path = tmp_path / "a.yaml"
    path.write_bytes(content)
    with pytest.raises(BelvedereError, match=told) as error:
        read_yaml(path)
    assert str(path) in str(error.value) and "\n" not in str(error.value)
