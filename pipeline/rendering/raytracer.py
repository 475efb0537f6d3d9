"""What rays from one fixed camera hit first, in many worlds at once: Warp kernels.

All worlds share the camera, so what stands still is traced once and bounds every picture's rays.
Of what moves, ray packets are tested against what their pixels can hold, nearest first, until it is too far.
"""

# mypy: disable-error-code="misc, index"
# (a kernel is no Python: its values have other types inside than outside)

from __future__ import annotations

import warp as wp

from pipeline.rendering.bvh import intersect_mesh
from pipeline.rendering.ray_packets import LANES, MESH, PLANE, SIDE, intersect_primitive

wp.set_module_options({"enable_backward": False, "fast_math": True})

FAR_M = 1.0e10
_BEHIND_M = 1.0e-3
_SLACK = 0.01  # samples; covers rounding


@wp.struct
class Geom:
    """A drawn geom, the same in every world."""

    number: int  # in the model
    kind: int
    size: wp.vec3
    rgb: wp.vec3
    middle: wp.vec3  # of the bounding box, in the geom's frame
    half: wp.vec3
    mesh: wp.uint64
    first_face: int  # of the mesh, in the list of all faces


@wp.struct
class Placed:
    """A geom in one world, as the camera sees it."""

    place: int  # in the list of geoms
    near_m: float  # no point of it is nearer to the camera
    window: wp.vec4i  # first and last column, first and last row, of samples that it can cover
    position: wp.vec3
    rotation: wp.mat33
    origin: wp.vec3  # the camera, in the geom's frame


@wp.struct
class View:
    """The camera, and light that reaches everything."""

    origin: wp.vec3
    rotation: wp.mat33
    focal: float  # in samples
    samples: int  # rays a side of the picture
    ambient: wp.vec3


@wp.struct
class Hits:
    """What each world's rays hit, shape (worlds, rays); face and barycentric u, v are of meshes only."""

    distance: wp.array2d[float]
    slot: wp.array2d[int]  # in the world's list of placed geoms; -1: nothing
    face: wp.array2d[int]
    u: wp.array2d[float]
    v: wp.array2d[float]


@wp.func
def _window(geom: Geom, position: wp.vec3, rotation: wp.mat33, view: View) -> wp.vec4i:
    """The rectangle of samples that holds the geom's bounding box."""
    last = view.samples - 1
    whole = wp.vec4i(0, last, 0, last)
    if geom.kind == wp.static(PLANE):
        return whole
    low, high = wp.vec2(FAR_M), wp.vec2(-FAR_M)
    for corner in range(8):
        share = wp.vec3(float(corner & 1), float((corner >> 1) & 1), float(corner >> 2))
        local = geom.middle + wp.cw_mul(2.0 * share - wp.vec3(1.0), geom.half)
        seen = wp.transpose(view.rotation) * (position + rotation * local - view.origin)
        if seen[2] > -_BEHIND_M:
            return whole
        at = wp.vec2(seen[0], -seen[1]) * (view.focal / -seen[2])
        low = wp.min(low, at)
        high = wp.max(high, at)
    middle = 0.5 * float(view.samples) - 0.5
    return wp.vec4i(
        wp.max(int(wp.ceil(low[0] + middle - _SLACK)), 0),
        wp.min(int(wp.floor(high[0] + middle + _SLACK)), last),
        wp.max(int(wp.ceil(low[1] + middle - _SLACK)), 0),
        wp.min(int(wp.floor(high[1] + middle + _SLACK)), last),
    )


@wp.kernel
def survey(
    geoms: wp.array[Geom],
    position: wp.array2d[wp.vec3],
    rotation: wp.array2d[wp.mat33],
    view: View,
    placed: wp.array2d[Placed],
    visible: wp.array[int],
) -> None:
    """Lists, for each world, the geoms that can be in the picture, nearest first."""
    world = wp.tid()
    count = wp.int32(0)
    for place in range(geoms.shape[0]):
        geom = geoms[place]
        new = Placed()
        new.place = place
        new.position = position[world, geom.number]
        new.rotation = rotation[world, geom.number]
        new.window = _window(geom, new.position, new.rotation, view)
        if new.window[0] <= new.window[1] and new.window[2] <= new.window[3]:
            new.origin = wp.transpose(new.rotation) * (view.origin - new.position)
            if geom.kind != wp.static(PLANE):
                outside = wp.max(wp.abs(new.origin - geom.middle) - geom.half, wp.vec3(0.0))
                new.near_m = 0.9999 * wp.length(outside)
            slot = int(count)
            while slot > 0:
                if placed[world, slot - 1].near_m <= new.near_m:
                    break
                placed[world, slot] = placed[world, slot - 1]
                slot -= 1
            placed[world, slot] = new
            count += 1
    visible[world] = count


@wp.func
def _intersect_geom(
    geom: Geom,
    placed: Placed,
    origin: wp.vec3,
    rays: wp.array2d[float],
    world: int,
    first: int,
    slot: int,
    hits: Hits,
) -> float:
    """A packet against a geom that is no mesh; returns how far the farthest ray now reaches."""
    reach = wp.float32(0.0)
    for lane in range(first, first + wp.static(LANES)):
        ray = wp.vec3(rays[0, lane], rays[1, lane], rays[2, lane])
        distance, _ = intersect_primitive(geom.kind, geom.size, placed.position, placed.rotation, origin, ray)
        if distance >= 0.0 and distance < hits.distance[world, lane]:
            hits.distance[world, lane] = distance
            hits.slot[world, lane] = slot
        reach = wp.max(reach, hits.distance[world, lane])
    return reach


@wp.kernel
def trace(
    geoms: wp.array[Geom],
    triangles: wp.array2d[float],
    placed: wp.array2d[Placed],
    visible: wp.array[int],
    view: View,
    rays: wp.array2d[float],
    limits: wp.array[float],
    hits: Hits,
) -> None:
    """What each ray hits first, nearer than ``limits``; one thread a packet of rays."""
    world, down, across = wp.tid()
    packet = down * ((view.samples + wp.static(SIDE) - 1) // wp.static(SIDE)) + across
    first = packet * wp.static(LANES)
    reach = wp.float32(0.0)
    for lane in range(first, first + wp.static(LANES)):
        hits.distance[world, lane] = limits[lane]
        hits.slot[world, lane] = -1
        reach = wp.max(reach, limits[lane])
    row, column = down * wp.static(SIDE), across * wp.static(SIDE)
    for slot in range(visible[world]):
        if placed[world, slot].near_m >= reach:
            break
        window = placed[world, slot].window
        if window[1] < column or window[0] >= column + wp.static(SIDE):
            continue
        if window[3] < row or window[2] >= row + wp.static(SIDE):
            continue
        geom = geoms[placed[world, slot].place]
        if geom.kind == wp.static(MESH):
            reach = intersect_mesh(
                geom.mesh,
                triangles,
                geom.first_face,
                placed[world, slot].origin,
                placed[world, slot].rotation,
                rays,
                world,
                packet,
                slot,
                hits.distance,
                hits.slot,
                hits.face,
                hits.u,
                hits.v,
            )
        else:
            reach = _intersect_geom(geom, placed[world, slot], view.origin, rays, world, first, slot, hits)
