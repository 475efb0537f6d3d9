"""Colours of what rays have met: Warp kernels.

Shading is MuJoCo's without specular light, textures and shadows: Lambert under the headlight, which
shines as the camera looks, and under directional lights, with MuJoCo's smooth mesh normals, on both
sides of a surface.
"""

# mypy: disable-error-code="misc, index"
# (a kernel is no Python: its values have other types inside than outside)

from __future__ import annotations

import warp as wp

from pipeline.sim.packets import LANES, MESH, SIDE, meet_primitive
from pipeline.sim.raytracer import Geom, Hits, Placed, View

wp.set_module_options({"enable_backward": False, "fast_math": True})


@wp.struct
class Light:
    """A directional light."""

    towards: wp.vec3
    diffuse: wp.vec3


@wp.struct
class Subject:
    """What is painted, and by what light."""

    geoms: wp.array[Geom]
    corner_normals: wp.array[wp.vec3]  # three a face of each mesh
    placed: wp.array2d[Placed]
    rays: wp.array2d[float]
    lights: wp.array[Light]
    view: View


@wp.func
def _shade(world: int, lane: int, slot: int, hits: Hits, subject: Subject) -> wp.vec3:
    """The colour of what was hit, each channel 0 to 1."""
    placed = subject.placed[world, slot]
    geom = subject.geoms[placed.place]
    direction = wp.vec3(subject.rays[0, lane], subject.rays[1, lane], subject.rays[2, lane])
    normal = wp.vec3(0.0)
    if geom.kind == wp.static(MESH):
        first = geom.normals + 3 * hits.face[world, lane]
        u, v = hits.u[world, lane], hits.v[world, lane]
        a, b = subject.corner_normals[first], subject.corner_normals[first + 1]
        smooth = a * u + b * v + subject.corner_normals[first + 2] * (1.0 - u - v)
        normal = wp.normalize(placed.rotation * smooth)
    else:
        _, normal = meet_primitive(
            geom.kind, geom.size, placed.position, placed.rotation, subject.view.origin, direction
        )
    if wp.dot(normal, direction) > 0.0:
        normal = -normal
    light = wp.vec3(0.0)
    light += subject.view.ambient
    for index in range(subject.lights.shape[0]):
        source = subject.lights[index]
        light += source.diffuse * wp.max(wp.dot(normal, source.towards), 0.0)
    return wp.min(wp.cw_mul(geom.rgb, light), wp.vec3(1.0))


@wp.kernel
def paint_still(
    hits: Hits, subject: Subject, background: wp.vec3, rgb: wp.array[wp.vec3], numbers: wp.array[int]
) -> None:
    """Colours of world 0's samples, and the model's numbers of their geoms (-1: none)."""
    lane = wp.tid()
    slot = hits.slot[0, lane]
    rgb[lane] = background
    numbers[lane] = -1
    if slot >= 0:
        rgb[lane] = _shade(0, lane, slot, hits, subject)
        numbers[lane] = subject.geoms[subject.placed[0, slot].place].number


@wp.kernel
def paint(
    hits: Hits,
    subject: Subject,
    still_rgb: wp.array[wp.vec3],
    still_numbers: wp.array[int],
    antialias: int,
    target: int,
    span: int,
    rgb: wp.array4d[wp.uint8],
    seen: wp.array[int],
) -> None:
    """Pictures, ``span`` pixels of a row a thread; ``seen`` counts the samples of geom ``target``."""
    world, row, part = wp.tid()
    packets = (subject.view.samples + wp.static(SIDE) - 1) // wp.static(SIDE)
    scale = 255.0 / float(antialias * antialias)
    count = wp.int32(0)
    for column in range(part * span, wp.min((part + 1) * span, rgb.shape[2])):
        total = wp.vec3(0.0)
        for index in range(antialias * antialias):
            y = row * antialias + index // antialias
            x = column * antialias + index % antialias
            packet = (y // wp.static(SIDE)) * packets + x // wp.static(SIDE)
            lane = packet * wp.static(LANES) + (y % wp.static(SIDE)) * wp.static(SIDE) + x % wp.static(SIDE)
            slot = hits.slot[world, lane]
            number = still_numbers[lane]
            colour = still_rgb[lane]
            if slot >= 0:
                number = subject.geoms[subject.placed[world, slot].place].number
                colour = _shade(world, lane, slot, hits, subject)
            total += colour
            if number == target:
                count += 1
        for channel in range(3):
            rgb[world, row, column, channel] = wp.uint8(total[channel] * scale)
    if count > 0:
        wp.atomic_add(seen, world, count)
