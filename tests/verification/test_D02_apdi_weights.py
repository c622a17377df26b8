# SPDX-License-Identifier: GPL-2.0-or-later
"""D2: weights of APDI domains.

Set-up: random convex quadrilaterals and random hexahedra as user meshes; weights by `body.weights`.
Reference: 2 x 2 (x 2) Gauss quadrature of N_a and grad N_a, written here in NumPy, times the hat function
at the corners;
the identities sum phi = 1, sum grad phi = 0, sum x_i phi = centroid, sum x_i (x) grad phi = I.
Source: Kiriyama & Higo 2016; Takegawa, Higo, Uchiyama, Kiriyama, Michino, Eq. (1).
Tolerance: 1e-13, gradients relative to 1/edge. Triangles are not offered: a mesh of them is refused.

The program has the shapes in closed form. For hexahedra they are also compared with the quadrature corner
by corner
(1e-14), and through a step, which makes them for many domains at a time: velocity gradient sum v_a (x) g_a,
volume
after the step, the smallest corner (2^Dim det J there), below 5 % of the volume of which a domain is given
up, and the
hourglass forces, which are made of the patterns of the corners (Flanagan & Belytschko 1981).
Controls: a quadrature with one point, which the hexahedra are distorted enough to tell apart; corners in
another order.
"""

from itertools import product

import numpy as np
import pytest
import yade_mpm as mpm
from yade_mpm.geometry import meshChecks

SIGNS = {2: np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])}
SIGNS[3] = np.array([(*s, z) for z in (-1, 1) for s in SIGNS[2]])
ELASTIC = dict(density=1, young=1, poisson=0)


@pytest.fixture(autouse=True)
def domainsMayLieOnEachOther(monkeypatch):
    """Each of them is looked at by itself here."""
    monkeypatch.setattr(meshChecks, "_refuseOverlap", lambda name, points, cells: None)


def jacobian(X, xi):
    """N_a and dN_a/dxi at xi, and J_ij = dx_i/dxi_j, of a domain with corners X (corners, dim)."""
    dim = X.shape[1]
    factors = (1 + SIGNS[dim] * xi) / 2
    dN = np.stack(
        [SIGNS[dim][:, k] / 2 * np.delete(factors, k, axis=1).prod(axis=1) for k in range(dim)], axis=1
    )
    return factors.prod(axis=1), dN, X.T @ dN


def quadrature(X, points=(-1 / np.sqrt(3), 1 / np.sqrt(3))):
    """w (corners), g (corners, dim), V of a domain; Gauss points per direction, of equal weight."""
    dim = X.shape[1]
    w, g, V = np.zeros(len(X)), np.zeros(X.shape), 0.0
    for point in product(points, repeat=dim):
        N, dN, J = jacobian(X, np.array(point))
        detJ = np.linalg.det(J) * (2 / len(points)) ** dim
        w += N * detJ
        g += dN @ np.linalg.inv(J) * detJ
        V += detJ
    return w / V, g / V, V


def smallestCorner(X):
    return len(X) * min(np.linalg.det(jacobian(X, corner)[2]) for corner in SIGNS[X.shape[1]])


def hats(X, nodes, h):
    """S_i(X_a), (nodes, corners)."""
    return np.maximum(0, 1 - np.abs(nodes[:, None] - X[None]) / h).prod(axis=2)


def summed(body, particle):
    """Weights of a particle with the pairs of corner and node summed up: nodes, phi, gradient."""
    nodes, phi, gradient = (np.array(a) for a in zip(*body.weights(particle)))
    unique, index = np.unique(nodes.round(9), axis=0, return_inverse=True)
    index = index.ravel()
    total, slope = np.zeros(len(unique)), np.zeros(unique.shape)
    np.add.at(total, index, phi)
    np.add.at(slope, index, gradient)
    return unique, total, slope


def randomQuads(count):
    """Corners (count, 4, 2) of convex quadrilaterals, counter-clockwise, edges about 0.4."""
    rng = np.random.default_rng(7)
    found = []
    while len(found) < count:
        angle = np.sort(rng.uniform(0, 2 * np.pi, 4))
        X = rng.uniform(1, 3, 2) + rng.uniform(0.2, 0.5) * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        X += rng.uniform(-0.1, 0.1, X.shape)
        edges = np.roll(X, -1, axis=0) - X
        corner = np.cross(np.roll(edges, 1, axis=0), edges)
        if corner.min() > 0.15 * np.abs(corner).max():
            found.append(X)
    return np.array(found)


def randomHexahedra(count):
    rng = np.random.default_rng(8)
    X = rng.uniform(1, 3, (count, 1, 3)) + 0.25 * SIGNS[3] + rng.uniform(-0.07, 0.07, (count, 8, 3))
    return X  # faces are not plane


