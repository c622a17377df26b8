# SPDX-License-Identifier: GPL-2.0-or-later
"""Pictures of a bed of ground in 3D with spheres on it, lit by a sun, without a window or a graphics card."""

from math import radians

import numpy as np
from matplotlib.colors import LinearSegmentedColormap
from scipy.ndimage import gaussian_filter, zoom

SAND = LinearSegmentedColormap.from_list("sand", ["#e3d3ae", "#dfa55c", "#c4512d", "#5e1224"])


def landscape(width, depth, height, strain, limit, centres, radii, pixels=1500):
    """Image (rows, pixels, 3) of a square bed and spheres, seen from above its front right.

    width, depth : of the bed, m. height, strain : of its surface in squares, (n, n) m and -; strain colours
    it, from zero to the limit. centres, radii : of the spheres, (m, 3) and (m,) m.
    """
    points, normals, colours = _groundPoints(width, depth, height, strain, limit, pixels)
    middle = np.array([width / 2, width / 2, depth * 0.6])
    eye = Canvas(radians(-58), radians(38), middle, 1.1 * width + 2 * depth, (int(0.7 * pixels), pixels))
    sun = Canvas(radians(-150), radians(48), middle, 1.9 * width, (pixels, pixels))
    tints = np.random.default_rng(0).uniform(0.42, 0.62, (len(radii), 1)) * np.array((1.0, 0.98, 0.95))
    for canvas in (eye, sun):
        canvas.add(points, normals, colours)
        for centre, radius, tint in zip(centres, radii, tints):
            canvas.addSphere(centre, radius, tint)
    i, j, far = sun.pixelsOf(eye.position.reshape(-1, 3))
    i, j = (np.clip(v, 0, pixels - 1) for v in (i, j))
    isLit = (far > sun.depth[i, j] - 0.02 * width / 6 - 2 / sun.scale).reshape(eye.shape)
    light = np.clip(eye.normal @ sun.axes[2], 0, None) * np.where(isLit, 1, 0.0)
    image = np.clip(
        eye.colour * (0.42 + 0.24 * np.clip(eye.normal[..., 2:], 0, None) + 0.62 * light[..., None]), 0, 1
    )
    image[np.isinf(eye.depth)] = 1
    return image


def _groundPoints(width, depth, height, strain, limit, pixels):
    """Points on the top and the two visible sides of the bed, with normals and colours."""
    fine = int(np.ceil(pixels / len(height)))
    z, s = (
        gaussian_filter(zoom(v, fine, order=1, mode="nearest", grid_mode=True), 0.35 * fine, mode="nearest")
        for v in (height, strain)
    )
    n, size = len(z), width / len(z)
    at = (np.arange(n) + 0.5) * size
    x, y = np.meshgrid(at, at, indexing="ij")
    slope = np.gradient(z, size)
    normals = np.stack([-slope[0], -slope[1], np.ones_like(z)], axis=-1)
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    colours = SAND(np.clip(s / limit, 0, 1))[..., :3]
    parts = [(np.stack([x, y, z], axis=-1), normals, colours)]
    up = np.linspace(0, 1, int(1.5 * depth / size))[:, None]
    for axis in (1, 0):  # front, right
        top = z[:, 0] if axis else z[n - 1]
        level = up * top
        side = np.broadcast_to(at, level.shape)
        points = np.stack([side, 0 * level, level] if axis else [0 * level + width, side, level], axis=-1)
        normal = (0, -1, 0) if axis else (1, 0, 0)
        shade = 0.80 + 0.06 * np.sin(40 * level / depth)[..., None]
        parts.append((points, np.broadcast_to(normal, points.shape), shade * np.array((0.80, 0.70, 0.52))))
    return [np.concatenate([p[k].reshape(-1, 3) for p in parts]) for k in range(3)]


class Canvas:
    """Parallel projection with a depth for every pixel."""

    def __init__(self, azimuth, elevation, centre, width, pixels):
        ca, sa, ce, se = np.cos(azimuth), np.sin(azimuth), np.cos(elevation), np.sin(elevation)
        self.axes = np.array(
            [(-sa, ca, 0), (-ca * se, -sa * se, ce), (ca * ce, sa * ce, se)]
        )  # right, up, to the eye
        self.shape, self.scale = pixels, pixels[1] / width
        self.centre = self.axes @ centre
        self.depth = np.full(pixels, -np.inf)
        self.position, self.normal, self.colour = (np.zeros((*pixels, 3)) for _ in range(3))

    def pixelsOf(self, points):
        """Row and column (int) and depth of points."""
        right, up, depth = (points @ self.axes.T - self.centre).T
        return (
            np.rint(self.shape[0] / 2 - up * self.scale).astype(int),
            np.rint(self.shape[1] / 2 + right * self.scale).astype(int),
            depth,
        )

    def add(self, points, normals, colours):
        """Points so close that they leave no gap."""
        i, j, depth = self.pixelsOf(points)
        order = np.argsort(depth)
        order = order[
            (i[order] >= 0) & (i[order] < self.shape[0]) & (j[order] >= 0) & (j[order] < self.shape[1])
        ]
        first = np.full(self.shape, -1)
        first[i[order], j[order]] = order  # the nearest comes last
        mine = first >= 0
        mine[mine] = depth[first[mine]] > self.depth[mine]
        for field, values in (
            (self.depth, depth),
            (self.position, points),
            (self.normal, normals),
            (self.colour, colours),
        ):
            field[mine] = values[first[mine]]

    def addSphere(self, centre, radius, colour):
        i, j, depth = (v[0] for v in self.pixelsOf(centre[None]))
        k = int(radius * self.scale) + 2
        rows, columns = np.mgrid[
            max(0, i - k) : min(self.shape[0], i + k), max(0, j - k) : min(self.shape[1], j + k)
        ]
        local = np.stack([(columns - j) / self.scale, (i - rows) / self.scale], axis=-1) / radius
        left = 1 - (local**2).sum(axis=-1)
        out = np.sqrt(np.maximum(left, 0))
        mine = (left > 0) & (depth + radius * out > self.depth[rows, columns])
        normal = np.concatenate([local, out[..., None]], axis=-1)[mine] @ self.axes
        at = rows[mine], columns[mine]
        self.depth[at], self.normal[at], self.colour[at] = (depth + radius * out)[mine], normal, colour
        self.position[at] = centre + radius * normal
