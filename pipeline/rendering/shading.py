"""Colours of what rays have met: Warp kernels.

Shading is MuJoCo's without specular light, textures and shadows: Lambert under the headlight, which
shines as the camera looks, and under directional lights, with MuJoCo's smooth mesh normals, on both
sides of a surface.
"""

# mypy: disable-error-code="misc, index"
# (a kernel is no Python: its values have other types inside than outside)

from __future__ import annotations

import warp as wp

from pipeline.rendering.ray_packets import LANES, MESH, SIDE, intersect_primitive
from pipeline.rendering.raytracer import Geom, Hits, Placed, View

wp.set_module_options({"enable_backward": False, "fast_math": True})


@wp.struct
class Light:
    """A directional light."""

    towards: wp.vec3
    diffuse: wp.vec3


@wp.struct
class Subject:
    """What is shaded, and by what light."""

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
        first = 3 * (geom.first_face + hits.face[world, lane])
        u, v = hits.u[world, lane], hits.v[world, lane]
        a, b = subject.corner_normals[first], subject.corner_normals[first + 1]
        smooth = a * u + b * v + subject.corner_normals[first + 2] * (1.0 - u - v)
        normal = wp.normalize(placed.rotation * smooth)
    else:
        _, normal = intersect_primitive(
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


@wp.func
def _lane(row: int, column: int, samples: int) -> int:
    """Where a sample stands among the rays, packet by packet."""
    packets = (samples + wp.static(SIDE) - 1) // wp.static(SIDE)
    packet = (row // wp.static(SIDE)) * packets + column // wp.static(SIDE)
    return packet * wp.static(LANES) + (row % wp.static(SIDE)) * wp.static(SIDE) + column % wp.static(SIDE)


@wp.kernel
def shade_static(hits: Hits, subject: Subject, background: wp.vec3, rgb: wp.array[wp.vec3]) -> None:
    """Colours of world 0's samples."""
    lane = wp.tid()
    slot = hits.slot[0, lane]
    rgb[lane] = background
    if slot >= 0:
        rgb[lane] = _shade(0, lane, slot, hits, subject)


@wp.kernel
def shade(
    hits: Hits,
    subject: Subject,
    still_rgb: wp.array[wp.vec3],
    still_pixels: wp.array3d[wp.uint8],
    antialias: int,
    target: wp.vec2i,
    rgb: wp.array4d[wp.uint8],
    seen: wp.array[int],
) -> None:
    """Pictures, a row a thread, from the samples' hits and, where there are none, ``still_pixels``.

    ``seen`` counts the samples of the geoms from ``target[0]`` to before ``target[1]``, which move.
    """
    world, row = wp.tid()
    scale = 255.0 / float(antialias * antialias)
    count = wp.int32(0)
    for column in range(rgb.shape[2]):
        total = wp.vec3(0.0)
        moved = wp.int32(0)
        for down in range(antialias):
            for across in range(antialias):
                lane = _lane(row * antialias + down, column * antialias + across, subject.view.samples)
                slot = hits.slot[world, lane]
                if slot >= 0:
                    moved += 1
                    total += _shade(world, lane, slot, hits, subject)
                    number = subject.geoms[subject.placed[world, slot].place].number
                    if number >= target[0] and number < target[1]:
                        count += 1
                elif antialias > 1:
                    total += still_rgb[lane]
        for channel in range(3):
            if moved > 0:
                rgb[world, row, column, channel] = wp.uint8(total[channel] * scale)
            else:
                rgb[world, row, column, channel] = still_pixels[row, column, channel]
    if count > 0:
        wp.atomic_add(seen, world, count)


@wp.kernel
def shade_static_pixels(
    still_rgb: wp.array[wp.vec3], samples: int, antialias: int, pixels: wp.array3d[wp.uint8]
) -> None:
    """The picture of what stands still."""
    row, column = wp.tid()
    total = wp.vec3(0.0)
    for down in range(antialias):
        for across in range(antialias):
            total += still_rgb[_lane(row * antialias + down, column * antialias + across, samples)]
    for channel in range(3):
        pixels[row, column, channel] = wp.uint8(total[channel] * (255.0 / float(antialias * antialias)))