def bodyOf(X, cell, lower=0, upper=4):
    """Body whose domain p has the corners X[p]."""
    dim = X.shape[2]
    scene = mpm.Scene(lower=[lower] * dim, upper=[upper] * dim, cell=cell)
    cells = np.arange(X.shape[0] * X.shape[1]).reshape(X.shape[:2])
    return scene.add("domains", (X.reshape(-1, dim), cells), mpm.LinearElastic(**ELASTIC), mpm.APDI())


def check(body, X, h, verified):
    dim = X.shape[2]
    for p in range(len(X)):
        nodes, phi, gradient = summed(body, p)
        w, g, V = quadrature(X[p])
        S = hats(X[p], nodes, h)
        scale = np.abs(g).max()
        verified(phi, S @ w, scale=1)
        verified(gradient, S @ g, scale=scale)
        assert abs(phi.sum() - 1) <= 1e-13
        assert np.abs(gradient.sum(axis=0)).max() <= 1e-13 * scale
        assert np.abs(nodes.T @ gradient - np.eye(dim)).max() <= 1e-12 * scale
        assert np.abs(phi @ nodes - w @ X[p]).max() <= 1e-12
        assert abs(body.volume[p] / V - 1) <= 1e-13
        assert np.abs(body.position[p] - w @ X[p]).max() <= 1e-13  # the exact centroid


@pytest.mark.parametrize("h", [1.0, 0.25])
@pytest.mark.verifies(
    "APDI weights and gradients of 1000 quadrilaterals",
    reference="Gauss quadrature of the domain",
    tolerance=1e-13,
)
def test_weights_of_quadrilaterals_are_those_of_the_quadrature(h, verified):
    X = randomQuads(1000)
    check(bodyOf(X, h), X, h, verified)


@pytest.mark.parametrize("h", [1.0, 0.25])
@pytest.mark.verifies(
    "APDI weights and gradients of 100 hexahedra", reference="Gauss quadrature of the domain", tolerance=1e-13
)
def test_weights_of_hexahedra_are_those_of_the_quadrature(h, verified):
    X = randomHexahedra(100)
    check(bodyOf(X, h), X, h, verified)


def checkCorners(body, X, **quadratureArguments):
    """The weights of one corner in the nodes of its cell add up to w_a and g_a."""
    corners, dim = X.shape[1:]
    for p in range(len(X)):
        _, phi, gradient = (np.array(a) for a in zip(*body.weights(p)))
        w, g, V = quadrature(X[p], **quadratureArguments)
        assert np.abs(phi.reshape(corners, -1).sum(axis=1) - w).max() <= 1e-14
        assert np.abs(gradient.reshape(corners, -1, dim).sum(axis=1) - g).max() <= 1e-14 * np.abs(g).max()
        assert abs(body.volume[p] / V - 1) <= 1e-14


def test_corner_weights_and_gradients_of_hexahedra_are_those_of_the_quadrature():
    X = randomHexahedra(100)
    checkCorners(bodyOf(X, 1.0), X)


def test_control_one_point_is_not_enough_for_hexahedra():
    X = randomHexahedra(1)
    with pytest.raises(AssertionError):
        checkCorners(bodyOf(X, 1.0), X, points=(0.0,))


ODD = 103  # hexahedra: some whole batches, and a rest that no vector register divides


def oneStep(X, scheme="MUSL", **type_):
    """Hexahedra that share no vertex after a step with random velocities."""
    scene = mpm.Scene(lower=[0] * 3, upper=[4] * 3, cell=0.25, scheme=scheme)
    cells = np.arange(X.shape[0] * X.shape[1]).reshape(X.shape[:2])
    body = scene.add("domains", (X.reshape(-1, 3), cells), mpm.LinearElastic(**ELASTIC), mpm.APDI(**type_))
    body.velocity = np.random.default_rng(9).normal(size=body.velocity.shape)
    scene.dt, scene.allowUnstable = 1e-2, True
    scene.run(steps=1, progress=False)
    return body


@pytest.mark.parametrize("scheme", ["MUSL", "USL"])
def test_a_step_takes_gradient_and_volume_of_hexahedra_from_the_quadrature(scheme):
    before = randomHexahedra(ODD)
    body = oneStep(before, scheme)
    V = np.asarray(body._core.view("vertexVelocity", True)).reshape(before.shape)
    after = body.vertices.reshape(before.shape)
    onePoint = 0.0
    for p in range(ODD):
        g = quadrature(before[p])[1]
        assert (
            np.abs(body.velocityGradient[p] - V[p].T @ g).max() <= 1e-13 * np.abs(V).max() * np.abs(g).max()
        )
        assert abs(body.volume[p] / quadrature(after[p])[2] - 1) <= 1e-13
        g = quadrature(before[p], points=(0.0,))[1]
        onePoint = max(onePoint, np.abs(body.velocityGradient[p] - V[p].T @ g).max())
    assert onePoint > 1e-3 * np.abs(body.velocityGradient).max()  # control
    assert np.abs(after - before).max() > 1e-2  # control


