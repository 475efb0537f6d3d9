"""What the ray tracer draws: geoms, camera and light of a model as Warp arrays."""

from __future__ import annotations

import hashlib
import threading
from collections.abc import Sequence

import mujoco
import numpy as np
import warp as wp

from pipeline.contract.errors import BelvedereError
from pipeline.rendering import bvh, raytracer, shading
from pipeline.rendering.ray_packets import KINDS, LANES, SIDE

_UNSET_RGBA = (0.5, 0.5, 0.5, 1.0)  # MuJoCo's default; a material's colour takes its place
_LOCKED = 1e9  # N s/m; Fetch's base is held in place by 1e11, and moves by 2e-8 m in an episode
_SMOOTH = 0.8  # cosine between face and vertex normal, below which MuJoCo takes the face's

_meshes: dict[tuple[str, bytes], wp.Mesh] = {}  # shared by all pictures of the process, which only read them
_meshes_lock = threading.Lock()


def visible_geoms(model: mujoco.MjModel, groups: Sequence[int]) -> np.ndarray:
    """Numbers of the geoms that are drawn.

    Raises:
        BelvedereError: one is of a kind that the ray tracer does not know.
    """
    drawn = [g for g in range(model.ngeom) if model.geom_group[g] in groups and _rgba(model, g)[3] > 0]
    for geom in drawn:
        if model.geom_type[geom] not in KINDS:
            kind = mujoco.mjtGeom(int(model.geom_type[geom])).name
            raise BelvedereError(
                f"geom {model.geom(geom).name or geom} of the scene is a {kind}, which cannot be drawn; "
                "give it a geom group above 2 to hide it."
            )
    return np.array(drawn, dtype=np.int32)


def static_geoms(model: mujoco.MjModel, geoms: np.ndarray) -> np.ndarray:
    """Which geoms stand still: no mocap body or joint moves them, but for locked joints; shape (n,), bool."""
    moves = np.zeros(model.nbody, dtype=bool)
    for body in range(1, model.nbody):  # parents come first
        joints = slice(model.body_dofadr[body], model.body_dofadr[body] + model.body_dofnum[body])
        free = (model.dof_damping[joints] < _LOCKED).any()
        moves[body] = moves[model.body_parentid[body]] or free or model.body_mocapid[body] >= 0
    return ~moves[model.geom_bodyid[geoms]]


def geom_arrays(model: mujoco.MjModel, geoms: np.ndarray) -> tuple[wp.array, wp.array, wp.array]:
    """On Warp's current device: the chosen geoms (n,), their meshes' faces (12, f), corner normals (3 f, 3).

    A face is a corner, the two edges from it, and their cross product, which points inwards; each mesh's
    faces stand in the order of its search tree, their normals in the model's order.
    """
    listed, faces, normals = [], [np.zeros((0, 12))], [np.zeros((0, 3))]
    for number in geoms:
        geom = raytracer.Geom()
        geom.number, geom.kind = int(number), int(model.geom_type[number])
        geom.size, geom.rgb = wp.vec3(*model.geom_size[number]), wp.vec3(*_rgba(model, number)[:3])
        geom.middle, geom.half = wp.vec3(*model.geom_aabb[number, :3]), wp.vec3(*model.geom_aabb[number, 3:])
        if geom.kind == mujoco.mjtGeom.mjGEOM_MESH:
            mesh = int(model.geom_dataid[number])
            geom.mesh, geom.first_face = _mesh(model, mesh).id, sum(map(len, faces))
            faces.append(_triangles(model, mesh)[_order(_mesh(model, mesh))])
            normals.append(_corner_normals(model, mesh))
        listed.append(geom)
    return (
        wp.array(listed, dtype=raytracer.Geom, shape=len(listed)),
        wp.array(np.pad(np.concatenate(faces).T, ((0, 0), (0, LANES))), dtype=float),
        wp.array(np.concatenate(normals), dtype=wp.vec3),
    )


