"""VAE training: pictures a second against the same network computed as published, in float32."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from typing import Any

import numpy as np
import torch
import torch.nn.functional as F
from torch import Tensor

from pipeline.learning.device import compute
from pipeline.learning.training import seeded
from pipeline.sim.camera import Viewpoint
from pipeline.sim.draws import draw_episodes
from pipeline.sim.images import Images
from pipeline.sim.scene import load_scene
from pipeline.sim.worlds import Worlds
from pipeline.worldmodel import pictures
from pipeline.worldmodel.vae import LATENTS, Vae, kl_nats
from pipeline.worldmodel.vae_training import initialised, losses

SCENE, THETA_DEG, PHI_DEG = "panda_2dof", 45.0, 15.0
GOAL = 4.0
PICTURES, BATCH, STEPS, ROUNDS = 256, 64, 3, 7
KL_TOLERANCE_NATS = 16.0


class PublishedVae(Vae):
    """The same parameters, computed layer by layer as Ha and Schmidhuber (2018) publish them."""

    def encode(self, pictures: Tensor) -> tuple[Tensor, Tensor]:
        hidden = pictures
        for layer in (self.conv1, self.conv2, self.conv3, self.conv4):
            hidden = F.relu(layer(hidden))
        return self.mean(hidden.flatten(1)), self.log_variance(hidden.flatten(1))

    def decode(self, latents: Tensor) -> Tensor:
        hidden = self.spread(latents)[:, :, None, None]
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
    images = Images(scene, Viewpoint(scene=SCENE, theta=THETA_DEG, phi=PHI_DEG), count)
    return images.render(worlds.qpos, worlds.target).copy()


def ours(images: np.ndarray) -> Callable[[], None]:
    """One step of training, as the stage does it."""
    place, generator = compute(), seeded(1)
    vae = initialised(generator).to(place.device)
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

    return step


def peer(images: np.ndarray) -> Callable[[], None]:
    """One step of training of the network as published, in float32 and torch's standard layout."""
    device, generator = compute().device, seeded(1)
    vae = published(initialised(generator)).to(device)
    data = torch.from_numpy(images).permute(0, 3, 1, 2).contiguous().to(device)
    optimizer = torch.optim.Adam(vae.parameters(), lr=1e-3)

    def step() -> None:
        indices = torch.randperm(len(data), generator=generator)[:BATCH].to(device)
        inputs = data[indices].float() / 255
        mean, log_variance = vae.encode(inputs)
        noise = torch.randn(mean.shape, generator=generator).to(device)
        outputs = vae.decode(mean + (0.5 * log_variance).exp() * noise)
        kl = kl_nats(mean, log_variance).clamp(min=KL_TOLERANCE_NATS)
        loss = ((outputs - inputs).square().sum((1, 2, 3)) + kl).mean()
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()

    return step


def measure() -> dict[str, Any]:
    """Both in turns, in one run; the median of the rounds' ratios."""
    images = rendered(PICTURES)
    steps = ours(images), peer(images)
    rounds = [[_pictures_per_s(step) for step in steps] for _ in range(ROUNDS + 1)][1:]
    ratio = statistics.median(a / b for a, b in rounds)
    rates = [statistics.median(column) for column in zip(*rounds, strict=True)]
    return {
        "work": "VAE training",
        "scene": SCENE,
        "ours": rates[0],
        "peer": rates[1],
        "unit": "pictures/s",
        "ratio": ratio,
        "goal": GOAL,
        "holds": ratio >= GOAL,
    }


def _pictures_per_s(step: Callable[[], None]) -> float:
    begin_s = time.perf_counter()
    for _ in range(STEPS):
        step()
    if torch.cuda.is_available():
        torch.cuda.synchronize()
    return STEPS * BATCH / (time.perf_counter() - begin_s)


if __name__ == "__main__":
    print(measure())
