# SPDX-License-Identifier: GPL-2.0-or-later
"""What a body gives to the nodes, by its weights, and what the nodes have got."""

import numpy as np


def giveAnything(body, dim):
    """Random velocities and stresses, in 2D without the shear that plane strain does not have."""
    rng = np.random.default_rng(5)
    body.velocity = rng.normal(size=(body.count, dim))
    stress = rng.normal(size=(body.count, 3, 3))
    body.stress = symmetric(stress, dim)
    return rng


def symmetric(stress, dim):
    """Symmetric, and in 2D without the shear out of the plane that plane strain does not have."""
    stress = stress + stress.swapaxes(1, 2)
    if dim == 2:
        stress[:, :2, 2] = stress[:, 2, :2] = 0
    return stress


def numbersOf(scene):
    """Dict position of a node -> its number."""
    return {tuple(x.round(6)): i for i, x in enumerate(scene.nodePositions())}


def givenTo(scene, body):
    """m_i, p_i and f_i = - sum V sigma grad phi + sum phi m b, a row for each node."""
    dim, number = scene.dim, numbersOf(scene)
    table = np.zeros((len(number), 1 + 2 * dim))
    for p in range(body.count):
        m, V, sigma = body.mass[p], body.volume[p], body.stress[p, :dim, :dim]
        for x, phi, gradient in body.weights(p):
            f = phi * m * body.bodyForce[p] - V * sigma @ gradient
            table[number[tuple(np.round(x, 6))]] += np.concatenate([[phi * m], phi * m * body.velocity[p], f])
    return table


def gotBy(scene):
    """The same after the ParticleToGrid of a step that goes no further."""
    for engine in scene.engines[1:]:
        engine.dead = True
    scene.run(steps=1, progress=False)
    table = np.zeros((len(scene.nodePositions()), 1 + 2 * scene.dim))
    values = scene._core.nodalValues()
    table[values["node"]] = np.column_stack([values["mass"], values["momentum"], values["force"]])
    return table