def distortedTo(quality, regular, direction):
    """regular + t direction, with the t that leaves the smallest corner this part of the volume."""
    lower, upper = 0.0, 1.0
    for _ in range(40):
        t = (lower + upper) / 2
        X = regular + t * direction
        lower, upper = (t, upper) if smallestCorner(X) > quality * quadrature(X)[2] else (lower, t)
    return regular + lower * direction


def test_hexahedra_are_given_up_by_their_smallest_corner():
    """Some are distorted to 0.01 % above the limit and stay, some to 0.01 % below; ids tell which.

    They are six times as large at the start, so that no edge grows: that would be another reason to go.
    """
    rng = np.random.default_rng(10)
    stays = rng.random(ODD) < 0.5
    X = np.tile(2 + 0.25 * SIGNS[3], (ODD, 1, 1))
    scene = mpm.Scene(lower=[0] * 3, upper=[4] * 3, cell=0.25)
    cells = np.arange(8 * ODD).reshape(ODD, 8)
    body = scene.add(
        "domains",
        ((2 + 6 * (X - 2)).reshape(-1, 3), cells),
        mpm.LinearElastic(**ELASTIC),
        mpm.APDI(hourglass=0, onDistortion="convert"),
    )
    for p in range(ODD):
        X[p] = distortedTo(0.050005 if stays[p] else 0.049995, X[p], rng.uniform(-1, 1, (8, 3)))
    body.vertices[...] = X.reshape(-1, 3)
    assert body.minJacobian == pytest.approx(min(smallestCorner(x) for x in X) / (216 * 0.125), rel=1e-12)
    scene.dt, scene.allowUnstable = 1e-6, True
    scene.run(steps=1, progress=False)
    assert sorted(body.id) == list(np.flatnonzero(stays))


def hourglassForces(X, X0, coefficient):
    """f_a = -sum_m k_m (h_m - h0_m) gamma_ma for E = 1, nu = 0, of cubes X0 whose vertices alone moved."""
    corners, dim = X.shape
    axes = [(0, 1)] if dim == 2 else [(0, 1), (1, 2), (2, 0), (0, 1, 2)]
    pattern = np.array([SIGNS[dim][:, list(a)].prod(axis=1) for a in axes]) / corners
    edge = np.ptp(X0[:, 0])
    steepness = (2 / edge) ** 2 / 4 * np.array([len(a) / (1 if len(a) == 2 else 3) for a in axes])
    k = coefficient * edge**dim * steepness  # (2/3) (E / (1 - nu^2) + mu) = 1
    return -(k[:, None] * pattern).T @ (pattern @ (X - X0))


@pytest.mark.parametrize("dim", [2, 3])
def test_hourglass_forces_are_those_of_the_corner_patterns(dim):
    X0 = np.tile(2 + 0.25 * SIGNS[dim], (ODD, 1, 1))
    X = X0 + np.random.default_rng(11).uniform(-0.1, 0.1, X0.shape)
    scene = mpm.Scene(lower=[0] * dim, upper=[4] * dim, cell=0.25)
    cells = np.arange(X0.shape[0] * X0.shape[1]).reshape(X0.shape[:2])
    body = scene.add(
        "domains", (X0.reshape(-1, dim), cells), mpm.LinearElastic(**ELASTIC), mpm.APDI(hourglass=0.3)
    )
    body.vertices[...] = X.reshape(-1, dim)
    for engine in scene.engines[1:]:
        engine.dead = True
    scene.dt, scene.allowUnstable = 1e-9, True
    scene.run(steps=1, progress=False)
    nodes = scene.nodePositions()
    found = np.zeros((len(nodes), dim))
    values = scene._core.nodalValues()
    found[values["node"]] = values["force"]
    expected = sum(hats(x, nodes, 0.25) @ hourglassForces(x, x0, 0.3) for x, x0 in zip(X, X0))
    assert np.abs(expected).max() > 1e-3  # control
    assert np.abs(found - expected).max() <= 1e-13 * np.abs(expected).max()
    turned = sum(hats(x, nodes, 0.25) @ hourglassForces(x, x0, 0.3)[::-1] for x, x0 in zip(X, X0))
    assert np.abs(found - turned).max() > 0.1 * np.abs(expected).max()  # control


