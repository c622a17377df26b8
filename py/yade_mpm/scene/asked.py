# SPDX-License-Identifier: GPL-2.0-or-later
"""Engines that calls of a scene have edited: they have to stay among its engines."""


class Asked(list):
    """List of engines; false where no call has edited one."""

    def add(self, engine):
        """Notes an engine, once."""
        if not any(engine is other for other in self):
            self.append(engine)

    def refuseLost(self, engines):
        """ValueError where a chain is without one of them, and so without what was asked for."""
        for engine in self:
            if not any(engine is other for other in engines):
                kind = type(engine).__name__
                calls = {"Contact": "scene.contact", "RigidContact": "scene.contact or scene.terrain"}
                call = calls.get(kind, "gravity, damping, fix, roller or drive")
                raise ValueError(
                    f"Scene: the engines are without the {kind} that calls of the scene have edited "
                    f"({call}); keep it in the list, or give the chain first and call then"
                )
