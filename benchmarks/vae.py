"""VAE training: pictures a second against the same network computed as published, in float32, on all cores.

Ours trains as many networks side by side as there are cores, as the stage does with repeats; the
published form trains one, and each of its operations may use all cores. Small tables show what bounds
both on a CPU.
"""

from __future__ import annotations

import statistics
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import torch
import torch.nn.functional as F
from torch import Tensor

from benchmarks import timing, vae_profile
from benchmarks.rows import AT_MOST, Row, goal_row
from benchmarks.vae_profile import Step
from pipeline.contract.machine import cores
from pipeline.contract.viewpoints import Viewpoint
from pipeline.learning.device import Compute, set_up_torch
from pipeline.learning.training import seeded
from pipeline.rendering.renderer import Renderer
from pipeline.sim.draws import draw_episodes
from pipeline.sim.scene import load_scene
from pipeline.sim.worlds import Worlds
from pipeline.worldmodel import pictures
from pipeline.worldmodel.vae import LATENTS, Vae, kl_nats
from pipeline.worldmodel.vae_training import initialised, losses

SCENE, THETA_DEG, PHI_DEG = "panda_2dof", 45.0, 15.0
GOAL = 5.0
PICTURES, BATCH, STEPS, ROUNDS = 256, 64, 3, 7
KL_TOLERANCE_NATS = 16.0
FIRST_WEIGHTS, STEPS_TO_A_LOSS = 1, 30  # the seed of the former


class PublishedVae(Vae):
    """The same parameters, computed layer by layer as Ha and Schmidhuber (2018) publish them."""

    def encode(self, pictures: Tensor) -> tuple[Tensor, Tensor]:
        hidden = pictures
        for layer in (self.conv1, self.conv2, self.conv3, self.conv4):
            hidden = F.relu(layer(hidden))
        return self.mean(hidden.flatten(1)), self.log_variance(hidden.flatten(1))

    def decode(self, latents: Tensor) -> Tensor:
        hidden = self.decoder_input(latents)[:, :, None, None]
        for layer in (self.deconv1, self.deconv2, self.deconv3):
            hidden = F.relu(layer(hidden))
        return torch.sigmoid(self.deconv4(hidden))


def published(vae: Vae) -> PublishedVae:
    """The published form of ``vae``, with a copy of its weights in torch's standard layout."""
    copied = PublishedVae()
    copied.load_state_dict(vae.state_dict())
    return copied.to(memory_format=torch.contiguous_format)  # type: ignore[call-overload]


def rendered(count: int) -> np.ndarray:
    """Pictures (n, 64, 64, 3) of starts of episodes."""
    scene = load_scene(SCENE)
    worlds = Worlds(scene, count)
    worlds.reset(draw_episodes(scene, count, np.random.default_rng(1)))
    images = Renderer(scene, Viewpoint(scene=SCENE, theta=THETA_DEG, phi=PHI_DEG), count)
    return images.render(worlds.qpos, worlds.target).copy()


def ours(images: np.ndarray, seed: int) -> tuple[Vae, Step]:
    """The network, and one step of its training as the stage does it; ``seed`` is of batches and noise."""
    place, generator = set_up_torch(), seeded(seed)
    vae = initialised(seeded(FIRST_WEIGHTS)).to(place.device)
    data = pictures.fold(images).to(place.device)
    optimizer = torch.optim.Adam(vae.parameters(), lr=1e-3, fused=True)

    def step() -> None:
        indices = torch.randperm(len(data), generator=generator)[:BATCH].to(place.device)
        noise = torch.randn(BATCH, LATENTS, generator=generator).to(place.device)
        each = losses(vae, data[indices], noise, place)
        loss = (each.reconstruction + each.kl.clamp(min=KL_TOLERANCE_NATS)).mean()
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()

    return vae, step


def peer(images: np.ndarray, seed: int) -> tuple[Vae, Step]:
    """The same of the network as published, in float32 and torch's standard layout."""
    device, generator = set_up_torch().device, seeded(seed)
    vae = published(initialised(seeded(FIRST_WEIGHTS))).to(device)
    data = torch.from_numpy(images).permute(0, 3, 1, 2).contiguous().to(device)
    optimizer = torch.optim.Adam(vae.parameters(), lr=1e-3)

    def step() -> None:
        indices = torch.randperm(len(data), generator=generator)[:BATCH].to(device)
        noise = torch.randn(BATCH, LATENTS, generator=generator).to(device)
        loss = published_loss(vae, data[indices], noise)
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()

    return vae, step


