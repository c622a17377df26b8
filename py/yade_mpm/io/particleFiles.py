# SPDX-License-Identifier: GPL-2.0-or-later
"""The particles of a body as a table: CSV, VTU."""

import csv
import os

import numpy as np

from ..base.wording import shown
from .files import checkWritable, replacing
from .frame import COMPONENTS, MEMBER, cellData


def writeParticles(body, file, fields=None):
    """Writes the particles of a body as CSV or VTU, in the order of their ids; see `Body.write`."""
    name = os.fspath(file)
    who, ending = f"body '{body.name}': write", os.path.splitext(name)[1].lower()
    if ending not in (".csv", ".vtu"):
        raise ValueError(f"{who}: {shown(name)} is neither CSV nor VTU; give a name that ends in one")
    checkWritable(name, who)
    data, units = cellData([(0, body)], fields)
    if unknown := [field for field in fields or () if np.isnan(data[field]).all() and body.count]:
        raise ValueError(f"{who}: there is no field {shown(unknown[0])}; {', '.join(body.fieldNames)}")
    order = np.argsort(data["id"], kind="stable")
    thickness = body.scene._thicknessAt(body.position[:, 0])
    table = {"volume": body.volume / thickness, **data}
    table = {k: v[order] for k, v in table.items() if k not in ("body", "position") and MEMBER not in k}
    units["volume"] = "m3" if body.scene.dim == 3 else "m2"
    with replacing(name) as part:
        if ending == ".csv":
            _writeCSV(part, body.position[order], table, units)
        else:
            _writeVTU(part, body.position[order], table)


def _writeCSV(file, positions, table, units):
    columns = {f"{axis} [m]": positions[:, k] for k, axis in enumerate("xyz"[: positions.shape[1]])}
    for name, values in table.items():
        unit = f" [{units[name]}]"
        if values.ndim == 1:
            columns[name + unit] = values
        else:
            for part, column in zip(COMPONENTS[values.shape[1]], values.T):
                columns[f"{name}.{part}{unit}"] = column
    with open(file, "w", newline="", encoding="utf-8") as opened:
        writer = csv.writer(opened)
        writer.writerow(columns)
        writer.writerows(zip(*(column.tolist() for column in columns.values())))


def _writeVTU(file, positions, table):
    import meshio

    points = np.zeros((len(positions), 3))
    points[:, : positions.shape[1]] = positions
    cells = [("vertex", np.arange(len(points))[:, None])]
    meshio.Mesh(points, cells, point_data=table).write(file, file_format="vtu")
