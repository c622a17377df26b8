# SPDX-License-Identifier: GPL-2.0-or-later
"""GridConnection and PFacet of YADE: elements between nodes that move, each on its own, and carry its forces.

The soil meets an element as a rigid body that moves as its nodes do on the whole. Its force and moment go to
the nodes as forces with the same resultants.
"""

import math

import numpy as np

from .. import rigid

NODES = {"GridConnection": 2, "PFacet": 3}  # by the shape of the element


def isElement(body):
    """Whether a body of YADE is an element between nodes."""
    return type(body.shape).__name__ in NODES


def nodesOf(body):
    """The bodies of YADE that an element lies between."""
    return [getattr(body.shape, f"node{k}") for k in range(1, NODES[type(body.shape).__name__] + 1)]


def shapeOf(body, plane):
    """Shape of an element in its own frame, in the axes of the scene: of the size that it has now."""
    element = Element(body, plane)
    turn = element.axes()
    corners = [tuple(plane.toScene(arm @ turn)) for arm in element.arms()]
    return rigid.Facet(tuple(corners), 2 * body.shape.radius)


def massOf(body):
    """Mass that yields to a force on an element: the least that a free node has for each of its elements;
    zero where no node yields."""
    free = [n for n in nodesOf(body) if n.state.blockedDOFs != "xyzXYZ"]
    return min((n.state.mass / _elementsAt(n) for n in free), default=0.0)


def _elementsAt(node):
    return max(1, len(node.shape.getConnections()) + len(node.shape.getPFacets()))


class Element:
    """State of an element as its nodes give it: position of their middle, velocity and spin of a rigid body
    whose corners have their momentum for equal masses.

    body : of YADE, with the shape GridConnection or PFacet. plane : `Plane` of the scene.
    """

    def __init__(self, body, plane):
        nodes = nodesOf(body)
        self.ids, self._states = [n.id for n in nodes], [n.state for n in nodes]
        self._start = plane.frame[0]  # direction of a connection that is not turned

    pos = property(lambda self: np.mean(self._of("pos"), axis=0), doc="Middle of the nodes, m.")
    vel = property(lambda self: np.mean(self._of("vel"), axis=0), doc="Mean velocity of the nodes, m/s.")

    @property
    def ori(self):
        """Orientation (x, y, z, w) of the axes of `axes`."""
        return _quaternion(self.axes())

    @property
    def angVel(self):
        """Spin, rad/s; of a connection about itself the mean of its nodes."""
        arms = self.arms()
        spin = _solve(arms, np.cross(arms, self._of("vel")).sum(axis=0))
        if len(arms) == 2:
            along = (arms[1] - arms[0]) / np.linalg.norm(arms[1] - arms[0])
            spin = spin + along * (along @ np.mean(self._of("angVel"), axis=0))
        return spin

    def arms(self):
        """Nodes from their middle, (n, 3), m."""
        places = self._of("pos")
        return places - places.mean(axis=0)

    def axes(self):
        """Matrix whose columns are the axes of the element: of a connection turned the shortest way from
        where it lies along the first axis of the scene, of a PFacet along its first edge, and its normal."""
        arms = self.arms()
        if len(arms) == 2:
            return _turnFrom(self._start, arms[1] - arms[0])
        first, normal = arms[1] - arms[0], np.cross(arms[1] - arms[0], arms[2] - arms[0])
        first, normal = first / np.linalg.norm(first), normal / np.linalg.norm(normal)
        return np.column_stack([first, np.cross(normal, first), normal])

    def share(self, force, torque):
        """Forces (n, 3) and moments (n, 3) on the nodes with the resultants given, about their middle."""
        arms = self.arms()
        turning = _solve(arms, torque)
        forces = np.cross(turning, arms)
        rest = torque - np.cross(arms, forces).sum(axis=0)  # about a connection itself
        return forces + force / len(arms), np.tile(rest / len(arms), (len(arms), 1))

    def _of(self, name):
        return np.array([getattr(state, name) for state in self._states], float)


class NodeForces:
    """O.forces for an exchange: what is added to an element goes to its nodes.

    forces : O.forces. elements : dict of `Element` by the number of the body.
    """

    def __init__(self, forces, elements):
        self._forces, self._elements = forces, elements

    def addF(self, number, force, isPermanent):
        """Adds a force, kN."""
        self._add(number, self._forces.addF, force, 0.0)

    def addT(self, number, torque, isPermanent):
        """Adds a moment about the position, kN m."""
        self._add(number, self._forces.addT, 0.0, torque)

    def _add(self, number, direct, force, torque):
        element = self._elements.get(number)
        if element is None:
            direct(number, torque if isinstance(force, float) else force, False)
            return
        zero = np.zeros(3)
        forces, torques = element.share(zero + np.array(force), zero + np.array(torque))
        for node, ofNode, momentOfNode in zip(element.ids, forces, torques):
            self._forces.addF(node, tuple(ofNode), False)
            if momentOfNode.any():
                self._forces.addT(node, tuple(momentOfNode), False)


def _solve(arms, moment):
    """The vector w with sum r x (w x r) = moment over the arms r; of two nodes without a part along them."""
    if len(arms) == 2:
        return 2 * _across(arms[1] - arms[0], moment) / ((arms[1] - arms[0]) ** 2).sum()
    inertia = sum(r @ r * np.eye(3) - np.outer(r, r) for r in arms)
    return np.linalg.solve(inertia, moment)


def _across(along, vector):
    return vector - along * (along @ vector) / (along @ along)


def _turnFrom(start, along):
    """The shortest turn from one direction to another, as a matrix."""
    a, b = start / np.linalg.norm(start), along / np.linalg.norm(along)
    axis, cosine = np.cross(a, b), a @ b
    if cosine < -1 + 1e-12:  # half a turn, about the axis of YADE that is most across
        across = np.cross(a, np.eye(3)[np.argmin(np.abs(a))])
        across /= np.linalg.norm(across)
        return 2 * np.outer(across, across) - np.eye(3)
    skew = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    return np.eye(3) + skew + skew @ skew / (1 + cosine)


def _quaternion(turn):
    """The quaternion (x, y, z, w) of a rotation matrix, from its largest component."""
    diagonal = np.array([*np.diag(turn), np.trace(turn)])
    k = int(np.argmax(diagonal))
    skew = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
    if k == 3:
        quaternion = np.append(skew, 1 + diagonal[3])
    else:
        quaternion = np.append(turn[:, k] + turn[k, :], skew[k])
        quaternion[k] = 1 + 2 * diagonal[k] - diagonal[3]
    return tuple(quaternion / math.sqrt(quaternion @ quaternion))