def published_loss(vae: Vae, pictures_uint8: Tensor, noise: Tensor) -> Tensor:
    """The mean loss of bytes (n, 3, 64, 64) with z = mean + sigma · noise (n, 32)."""
    inputs = pictures_uint8.float() / 255
    mean, log_variance = vae.encode(inputs)
    outputs = vae.decode(mean + (0.5 * log_variance).exp() * noise)
    kl = kl_nats(mean, log_variance).clamp(min=KL_TOLERANCE_NATS)
    return ((outputs - inputs).square().sum((1, 2, 3)) + kl).mean()


def measure() -> list[Row]:
    """Speed, both in turns, as the median of the ratios; losses after the same steps; what bounds both."""
    images, n = rendered(PICTURES), cores()
    many, one = [ours(images, seed)[1] for seed in range(n)], peer(images, 1)[1]
    with ThreadPoolExecutor(n, initializer=torch.set_num_threads, initargs=(1,)) as pool:

        def side_by_side(steps: Sequence[Step]) -> float:
            return timing.seconds(lambda: list(pool.map(lambda step: step(), steps)))

        def as_published() -> None:
            torch.set_num_threads(n)
            several(one)()
            torch.set_num_threads(1)

        trainings = [several(step) for step in many]
        rounds = [
            (n * STEPS * BATCH / side_by_side(trainings), STEPS * BATCH / timing.seconds(as_published))
            for _ in range(ROUNDS + 1)
        ][1:]
        rates = [statistics.median(column) for column in zip(*rounds, strict=True)]
        bounds = (
            bound_tables((many[0], one), rates, side_by_side) if set_up_torch().device.type == "cpu" else []
        )
    ratio = statistics.median(a / b for a, b in rounds)
    return [
        goal_row("VAE training", SCENE, rates[0], rates[1], "pictures/s", ratio, GOAL),
        same_loss(images),
        *bounds,
    ]


def several(step: Step) -> Step:
    """As many steps as a round has."""
    return lambda: [step() for _ in range(STEPS)]


def bound_tables(
    steps: Sequence[Step], rates: Sequence[float], side_by_side: Callable[[Sequence[Step]], float]
) -> list[Row]:
    """The rows of :mod:`benchmarks.vae_profile`, of the published form and of ours."""
    mine, theirs = set_up_torch(), Compute(set_up_torch().device, torch.float32)
    needed = vae_profile.operations_a_picture(steps[1], BATCH) / 1e6
    forms = (("published", theirs, steps[1], rates[1]), ("ours", mine, steps[0], rates[0]))
    bounds = [
        vae_profile.bound_row(
            form, place, needed, vae_profile.product_rate(place, side_by_side, cores()), rate
        )
        for form, place, _, rate in forms
    ]
    return bounds + [vae_profile.split_row(form, step, BATCH) for form, _, step, _ in forms]


def same_loss(images: np.ndarray) -> Row:
    """The losses after the same steps from the same weights, and how far they may lie apart.

    The bound is how far other batches and noise take the published form's loss by themselves; both
    numbers are shares of that loss. All are measured alike: in float32, as published, on all pictures.
    """
    mine = loss_after(STEPS_TO_A_LOSS, *ours(images, 1), images)
    theirs, *others = (loss_after(STEPS_TO_A_LOSS, *peer(images, seed), images) for seed in (1, 2, 3))
    noise = max(abs(other - theirs) for other in others) / theirs
    work = f"VAE loss after {STEPS_TO_A_LOSS} steps, difference"
    return goal_row(work, SCENE, mine, theirs, "loss", abs(mine - theirs) / theirs, noise, AT_MOST)


def loss_after(steps: int, vae: Vae, step: Step, images: np.ndarray) -> float:
    """The loss of all pictures after so many steps of training, with the same noise for every network."""
    for _ in range(steps):
        step()
    data = torch.from_numpy(images).permute(0, 3, 1, 2)
    with torch.inference_mode():
        return float(
            published_loss(published(vae), data, torch.randn(len(data), LATENTS, generator=seeded(9)))
        )
