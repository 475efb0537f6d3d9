from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import torch

from pipeline.contract.errors import BelvedereError
from pipeline.control.policy import Controllers, hidden_weights, load_controller, parameters, save_controller
from tests.damage import flipped

ACTIONS = 2


def flat(count: int) -> np.ndarray:
    return 0.1 * np.random.default_rng(1).standard_normal((count, parameters(ACTIONS)))


def test_a_controller_has_289_parameters_per_action_dimension() -> None:
    assert [parameters(actions) for actions in (1, 2, 3)] == [289, 578, 867]


def test_the_weights_of_h_are_told_from_those_of_z_and_the_bias() -> None:
    latents, hidden = torch.randn(2, 32), torch.randn(2, 256)
    without_h = np.where(hidden_weights(ACTIONS), 0.0, flat(1))
    act = Controllers.of(without_h, ACTIONS, each=2)
    assert torch.equal(act(latents, hidden), act(latents, torch.zeros_like(hidden)))
    assert hidden_weights(ACTIONS).sum() == ACTIONS * 256


def test_each_world_is_driven_by_its_own_candidate() -> None:
    candidates, each = flat(3), 2
    latents, hidden = torch.randn(6, 32), torch.randn(6, 256)
    actions = Controllers.of(candidates, ACTIONS, each)(latents, hidden).numpy()
    for world in range(6):
        weight = candidates[world // each].reshape(ACTIONS, 289)
        features = np.concatenate([latents[world].numpy(), hidden[world].numpy(), [1.0]])
        np.testing.assert_allclose(actions[world], np.tanh(weight @ features), atol=1e-5)


def test_a_file_gives_back_what_was_saved_and_is_the_same_each_time(tmp_path: Path) -> None:
    saved = flat(1)[0]
    for name in ("a.npz", "b.npz"):
        save_controller(tmp_path / name, saved)
    np.testing.assert_array_equal(load_controller(tmp_path / "a.npz", ACTIONS), saved)
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()


def test_bad_files_are_told_in_a_sentence(tmp_path: Path) -> None:
    path = tmp_path / "repeat_0.npz"
    with pytest.raises(BelvedereError, match="is missing; `dvc repro controller` makes it"):
        load_controller(path, ACTIONS)
    save_controller(path, flat(1)[0])
    with pytest.raises(BelvedereError, match=r"shape \(2, 289\), not \(3, 289\)"):
        load_controller(path, 3)
    path.write_bytes(path.read_bytes()[:200])
    with pytest.raises(BelvedereError, match="cannot be read"):
        load_controller(path, ACTIONS)


def test_each_flipped_bit_is_refused_or_changes_nothing(tmp_path: Path) -> None:
    path, saved, refused = tmp_path / "repeat_0.npz", flat(1)[0], 0
    save_controller(path, saved)
    good = path.read_bytes()
    bits = range(0, 8 * len(good), 101)
    for bit in bits:
        path.write_bytes(flipped(good, bit))
        try:
            found = load_controller(path, ACTIONS)
        except BelvedereError as error:
            assert "dvc repro controller" in str(error)
            refused += 1
        else:
            np.testing.assert_array_equal(found, saved)
    assert refused > 0.9 * len(bits)
