"""Traversal of a mesh by sixteen neighbouring rays from one origin, together.

Warp and mujoco_warp trace ray by ray; on the CPU a packet of neighbours through a mesh is several
times as fast, with the same picture. The layout of Warp's BVH, which Warp does not export, is known in this
file only; tests/rendering/test_renderer.py compares the pictures after an upgrade.
"""

from __future__ import annotations

import warp as wp

# Traverses the BVH of a wp.Mesh with 16 rays at once. A node is entered if any ray hits its box
# nearer than what that ray has met; the nearer child comes first. In a leaf, where faces are smaller
# than the rays are apart, each ray that hits its box is held against 16 faces at once. All rays start
# at one point, so of a face's test all but three dot products are done once (Möller and Trumbore
# 1997), and a face that shows that point its back is skipped, as MuJoCo's renderer does.
# Returns how far the farthest of the 16 rays now reaches. On CUDA each ray goes alone.
# Where the rays enter and leave a box, from where they cross its planes.
_SPAN = """
const Floats in_x = x0 < x1 ? x0 : x1, out_x = x0 < x1 ? x1 : x0;
const Floats in_y = y0 < y1 ? y0 : y1, out_y = y0 < y1 ? y1 : y0;
const Floats in_z = z0 < z1 ? z0 : z1, out_z = z0 < z1 ? z1 : z0;
const Floats in_xy = in_x > in_y ? in_x : in_y, out_xy = out_x < out_y ? out_x : out_y;
const Floats in = in_xy > in_z ? in_xy : in_z, out = out_xy < out_z ? out_xy : out_z;
const Floats end = out * 1.000001f < t ? out * 1.000001f : t;
"""
_QUERY = """
const int base = packet * 16;
float* distance = distances.data + world * distances.shape[1] + base;
int* slot_of = slots.data + world * slots.shape[1] + base;
int* face_of = faces.data + world * faces.shape[1] + base;
float* u_of = us.data + world * us.shape[1] + base;
float* v_of = vs.data + world * vs.shape[1] + base;
const float* ray_x = rays.data + base;
const float* ray_y = ray_x + rays.shape[1];
const float* ray_z = ray_y + rays.shape[1];
#if defined(__CUDA_ARCH__)
float reach = 0.0f;
for (int lane = 0; lane < 16; ++lane) {
    wp::vec3 ray(ray_x[lane], ray_y[lane], ray_z[lane]);
    wp::vec3 local = wp::mul(wp::transpose(rotation), ray), start = origin, normal;
    float passed = 0.0f, t, u, v, sign;
    int face;
    for (int backs = 0; backs < 64; ++backs) {
        const float left = distance[lane] - passed;
        if (!wp::mesh_query_ray(mesh_id, start, local, left, t, u, v, sign, normal, face)) break;
        passed += t;
        if (wp::dot(normal, local) < 0.0f) {
            distance[lane] = passed; slot_of[lane] = slot;
            face_of[lane] = face; u_of[lane] = u; v_of[lane] = v;
            break;
        }
        passed += 1.0e-5f * (1.0f + passed);
        start = wp::add(origin, wp::mul(local, passed));
    }
    reach = distance[lane] > reach ? distance[lane] : reach;
}
return reach;
#else
typedef float Floats __attribute__((vector_size(64), aligned(4)));
typedef int Ints __attribute__((vector_size(64), aligned(4)));
const float far = 3.0e38f, slack = 1.0e-5f;
const wp::Mesh mesh = wp::mesh_get(mesh_id);
const Floats wx = *(const Floats*)ray_x, wy = *(const Floats*)ray_y, wz = *(const Floats*)ray_z;
const Floats dx = wx * rotation.data[0][0] + wy * rotation.data[1][0] + wz * rotation.data[2][0];
const Floats dy = wx * rotation.data[0][1] + wy * rotation.data[1][1] + wz * rotation.data[2][1];
const Floats dz = wx * rotation.data[0][2] + wy * rotation.data[1][2] + wz * rotation.data[2][2];
const Floats tiny = dx - dx + 1.0e-20f, distant = dx - dx + far;
const Floats ix = 1.0f / (dx * dx < 1.0e-30f ? tiny : dx);
const Floats iy = 1.0f / (dy * dy < 1.0e-30f ? tiny : dy);
const Floats iz = 1.0f / (dz * dz < 1.0e-30f ? tiny : dz);
const Ints count = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
Floats t = *(Floats*)distance;
float reach = __builtin_reduce_max(t);
int stack[64];
float entry[64];
int depth = 0, node = *mesh.bvh.root;
while (true) {
    const wp::BVHPackedNodeHalf lower = mesh.bvh.node_lowers[node], upper = mesh.bvh.node_uppers[node];
    bool down = false;
    if (lower.b) {
        const Floats x0 = (lower.x - origin[0]) * ix, x1 = (upper.x - origin[0]) * ix;
        const Floats y0 = (lower.y - origin[1]) * iy, y1 = (upper.y - origin[1]) * iy;
        const Floats z0 = (lower.z - origin[2]) * iz, z1 = (upper.z - origin[2]) * iz;
        SPAN
        int hits[16];
        *(Ints*)hits = (in <= end) & (out >= 0.0f);
        for (int begin = lower.i; begin < (int)upper.i; begin += 16) {
            const float* row = triangles.data + first_triangle + begin;
            auto part = [&](int k) { return *(const Floats*)(row + k * triangles.shape[1]); };
            const Floats sx = origin[0] - part(0), sy = origin[1] - part(1), sz = origin[2] - part(2);
            const Floats nx = part(9), ny = part(10), nz = part(11);
            const Floats volume = -(nx * sx + ny * sy + nz * sz);
            const Ints facing = (count < (int)upper.i - begin) & (volume > 0.0f);
            if (!__builtin_reduce_or(facing)) continue;
            const Floats ex = part(3), ey = part(4), ez = part(5);
            const Floats fx = part(6), fy = part(7), fz = part(8);
            const Floats px = fy * sz - fz * sy, py = fz * sx - fx * sz, pz = fx * sy - fy * sx;
            const Floats qx = sy * ez - sz * ey, qy = sz * ex - sx * ez, qz = sx * ey - sy * ex;
            for (int lane = 0; lane < 16; ++lane) {
                if (!hits[lane]) continue;
                const float rx = dx[lane], ry = dy[lane], rz = dz[lane];
                const Floats towards = rx * nx + ry * ny + rz * nz;
                const Floats scale = 1.0f / (towards == 0.0f ? tiny : towards);
                const Floats at_e = (rx * px + ry * py + rz * pz) * scale;
                const Floats at_f = (rx * qx + ry * qy + rz * qz) * scale;
                const Floats at = volume * scale, at_a = 1.0f - at_e - at_f;
                const Ints inside = facing & (at_e >= -slack) & (at_f >= -slack) & (at_a >= -slack);
                const Ints nearer = inside & (at >= 0.0f) & (at < distance[lane]) & (towards != 0.0f);
                if (!__builtin_reduce_or(nearer)) continue;
                const Floats where = nearer ? at : distant;
                const float nearest = __builtin_reduce_min(where);
                int k = 0;
                while (where[k] != nearest) ++k;
                distance[lane] = nearest;
                u_of[lane] = at_a[k];
                v_of[lane] = at_e[k];
                face_of[lane] = mesh.bvh.primitive_indices[begin + k];
                slot_of[lane] = slot;
            }
        }
        t = *(Floats*)distance;
        reach = __builtin_reduce_max(t);
    } else {
        float first[2];
        const int child[2] = {(int)lower.i, (int)upper.i};
        for (int k = 0; k < 2; ++k) {
            const wp::BVHPackedNodeHalf low = mesh.bvh.node_lowers[child[k]];
            const wp::BVHPackedNodeHalf high = mesh.bvh.node_uppers[child[k]];
            const Floats x0 = (low.x - origin[0]) * ix, x1 = (high.x - origin[0]) * ix;
            const Floats y0 = (low.y - origin[1]) * iy, y1 = (high.y - origin[1]) * iy;
            const Floats z0 = (low.z - origin[2]) * iz, z1 = (high.z - origin[2]) * iz;
            SPAN
            first[k] = __builtin_reduce_min(((in <= end) & (out >= 0.0f)) ? in : distant);
        }
        const int near_child = first[0] <= first[1] ? 0 : 1;
        if (first[1 - near_child] < far && depth < 64) {
            stack[depth] = child[1 - near_child];
            entry[depth++] = first[1 - near_child];
        }
        if (first[near_child] < far) {
            node = child[near_child];
            down = true;
        }
    }
    while (!down && depth > 0) {
        --depth;
        if (entry[depth] < reach) {
            node = stack[depth];
            down = true;
        }
    }
    if (!down) break;
}
return reach;
#endif
""".replace("SPAN", _SPAN)


@wp.func_native(_QUERY)
def intersect_mesh(  # type: ignore[empty-body]
    mesh_id: wp.uint64,
    triangles: wp.array2d[float],
    first_triangle: int,
    origin: wp.vec3,
    rotation: wp.mat33,
    rays: wp.array2d[float],
    world: int,
    packet: int,
    slot: int,
    distances: wp.array2d[float],
    slots: wp.array2d[int],
    faces: wp.array2d[int],
    us: wp.array2d[float],
    vs: wp.array2d[float],
) -> float:
    """A packet against a mesh; returns how far the farthest ray now reaches.

    A mesh's columns of ``triangles`` hold a corner, the two edges e and f from it, and f x e, of each
    face, in the order of the search tree.
    """


@wp.func_native("return wp::mesh_get(mesh_id).bvh.primitive_indices[place];")
def _face_at(mesh_id: wp.uint64, place: int) -> int:  # type: ignore[empty-body]
    """The face that stands at a place of a mesh's search tree."""


@wp.kernel
def tree_order(mesh_id: wp.uint64, order: wp.array[int]) -> None:
    """A mesh's faces in the order of its search tree."""
    place = wp.tid()
    order[place] = _face_at(mesh_id, place)
