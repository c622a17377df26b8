# SPDX-License-Identifier: GPL-2.0-or-later
"""Pieces of HTML: cards of objects in a notebook, reports of studies.

Names and texts may come from a file of a stranger. What stands in a page goes through `textOf`, what stands
in an address through `linkTo`; nothing else makes HTML of a value.
"""

import base64
import io
from html import escape
from urllib.parse import quote


def textOf(value):
    """A value as text of a page, or of an attribute in quotes."""
    return escape(str(value))


def linkTo(path):
    """The path of a file as the address of a link."""
    return quote(path)


def paragraph(value):
    """A paragraph of text."""
    return f"<p>{textOf(value)}</p>"


def table(heads, rows):
    """A table of texts and numbers."""
    head = "".join(f"<th>{textOf(h)}</th>" for h in heads)
    lines = ("".join(f"<td>{textOf(cell)}</td>" for cell in row) for row in rows)
    return f"<table><tr>{head}</tr>{''.join(f'<tr>{line}</tr>' for line in lines)}</table>"


def card(title, *parts):
    """A title, and what belongs to it."""
    return f"<div><p><b>{textOf(title)}</b></p>{''.join(parts)}</div>"


def pictureTag(draw, size=(4.2, 2.8)):
    """A picture, drawn by draw(axes), in the page itself; the settings of matplotlib stay. size : inches."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=size, dpi=90, layout="constrained")
    FigureCanvasAgg(figure)
    draw(figure.subplots())
    image = io.BytesIO()
    figure.savefig(image, format="png")
    return f'<img src="data:image/png;base64,{base64.b64encode(image.getvalue()).decode()}">'
