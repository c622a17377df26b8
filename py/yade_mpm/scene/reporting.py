# SPDX-License-Identifier: GPL-2.0-or-later
"""The report of a scene: one page that stands alone, with its scene, materials, stages, pictures, curves and
verdict."""

import os

import numpy as np

from .. import __version__
from ..base.html import paragraph, pictureTag, table, textOf
from ..base.kinds import FILE, TEXT, takes
from ..base.wording import shown
from ..diagnostics.certificate import LIMITS, quasiStatic
from ..diagnostics.facePressure import facePressure
from ..diagnostics.sections import sectionForces
from ..engine.contact import Contact
from ..engine.supports import Spring
from ..io.files import replacing
from ..io.history import History
from .describing import longForm, summary
from .running import refuseDuringStep

STYLE = (
    "body{font:16px/1.45 system-ui,sans-serif;margin:0 auto;max-width:60rem;padding:1rem;color:#222}"
    "h1{font-size:1.5rem}h2{font-size:1.15rem;margin:1.6em 0 .4em}div.wide{overflow-x:auto}"
    "table{border-collapse:collapse;font-size:.85rem}th,td{padding:.25rem .6rem;border-bottom:1px solid #ddd;"
    "text-align:left}th{background:#f4f4f4}pre{overflow-x:auto;background:#f4f4f4;padding:.6rem;font-size:.8rem}"
    "img{max-width:100%;height:auto}"
)
REST = LIMITS["unbalancedRatio"]
PICTURE, CURVE, STRUCTURE = (7.0, 4.0), (7.0, 2.6), (9.6, 3.6)  # inches


@takes(file=FILE, title=TEXT)
def report(scene, file, title: str = "Report") -> None:
    """Writes one HTML page about the scene as it is now: for a client, and for the files.

        scene.report("wall.html", title="Propped wall, section A")

    It has what the scene is made of, its materials, the stages (`scene.stage`) with their numbers, pictures
    of the bodies and their displacement (2D), the forces and pressures of implicit bodies in 2D, curves of
    props and drives from the first `history`, whether the stages end at rest, the verdict of `quasiStatic`,
    and the script of the scene.

    Parameters
    ----------
    file : name of the page, ending in .html.
    title : its heading.

    Raises ValueError for another ending, OSError where it cannot be written, RuntimeError during a step.
    """
    refuseDuringStep(scene, "report")
    if not os.fspath(file).lower().endswith((".html", ".htm")):
        raise ValueError(
            f"report: file = {shown(os.fspath(file))} is not allowed; give a name that ends in .html"
        )
    parts = [
        ("Scene", _text("\n".join(summary(scene)))),
        ("Materials", _materials(scene)),
        ("Stages", _stages(scene)),
        *_pictures(scene),
        *_structures(scene),
        *_curves(scene),
        ("Verdict", _verdict(scene)),
        ("Script", _text(longForm(scene))),
    ]
    contents = "".join(f"<h2>{textOf(head)}</h2>{body}" for head, body in parts if body)
    about = paragraph(f"t = {scene.time:g} s, {scene.steps} steps; yade_mpm {__version__}; Mg, m, s, kPa.")
    with replacing(file) as part, open(part, "w", encoding="utf-8") as page:
        page.write(
            '<!DOCTYPE html><html lang="en"><head><meta charset="utf-8"><meta name="viewport" '
            f'content="width=device-width, initial-scale=1"><title>{textOf(title)}</title>'
            f"<style>{STYLE}</style></head><body><h1>{textOf(title)}</h1>{about}{contents}</body></html>"
        )


def _text(value):
    return f"<pre>{textOf(value)}</pre>"


def _wide(heads, rows):
    return f'<div class="wide">{table(heads, rows)}</div>' if rows else ""


def _materials(scene):
    """One row for each material, with the bodies that are made of it."""
    known = {id(body.material): body.material for body in scene.bodies}
    rows = []
    for material in known.values():
        bodies = ", ".join(body.name for body in scene.bodies if body.material is material)
        values = ", ".join(f"{name} = {_short(value)}" for name, value in material.attributes().items())
        rows.append((bodies, type(material).__name__, values))
    return _wide(("bodies", "law", "parameters"), rows)


