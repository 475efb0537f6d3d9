"""Where networks run: chosen by the environment, bad choices refused."""

from __future__ import annotations

import pytest
import torch

from pipeline.contract.errors import BelvedereError
from pipeline.learning.device import Compute, set_up_torch


@pytest.mark.parametrize(
    ("variable", "value"),
    [
        ("BELVEDERE_DEVICE", "gpu"),
        ("BELVEDERE_DTYPE", "float16"),
    ],
)
def test_a_bad_choice_is_named(monkeypatch: pytest.MonkeyPatch, variable: str, value: str) -> None:
    monkeypatch.setenv(variable, value)
    with pytest.raises(BelvedereError, match=f"{variable}.*{value}"):
        set_up_torch()


@pytest.mark.skipif(torch.cuda.is_available(), reason="there is a CUDA device")
def test_cuda_is_refused_where_there_is_none(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("BELVEDERE_DEVICE", "cuda")
    with pytest.raises(BelvedereError, match="use auto or cpu"):
        set_up_torch()


def test_the_choice_is_followed(monkeypatch: pytest.MonkeyPatch) -> None:
    before = torch.get_num_threads()
    for variable, value in (("BELVEDERE_DEVICE", "cpu"), ("BELVEDERE_DTYPE", "bfloat16")):
        monkeypatch.setenv(variable, value)
    place = set_up_torch()
    try:
        assert (place.device.type, place.dtype, torch.get_num_threads()) == ("cpu", torch.bfloat16, 1)
        assert not torch.backends.cudnn.allow_tf32
        with place.autocast():
            assert (torch.ones(2, 2) @ torch.ones(2, 2)).dtype == torch.bfloat16
    finally:
        torch.set_num_threads(before)


@pytest.mark.parametrize(
    ("device", "recurrent", "enabled"),
    [("cpu", False, True), ("cpu", True, True), ("cuda", False, True), ("cuda", True, False)],
)
def test_a_recurrent_network_on_cuda_stays_in_float32(
    monkeypatch: pytest.MonkeyPatch, device: str, recurrent: bool, enabled: bool
) -> None:
    asked: list[tuple[object, ...]] = []
    monkeypatch.setattr(torch, "autocast", lambda *given, enabled: asked.append((*given, enabled)))
    Compute(torch.device(device), torch.bfloat16).autocast(recurrent)
    assert asked == [(device, torch.bfloat16, enabled)]
