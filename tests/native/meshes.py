"""Plain triangle meshes for the geometry tests, and Embree called directly as their yardstick."""

import ctypes

import numpy as np

INVALID = 0xFFFFFFFF


def sphere(radius=1.0, center=(0.0, 0.0, 0.0), segments=32, rings=16):
    """Closed latitude-longitude sphere: vertices float32 and triangles uint32, outward normals."""
    theta = np.linspace(0, np.pi, rings + 1)[1:-1]
    phi = np.arange(segments) * 2 * np.pi / segments
    ring = np.stack(
        [
            np.outer(np.sin(theta), np.cos(phi)),
            np.outer(np.sin(theta), np.sin(phi)),
            np.outer(np.cos(theta), np.ones(segments)),
        ],
        -1,
    ).reshape(-1, 3)
    vertices = np.concatenate([[[0, 0, 1]], ring, [[0, 0, -1]]]) * radius + center
    i, j = np.meshgrid(np.arange(rings - 2), np.arange(segments), indexing="ij")
    a, b = 1 + i * segments + j, 1 + i * segments + (j + 1) % segments
    quads = np.concatenate(
        [
            np.stack([a, a + segments, b + segments], -1).reshape(-1, 3),
            np.stack([a, b + segments, b], -1).reshape(-1, 3),
        ]
    )
    k, n = np.arange(segments), len(vertices)
    top = np.stack([0 * k, 1 + k, 1 + (k + 1) % segments], -1)
    last = 1 + (rings - 2) * segments
    bottom = np.stack([0 * k + n - 1, last + (k + 1) % segments, last + k], -1)
    return vertices.astype(np.float32), np.concatenate([top, quads, bottom]).astype(np.uint32)


def torus(radius=1.0, tube=0.4, segments=48, sides=24):
    """Closed torus about the z axis, outward normals."""
    i, j = (a.ravel() for a in np.meshgrid(np.arange(segments), np.arange(sides), indexing="ij"))
    u, w = 2 * np.pi * i / segments, 2 * np.pi * j / sides
    from_axis = radius + tube * np.cos(w)
    vertices = np.stack([from_axis * np.cos(u), from_axis * np.sin(u), tube * np.sin(w)], -1)
    a, b = i * sides + j, (i + 1) % segments * sides + j
    c, d = (i + 1) % segments * sides + (j + 1) % sides, i * sides + (j + 1) % sides
    triangles = np.concatenate([np.stack([a, b, c], -1), np.stack([a, c, d], -1)])
    return vertices.astype(np.float32), triangles.astype(np.uint32)


def box(lower, upper):
    """Closed box with outward normals."""
    lower, upper = np.asarray(lower, float), np.asarray(upper, float)
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = [t for a, b, c, d in faces for t in ((a, b, c), (a, c, d))]
    return (lower + corners * (upper - lower)).astype(np.float32), np.array(triangles, np.uint32)


def soup(rng, count, size, spread=1.0):
    """Random triangles of about `size` in a cube of half width `spread`."""
    centers = rng.uniform(-spread, spread, (count, 1, 3))
    vertices = (centers + rng.normal(0, size, (count, 3, 3))).reshape(-1, 3)
    return vertices.astype(np.float32), np.arange(3 * count, dtype=np.uint32).reshape(-1, 3)


def annulus(inner, outer, rings, segments):
    """A flat ring in the plane z = 0 around the origin, its triangles the larger the farther out."""
    radius, angle = np.geomspace(inner, outer, rings + 1), np.arange(segments) * 2 * np.pi / segments
    circle = np.stack([np.cos(angle), np.sin(angle), 0 * angle], -1)
    a = np.arange(rings * segments).reshape(rings, segments)
    b = np.roll(a, -1, axis=1)
    quads = np.stack([a, a + segments, b + segments, b], -1).reshape(-1, 4)
    triangles = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    vertices = (radius[:, None, None] * circle).reshape(-1, 3)
    return vertices.astype(np.float32), np.ascontiguousarray(triangles, np.uint32)


def joined(*parts):
    """Several meshes as one."""
    offset, vertices, triangles = 0, [], []
    for v, t in parts:
        vertices.append(v)
        triangles.append(t + np.uint32(offset))
        offset += len(v)
    return np.concatenate(vertices), np.concatenate(triangles)


def directions(rng, count):
    """Unit vectors, uniform on the sphere."""
    d = rng.normal(size=(count, 3))
    return d / np.linalg.norm(d, axis=1, keepdims=True)


