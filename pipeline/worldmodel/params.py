"""The parts of params.yaml that the world model reads."""

from __future__ import annotations

from pydantic import Field

from pipeline.contract.params import Section
from pipeline.learning.params import Schedule


class ProbeParams(Section):
    """Section ``vae.probes``: the small network that reads positions from z."""

    hidden_units: int = Field(ge=1, le=1_000_000)
    steps: int = Field(ge=1, le=1_000_000)
    batch: int = Field(ge=1, le=1_000_000)
    learning_rate: float = Field(gt=0, le=1)


class VaeParams(Section):
    """Section ``vae``: the training and the probes."""

    schedule: Schedule
    beta: float = Field(ge=0, le=1_000_000)
    kl_tolerance_nats: float = Field(ge=0, le=1_000_000)
    probes: ProbeParams


class VaeSizes(Section):
    """Section ``budgets.*.vae``."""

    epochs: int = Field(ge=1, le=1_000_000)
    batch: int = Field(ge=1, le=1_000_000)
    frame_stride: int = Field(ge=1, le=1_000_000)


class MdnRnnParams(Section):
    """Section ``mdnrnn``: the mixture and its training."""

    schedule: Schedule
    log_sigma_bound: float = Field(gt=0, le=100)
    gradient_norm: float = Field(gt=0, le=1_000_000)


class MdnRnnSizes(Section):
    """Section ``budgets.*.mdnrnn``."""

    epochs: int = Field(ge=1, le=1_000_000)
    batch: int = Field(ge=1, le=1_000_000)
