# SPDX-License-Identifier: GPL-2.0-or-later
"""Pieces of HTML with which objects show themselves in a notebook."""

import base64
import io
from html import escape


def table(heads, rows):
    """A table of texts and numbers."""
    head = "".join(f"<th>{escape(str(h))}</th>" for h in heads)
    lines = ("".join(f"<td>{escape(str(cell))}</td>" for cell in row) for row in rows)
    return f"<table><tr>{head}</tr>{''.join(f'<tr>{line}</tr>' for line in lines)}</table>"


def card(title, *parts):
    """A title, and what belongs to it."""
    return f"<div><p><b>{escape(title)}</b></p>{''.join(parts)}</div>"


def pictureTag(draw):
    """A small picture, drawn by draw(axes), in the page itself; the settings of matplotlib stay."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(4.2, 2.8), dpi=90, layout="constrained")
    FigureCanvasAgg(figure)
    draw(figure.subplots())
    image = io.BytesIO()
    figure.savefig(image, format="png")
    return f'<img src="data:image/png;base64,{base64.b64encode(image.getvalue()).decode()}">'