def departures(rng, matrix, vertices, triangles, count, slope_min):
    """Starts on a transformed mesh, many near edges and corners, and unit directions out of it, half of them grazing.

    Returns (sources, origins, outward, inward): `inward` is `outward` mirrored in the surface. The sines of the grazing
    angles spread evenly on a logarithmic scale from slope_min to 1.
    """
    triangle = rng.integers(0, len(triangles), count)
    corners = transform(matrix, vertices)[triangles[triangle]]
    origins = np.einsum("ij,ijk->ik", rng.dirichlet((0.5, 0.5, 0.5), count), corners)
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal *= np.sign(np.linalg.det(matrix[:3, :3])) / np.linalg.norm(normal, axis=1, keepdims=True)
    outward = directions(rng, count)
    sine = np.abs(np.sum(outward * normal, 1, keepdims=True))
    sine[::2] = slope_min ** rng.uniform(0, 1, (len(sine[::2]), 1))
    along = outward - np.sum(outward * normal, 1, keepdims=True) * normal
    along *= np.sqrt(1 - sine**2) / np.linalg.norm(along, axis=1, keepdims=True)
    sources = np.stack([0 * triangle, triangle], 1).astype(np.int32)
    return sources, origins, along + sine * normal, along - sine * normal


def transform(matrix, points):
    return np.asarray(points, float) @ matrix[:3, :3].T + matrix[:3, 3]


class RayHit(ctypes.Structure):
    """RTCRayHit of Embree 4."""

    _fields_ = [
        ("org", ctypes.c_float * 3),
        ("tnear", ctypes.c_float),
        ("dir", ctypes.c_float * 3),
        ("time", ctypes.c_float),
        ("tfar", ctypes.c_float),
        ("mask", ctypes.c_uint),
        ("id", ctypes.c_uint),
        ("flags", ctypes.c_uint),
        ("ng", ctypes.c_float * 3),
        ("u", ctypes.c_float),
        ("v", ctypes.c_float),
        ("prim", ctypes.c_uint),
        ("geom", ctypes.c_uint),
        ("inst", ctypes.c_uint),
        ("pad", ctypes.c_uint * 4),
    ]


class DirectEmbree:
    """Embree's own C interface by ctypes: one robust scene of one mesh, no instances, no code of ours."""

    def __init__(self, library_path, vertices, triangles):
        self.lib = lib = ctypes.CDLL(library_path)
        pointer, number = ctypes.c_void_p, ctypes.c_uint
        for name, result, arguments in [
            ("rtcNewDevice", pointer, [ctypes.c_char_p]),
            ("rtcNewScene", pointer, [pointer]),
            ("rtcSetSceneFlags", None, [pointer, ctypes.c_int]),
            ("rtcNewGeometry", pointer, [pointer, ctypes.c_int]),
            (
                "rtcSetNewGeometryBuffer",
                pointer,
                [pointer, ctypes.c_int, number, ctypes.c_int, ctypes.c_size_t, ctypes.c_size_t],
            ),
            ("rtcCommitGeometry", None, [pointer]),
            ("rtcAttachGeometry", number, [pointer, pointer]),
            ("rtcCommitScene", None, [pointer]),
            ("rtcIntersect1", None, [pointer, pointer, pointer]),
            ("rtcReleaseScene", None, [pointer]),
            ("rtcReleaseDevice", None, [pointer]),
            ("rtcReleaseGeometry", None, [pointer]),
        ]:
            function = getattr(lib, name)
            function.restype, function.argtypes = result, arguments
        self.device = lib.rtcNewDevice(None)
        self.scene = lib.rtcNewScene(self.device)
        lib.rtcSetSceneFlags(self.scene, 4)  # robust
        geometry = lib.rtcNewGeometry(self.device, 0)
        for kind, form, array in ((1, 0x9003, vertices), (0, 0x5003, triangles)):
            data = lib.rtcSetNewGeometryBuffer(geometry, kind, 0, form, 12, len(array))
            ctypes.memmove(data, np.ascontiguousarray(array).ctypes.data, array.nbytes)
        lib.rtcCommitGeometry(geometry)
        lib.rtcAttachGeometry(self.scene, geometry)
        lib.rtcReleaseGeometry(geometry)
        lib.rtcCommitScene(self.scene)

    def intersect(self, origins, directions):
        """Triangle (-1: none), distance and barycentrics of the first hits."""
        n = len(origins)
        storage = np.zeros(96 * n + 16, np.uint8)
        storage = storage[-storage.ctypes.data % 16 :][: 96 * n]
        rays = (RayHit * n).from_buffer(storage)
        fields = np.frombuffer(storage, np.float32).reshape(n, 24)
        integers = np.frombuffer(storage, np.uint32).reshape(n, 24)
        fields[:, 0:3], fields[:, 4:7], fields[:, 8] = origins, directions, np.inf
        integers[:, 9], integers[:, 18], integers[:, 19] = INVALID, INVALID, INVALID
        address = ctypes.addressof(rays)
        for i in range(n):
            self.lib.rtcIntersect1(self.scene, address + 96 * i, None)
        hit = integers[:, 18] != INVALID
        triangle = np.where(hit, integers[:, 17].astype(np.int64), -1)
        return triangle, fields[:, 8].copy(), fields[:, 15:17].copy()

    def close(self):
        self.lib.rtcReleaseScene(self.scene)
        self.lib.rtcReleaseDevice(self.device)