def test_corner_weights_of_a_quadrilateral_are_exact():
    """All moments of the polygon, by Green's theorem: area, centroid, and g_a = (1/V) dV/dX_a."""
    for X in randomQuads(50):
        w, g, V = quadrature(X)
        Y = np.roll(X, -1, axis=0)
        cross = X[:, 0] * Y[:, 1] - Y[:, 0] * X[:, 1]
        assert pytest.approx(0.5 * cross.sum(), rel=1e-13) == V
        assert w @ X == pytest.approx(((X + Y) * cross[:, None]).sum(axis=0) / (6 * V), rel=1e-13)
        before, after = np.roll(X, 1, axis=0), np.roll(X, -1, axis=0)
        dV = 0.5 * np.stack([after[:, 1] - before[:, 1], before[:, 0] - after[:, 0]], axis=1)
        assert g == pytest.approx(dV / V, rel=1e-12, abs=1e-12)


def test_a_concave_corner_gets_no_weight():
    """(0,0), (1,0), (0.25,0.25), (0,1): V = 0.25 and w_3 = 0 exactly; the program refuses the domain."""
    X = np.array([(0, 0), (1, 0), (0.25, 0.25), (0, 1)])
    w, _, V = quadrature(X)
    assert pytest.approx(0.25, abs=1e-15) == V
    assert w[2] == pytest.approx(0, abs=1e-15)
    with pytest.raises(ValueError, match="concave"):
        bodyOf(X[None] + 1.0, 1.0)


def test_weights_of_a_box_are_a_quarter_per_corner():
    X = np.array([[(1.1, 1.2), (1.6, 1.2), (1.6, 1.9), (1.1, 1.9)]])
    nodes, phi, gradient = summed(bodyOf(X, 1.0), 0)
    one = tuple(np.flatnonzero((nodes == (1, 1)).all(axis=1)))[0]
    assert phi[one] == pytest.approx(0.25 * (0.9 + 0.4) * (0.8 + 0.1), abs=1e-15)
    assert gradient[one, 0] == pytest.approx((0.4 - 0.9) / 0.5 * 0.5 * (0.8 + 0.1), abs=1e-15)


def test_apdi_and_ugimp_differ_in_weight_and_agree_in_gradient():
    """x = 0, l = 0.25 h: 0.875 for uGIMP, 0.75 for APDI along each axis; so 0.765625 and 0.5625 in 2D."""
    square = np.array([[(1.75, 1.75), (2.25, 1.75), (2.25, 2.25), (1.75, 2.25)]])
    nodes, phi, _ = summed(bodyOf(square, 1.0), 0)
    assert phi[(nodes == (2, 2)).all(axis=1)] == pytest.approx([0.75**2], abs=1e-15)
    aside = square + (0.1, 0)  # straddling: S(0.1) = 0.855 for uGIMP
    nodes, _, gradient = summed(bodyOf(aside, 1.0), 0)
    assert gradient[nodes[:, 0] == 2, 0].sum() == pytest.approx(-0.4, abs=1e-15)  # as in the table of D1


@pytest.mark.verifies(
    "APDI weights and gradients of a domain over several cells",
    reference="Gauss quadrature of the domain",
    tolerance=1e-13,
)
def test_domains_may_span_several_cells(verified):
    X = np.array([[(0.6, 0.55), (3.3, 0.8), (3.4, 3.2), (0.7, 2.9)]])
    check(bodyOf(X, 0.5), X, 0.5, verified)


def test_a_vertex_outside_the_grid_is_refused():
    X = np.array([[(3.2, 1.0), (4.2, 1.0), (4.2, 2.0), (3.2, 2.0)]])
    with pytest.raises(ValueError, match=r"'domains': vertex at \(4.2, 1\) is outside the grid"):
        bodyOf(X, 1.0)


def test_triangles_are_refused():
    scene = mpm.Scene(lower=(0, 0), upper=(4, 4), cell=1.0)
    points = np.array([(1, 1), (2, 1), (1, 2)], float)
    with pytest.raises(ValueError):
        scene.add("triangle", (points, np.array([(0, 1, 2)])), mpm.LinearElastic(**ELASTIC), mpm.APDI())


def test_control_corners_in_another_order_miss():
    def agree(computed, exact, scale):
        assert np.abs(computed - exact).max() <= 1e-13 * scale

    X = randomQuads(3)
    check(bodyOf(X, 1.0), X, 1.0, agree)
    with pytest.raises(AssertionError):
        check(bodyOf(X, 1.0), X[:, ::-1], 1.0, agree)
    X = randomHexahedra(3)
    with pytest.raises(AssertionError):
        checkCorners(bodyOf(X, 1.0), X[:, [1, 0, *range(2, 8)]])
