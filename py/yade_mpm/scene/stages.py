# SPDX-License-Identifier: GPL-2.0-or-later
"""Stages of construction: names for what happens between runs, with what was found at the end of each."""

from __future__ import annotations

import os

import numpy as np

from ..base.attributes import keep
from ..base.wording import shown
from ..diagnostics.forces import unbalancedRatio
from ..engine.supports import Spring
from ..geometry.numbers import isNumber


class Stage:
    """One stage, made by `Scene.stage` for a `with` block.

    Attributes
    ----------
    name : its name.
    begin, end : s, scene time; end is None inside of the block.
    values : dict name -> number, what `note` was told, the forces of springs at the end, and `unbalanced`,
        `diagnostics.unbalancedRatio` there: at rest below 0.05.
    """

    def __init__(self, scene, name, picture):
        self._scene, self._picture = scene, picture
        self.name, self.begin, self.end, self.values = name, scene.time, None, {}

    def note(self, **values: float) -> None:
        """Keeps numbers of the stage, for `scene.stages`, checkpoints and the report.

        Parameters
        ----------
        values : name=number, e.g. moment=forces.M.max().
        """
        for name, value in values.items():
            if not isNumber(value):
                raise TypeError(f"Stage '{self.name}': {name} = {shown(value)}; give a number")
            self.values[name] = float(value)

    def __enter__(self) -> Stage:
        inside = self._scene._stage
        if inside is not None:
            raise RuntimeError(
                f"stage: {shown(self.name)} begins inside of {shown(inside)}; end that block first"
            )
        keep(self._scene, _stage=self.name)
        return self

    def __exit__(self, kind, *error):
        scene = self._scene
        keep(scene, _stage=None)
        if kind is not None:
            return  # what failed is no stage
        self.end = scene.time
        for engine in scene.engines:
            if isinstance(engine, Spring) and not engine.dead:
                self.values.setdefault(f"{engine.label}.force", float(engine.force))
        if np.isfinite(ratio := unbalancedRatio(scene)):
            self.values.setdefault("unbalanced", ratio)
        scene._stages.append({"name": self.name, "begin": self.begin, "end": self.end, "values": self.values})
        if self._picture is not None:
            axes = scene.plot("displacement")
            axes.set_title(self.name)
            axes.figure.savefig(self._picture, dpi=120)


def stage(scene, name: str, picture: str | os.PathLike | None = None) -> Stage:
    """Gives what happens in a `with` block a name: a row of `scene.stages`, of checkpoints and of the report.

        with scene.stage("dig to -3 m") as dig:
            scene.remove(region=mpm.box((8, 5), (16, 8)))
            scene.run(until=scene.time + 2)
            dig.note(moment=abs(mpm.sectionForces(wall).M).max())

    Parameters
    ----------
    name : of the stage.
    picture : name of a picture that is made at its end, of the displacement; 2D; default: none.

    A block that ends with an error is no stage. Raises TypeError and ValueError for a name that is no text
    or is taken; RuntimeError inside of another stage.
    """
    if not (isinstance(name, str) and name):
        raise TypeError(f"stage: name = {shown(name)}; give a text")
    if any(name == row["name"] for row in scene._stages):
        raise ValueError(f"stage: there is a stage {shown(name)} already; give each a name of its own")
    if picture is not None and scene.dim != 2:
        raise ValueError("stage: pictures are made of 2D scenes; record a file for ParaView")
    return Stage(scene, name, picture)


def checkedRows(rows):
    """Stages of a checkpoint; ValueError for what no scene has."""
    for row in rows:
        isOne = isinstance(row, dict) and set(row) == {"name", "begin", "end", "values"}
        isOne = isOne and isinstance(row["name"], str) and isNumber(row["begin"]) and isNumber(row["end"])
        if not (isOne and isinstance(row["values"], dict) and all(map(isNumber, row["values"].values()))):
            raise ValueError(f"stage {shown(row)} is none of a scene")
    return [dict(row) for row in rows]