def _short(value):
    if isinstance(value, tuple):
        return f"({', '.join(map(_short, value))})"[:80]
    return f"{value:.6g}" if isinstance(value, float) else str(value)[:80]


def _stages(scene):
    names = list(dict.fromkeys(name for row in scene.stages for name in row["values"]))
    rows = [
        (row["name"], f"{row['begin']:.4g}", f"{row['end']:.4g}")
        + tuple(f"{row['values'][name]:.4g}" if name in row["values"] else "" for name in names)
        for row in scene.stages
    ]
    return _wide(("stage", "from (s)", "to (s)", *names), rows)


def _pictures(scene):
    if scene.dim != 2 or not scene.particleCount:
        return
    yield "Bodies", pictureTag(lambda axes: scene.plot(axes=axes), PICTURE)
    if scene.steps:
        yield "Displacement", pictureTag(lambda axes: scene.plot("displacement", axes=axes), PICTURE)


def _structures(scene):
    """Forces and pressures of the bodies that are implicit: walls and piles."""
    from ..plot.structure import structure

    hasContact = any(isinstance(engine, Contact) and not engine.dead for engine in scene.engines)
    for body in scene.bodies if scene.dim == 2 and scene.steps else ():
        if not (body.implicit and body.count):
            continue
        isFaced = hasContact and all(
            b.cells is not None for b in scene.bodies if b.group == body.group and b.count
        )
        found = {body.name: (sectionForces(body), facePressure(body) if isFaced else None)}
        about = paragraph("Section forces at the end; pressure as the mean since the first contact.")
        drawn = pictureTag(lambda axes, f=found: structure(f, _figureOf(axes)), STRUCTURE)
        yield f"Forces in '{body.name}'", about + drawn


def _figureOf(axes):
    figure = axes.figure
    axes.remove()
    return figure


def _curves(scene):
    """Forces of props and reactions of drives over time."""
    history = next((e for e in scene.engines if isinstance(e, History) and len(e) > 1), None)
    if history is None:
        return
    springs = [f"{e.label}.force" for e in scene.engines if isinstance(e, Spring)]
    drives = [f"{c.name}.f{axis}" for c in scene._gridSolver("report").drives for axis in "xyz"[: scene.dim]]
    names = [name for name in (*springs, *drives, *history.columns) if name in history]
    for name in names:
        values = history[name]
        if np.isfinite(values).any():
            unit = history.units[name] or "-"

            def draw(axes, values=values, label=f"{name} ({unit})"):
                axes.plot(history["time"], values)
                axes.set(xlabel="time (s)", ylabel=label)

            yield name, pictureTag(draw, CURVE)


def _atRest(scene):
    """Whether the stages end at rest."""
    parts = {
        row["name"]: row["values"]["unbalanced"] for row in scene.stages if "unbalanced" in row["values"]
    }
    if not parts:
        return ""
    moving = [f"'{name}' {100 * part:.2g} %" for name, part in parts.items() if not part < REST]
    if moving:
        return paragraph(
            f"NOT at rest at the end, unbalanced forces above {100 * REST:g} %: {', '.join(moving)}."
        )
    which = "Every stage ends" if len(parts) == len(scene.stages) else "Stages end"
    return paragraph(
        f"{which} at rest: unbalanced forces of at most {100 * max(parts.values()):.2g} % (limit "
        f"{100 * REST:g} %). What follows is about the way there, on which sudden stages, such as a dig, are "
        "dynamic."
    )


def _verdict(scene):
    return _atRest(scene) + _quasiStatic(scene)


def _quasiStatic(scene):
    history = next((e for e in scene.engines if isinstance(e, History) and len(e) > 1), None)
    if history is None:
        return paragraph("The scene keeps no history, so nothing tells whether the run was quasi-static.")
    try:
        return _text(quasiStatic(history))
    except ValueError as error:
        return paragraph(f"The history does not tell whether the run was quasi-static: {error}")