def view_of(
    model: mujoco.MjModel, data: mujoco.MjData, camera: int, samples: int
) -> tuple[raytracer.View, wp.array]:
    """The camera with what light reaches everything, and its rays (3, r), world frame, packet by packet."""
    rotation = data.cam_xmat[camera].reshape(3, 3)
    focal = samples / 2 / np.tan(np.radians(model.cam_fovy[camera]) / 2)
    padded = -(-samples // SIDE) * SIDE  # whole packets; what is too many is never shaded
    across = (np.arange(padded) + 0.5 - samples / 2) / focal
    rays = np.stack(np.broadcast_arrays(across, -across[:, None], -1.0), axis=-1) @ rotation.T
    rays /= np.linalg.norm(rays, axis=-1, keepdims=True)
    blocks = rays.reshape(padded // SIDE, SIDE, padded // SIDE, SIDE, 3)
    ambient = model.vis.headlight.ambient + model.light_ambient[_lights(model)].sum(axis=0)
    view = raytracer.View()
    view.origin, view.rotation = wp.vec3(*data.cam_xpos[camera]), wp.mat33(*rotation.reshape(-1))
    view.focal, view.samples = focal, samples
    view.ambient = wp.vec3(*ambient)
    return view, wp.array(blocks.transpose(4, 0, 2, 1, 3).reshape(3, -1), dtype=float)


def lights_of(model: mujoco.MjModel, data: mujoco.MjData, camera: int) -> wp.array:
    """The headlight, which shines as the camera looks, and the scene's lights.

    Raises:
        BelvedereError: a light is not directional.
    """
    headlight = shading.Light()
    headlight.towards = wp.vec3(*data.cam_xmat[camera].reshape(3, 3)[:, 2])
    headlight.diffuse = wp.vec3(*model.vis.headlight.diffuse)
    lights = [headlight]
    for number in _lights(model):
        if model.light_type[number] != mujoco.mjtLightType.mjLIGHT_DIRECTIONAL:
            raise BelvedereError(
                f"light {model.light(number).name or number} of the scene is not directional; make it so."
            )
        light = shading.Light()
        light.towards = wp.vec3(*-data.light_xdir[number])
        light.diffuse = wp.vec3(*model.light_diffuse[number])
        lights.append(light)
    return wp.array(lights, dtype=shading.Light)


def _lights(model: mujoco.MjModel) -> list[int]:
    return [number for number in range(model.nlight) if model.light_active[number]]


def _rgba(model: mujoco.MjModel, geom: int) -> np.ndarray:
    own, material = model.geom_rgba[geom], model.geom_matid[geom]
    return model.mat_rgba[material] if material >= 0 and np.array_equal(own, _UNSET_RGBA) else own


def _faces(model: mujoco.MjModel, mesh: int) -> tuple[np.ndarray, np.ndarray, slice]:
    """Vertices (v, 3), faces (f, 3), and where the faces stand in the model's arrays."""
    vertices = slice(model.mesh_vertadr[mesh], model.mesh_vertadr[mesh] + model.mesh_vertnum[mesh])
    faces = slice(model.mesh_faceadr[mesh], model.mesh_faceadr[mesh] + model.mesh_facenum[mesh])
    return model.mesh_vert[vertices], model.mesh_face[faces], faces


def _triangles(model: mujoco.MjModel, mesh: int) -> np.ndarray:
    """A mesh's rows (f, 12) of :func:`geom_arrays`."""
    points, corners, _ = _faces(model, mesh)
    a, b, c = (points[corners[:, k]] for k in range(3))
    return np.concatenate([a, b - a, c - a, np.cross(c - a, b - a)], axis=1)


def _order(mesh: wp.Mesh) -> np.ndarray:
    """The mesh's faces as its search tree has them, leaf by leaf."""
    order = wp.zeros(len(mesh.indices) // 3, dtype=int)
    wp.launch(bvh.tree_order, dim=len(order), inputs=[mesh.id], outputs=[order])
    return np.asarray(order.numpy())


def _corner_normals(model: mujoco.MjModel, mesh: int) -> np.ndarray:
    """The normals (3 f, 3) from which MuJoCo's renderer shades a mesh."""
    points, corners, where = _faces(model, mesh)
    a, b, c = (points[corners[:, k]] for k in range(3))
    face = np.cross(b - a, c - a)
    face /= np.maximum(np.linalg.norm(face, axis=1, keepdims=True), 1e-30)
    normal = model.mesh_normal[model.mesh_normaladr[mesh] + model.mesh_facenormal[where]]
    smooth = np.einsum("fkc,fc->fk", normal, face) >= _SMOOTH
    return np.where(smooth[..., None], normal, face[:, None]).reshape(-1, 3)


def _mesh(model: mujoco.MjModel, mesh: int) -> wp.Mesh:
    """A mesh with its search tree, made once a process and device."""
    points, corners, _ = _faces(model, mesh)
    digest = hashlib.sha256(points.tobytes() + corners.tobytes()).digest()
    key = (str(wp.get_device()), digest)
    with _meshes_lock:
        if key not in _meshes:
            _meshes[key] = wp.Mesh(
                points=wp.array(points, dtype=wp.vec3),
                indices=wp.array(corners.reshape(-1), dtype=wp.int32),
                bvh_constructor="sah",
                bvh_leaf_size=32
                if wp.get_device().is_cpu
                else None,  # rays alone want Warp's own, smaller ones
            )
        return _meshes[key]
