# SPDX-License-Identifier: GPL-2.0-or-later
"""Ground and pictures of scripts/yade_boulders.py."""

import numpy as np
from landscape import SAND, landscape
from matplotlib.collections import PolyCollection
from scipy.ndimage import median_filter
from yade_mpm import plot


def groundOf(scene, a):
    """Height of the ground, m, and plastic shear strain at it, in squares of the width of a cell; single
    particles in the air do not count."""
    soil = scene["soil"]
    n, x, order = int(round(a.width / a.cell)), soil.position, np.argsort(soil.position[:, 2])
    column = np.ravel_multi_index(np.clip((x[:, :2] / a.cell).astype(int), 0, n - 1).T, (n, n))
    top = np.full(n * n, -1)
    top[column[order]] = order  # the highest comes last
    height = np.where(top < 0, 0.0, x[top, 2] + a.cell / 4).reshape(n, n)
    strain = np.where(top < 0, 0.0, soil.plasticShearStrain[top]).reshape(n, n)
    around = median_filter(height, 3, mode="nearest")
    isLoose = np.abs(height - around) > a.cell
    smooth = median_filter(strain, 3, mode="nearest")
    return np.where(isLoose, around, height), np.where(isLoose, smooth, strain)


def draw(a, scene, centres, radii, file, pixels=1500):
    """The bed with its boulders from above, and a section through its middle."""
    height, strain = groundOf(scene, a)
    limit = max(0.05, float(np.quantile(strain, 0.98)))
    image = landscape(a.width, a.depth, height, strain, limit, centres, radii, pixels)
    plt = plot.plt
    figure, (ax, cut) = plt.subplots(2, 1, figsize=(8, 8), height_ratios=(3, 1), layout="constrained")
    ax.imshow(image, interpolation="antialiased")
    ax.set_axis_off()
    section(cut, a, scene, centres, radii, limit)
    scale = plt.cm.ScalarMappable(plt.Normalize(0, limit), SAND)
    figure.colorbar(scale, ax=[ax, cut], label="plastic shear strain (-)", extend="max", shrink=0.5)
    plot.save(figure, file)


def section(ax, a, scene, centres, radii, limit):
    """Particles within half a cell of the middle plane, and the boulders cut by it."""
    soil, plane = scene["soil"], a.width / 2
    mine = np.abs(soil.position[:, 1] - plane) < 0.5 * a.cell
    centre = soil.position[mine][:, None, [0, 2]]
    corners = (
        0.28 * a.cell * np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
    )  # a little larger than a particle was
    colours = SAND(np.clip(soil.plasticShearStrain[mine] / limit, 0, 1))
    ax.add_collection(PolyCollection(centre + corners, lw=0, facecolors=colours))
    for (x, y, z), radius in zip(centres, radii):
        if abs(y - plane) < radius:
            cut = np.sqrt(radius**2 - (y - plane) ** 2)
            ax.add_patch(plot.plt.Circle((x, z), cut, fc="0.62", ec="0.25", lw=0.7))
    ax.axhline(a.depth, color="k", lw=0.6, ls="--")
    ax.set(
        aspect="equal", xlim=(0, a.width), ylim=(0, a.depth + 3 * a.radius), xlabel="x (m)", ylabel="z (m)"
    )
    ax.set_title("section through the middle; dashed: the bed before")
