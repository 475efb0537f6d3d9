"""The stage ablation on written networks: what each variant changes, and that it repeats to the byte."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
import yaml

from pipeline import ablation
from pipeline.ablations.params import AblationParams
from pipeline.ablations.variants import VARIANTS, Setting, _memory, search_sizes
from pipeline.contract import params
from pipeline.contract.viewpoints import viewpoint
from pipeline.control.outcomes import provenance
from pipeline.control.params import ControllerParams, SearchSizes
from pipeline.learning.device import set_up_torch
from pipeline.sim.scene import load_scene
from pipeline.storage.artefacts import write_json
from pipeline.worldmodel.mdnrnn import MdnRnn
from pipeline.worldmodel.params import MdnRnnParams
from tests.stages.control_stages import (
    SCENE,
    VIEW,
    write_latents,
    write_params,
    write_probes,
    write_world_model,
)
from tests.stages.test_ranking import PROVENANCE

BLIND, UNIT_M = -6.0, 5.0
HERE = provenance(set_up_torch().facts())
DREAM = {"temperature": 1.0, "episodes": 3, "generations": 2}
REWARD = {"hidden_units": 8, "learning_rate": 0.01, "batch": 16, "steps": 5}
OUT = Path("ablation/found/a.json")


@pytest.fixture
def workplace(workplace: Path) -> Path:
    write_params(workplace)
    tree = yaml.safe_load(Path("params.yaml").read_text(encoding="utf-8"))
    tree["ablation"] = {"repeats": 2, "dream": DREAM | {"reward": REWARD}}
    Path("params.yaml").write_text(yaml.safe_dump(tree), encoding="utf-8")
    rows = [{"repeat": r, "no_op": -7.0, "blind": BLIND, "expert": BLIND + UNIT_M} for r in range(2)]
    write_json(Path("anchors.json"), {"scene": SCENE, "repeats": rows, "provenance": PROVENANCE})
    place = {"scene": SCENE, "theta_deg": VIEW["theta"], "phi_deg": VIEW["phi"]}
    repeats = [{"repeat": r, "return": -2.0 - r} for r in range(3)]
    write_json(Path("view/evaluation.json"), place | {"repeats": repeats, "provenance": HERE})
    return workplace


def tried(sees: bool = True) -> dict[str, Any]:
    models, latents = write_world_model(Path(), repeats=3), write_latents(Path(), repeats=3)
    files = write_probes(Path(), sees) | {
        "evaluation": Path("view/evaluation.json"),
        "anchors": Path("anchors.json"),
        "out": OUT,
    }
    ablation.main(**VIEW, **models, **latents, **files)
    return json.loads(OUT.read_text(encoding="utf-8"))


def test_every_variant_has_a_score_and_its_change_from_the_whole_judge(workplace: Path) -> None:
    said = tried()
    assert (said["scene"], said["theta_deg"], said["phi_deg"], said["repeats"]) == (*VIEW.values(), 2)
    assert list(said["variants"]) == ["whole", *VARIANTS]
    whole = said["variants"]["whole"]
    assert whole["scores"] == pytest.approx([(-2 - BLIND) / UNIT_M, (-3 - BLIND) / UNIT_M])
    assert "change" not in whole
    for name in VARIANTS:
        own = said["variants"][name]
        changes = np.array(own["scores"]) - whole["scores"]
        assert own["change"] == pytest.approx(changes.mean())
        assert own["low"] < own["change"] < own["high"]
    assert len({tuple(own["scores"]) for own in said["variants"].values()}) == 4


def test_where_the_judge_cannot_see_no_variant_searches_longer_than_it(
    workplace: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    sizes = []

    def searched(setting: Setting, variant: str, *_: Any) -> dict[int, float]:
        sizes.append(search_sizes(setting, variant))
        return {0: -2.0, 1: -3.0}

    monkeypatch.setattr("pipeline.ablations.made.returns_without", searched)
    tried(sees=False)
    assert {own.generations for own in sizes} == {1} and len({own.episodes for own in sizes}) == 1


def test_the_same_inputs_give_the_same_bytes_and_the_second_time_nothing_is_made(
    workplace: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    tried()
    before = OUT.read_bytes()
    monkeypatch.setattr("pipeline.ablations.made.returns_without", None)
    tried()
    assert OUT.read_bytes() == before


def test_without_weights_h_stays_at_zero_and_an_untrained_one_does_not(workplace: Path) -> None:
    setting = Setting(
        scene=load_scene(SCENE),
        view=viewpoint(*VIEW.values()),
        place=set_up_torch(),
        method=ControllerParams.model_validate(yaml.safe_load(Path("params.yaml").read_text())["controller"]),
        sizes=SearchSizes(population=4, episodes=2, generations=1),
        declared=params.section(AblationParams, "ablation"),
        mdnrnn=params.section(MdnRnnParams, "mdnrnn"),
        episodes=2,
        heldout_share=0.2,
        seed=1,
    )
    trained = MdnRnn(2, log_sigma_bound=5.0)
    latents, actions = torch.randn(3, 32), torch.randn(3, 2)
    hidden = {}
    for name in VARIANTS:
        rnn = _memory(setting, name, 0, trained)
        state = rnn.initial_state(3)
        for _ in range(3):
            state = rnn.step(latents, actions, state)
        hidden[name] = state.h
    assert hidden["z alone"].abs().max() == 0 and hidden["h untrained"].abs().max() > 0
    assert not torch.equal(hidden["h untrained"], hidden["dream"])
    assert _memory(setting, "dream", 0, trained) is trained
