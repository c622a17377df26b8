# SPDX-License-Identifier: GPL-2.0-or-later
"""The report of a study, one HTML page that stands alone: cases, curves, effects, failures."""

import itertools
import os
from glob import escape as literal
from glob import glob

import numpy as np

from ..base.html import linkTo
from ..io.files import replacing
from . import collect, identity, pictures, state
from .optional import needed
from .sensitivity import firstOrder

RESULTS, EFFECTS, MAPS, SHOWN = 8, 4, 3, 60  # columns, rows of effects, heat maps, cases with a picture
SAMPLE = 8  # cases at least for indices
COLOURED = 4  # parameters at most by which curves are coloured
SEEN = 2e-3  # of the height of a picture: half a line
FINDINGS = "findings.txt"  # beside the report: paragraphs that it begins with
PAGE = """<!DOCTYPE html><html lang="en"><head><meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1"><title>{{ title }}</title>
<style>
body{font:16px/1.45 system-ui,sans-serif;margin:0 auto;max-width:70rem;padding:1rem;color:#222}
h1{font-size:1.5rem;margin:.2em 0}h2{font-size:1.15rem;margin:1.6em 0 .4em}
.wide{overflow-x:auto}table{border-collapse:collapse;font-size:.85rem;white-space:nowrap}
th,td{padding:.25rem .6rem;border-bottom:1px solid #ddd;text-align:right}th{background:#f4f4f4}
td.t{text-align:left}tr.failed td,tr.timed td{background:#fde4e1}tr.running td{background:#e8f1fd}
tr.interrupted td,tr.waiting td{color:#777}svg,img{max-width:100%;height:auto}
.effects svg{min-width:32rem}
.cards{display:grid;grid-template-columns:repeat(auto-fill,minmax(16rem,1fr));gap:1rem}
figure{margin:0}figcaption{font-size:.85rem}pre{overflow-x:auto;background:#f4f4f4;padding:.6rem;font-size:.8rem}
</style></head><body>
<h1>{{ title }}</h1>
{% block body %}{% endblock %}
</body></html>
"""
STUDY = """{% extends "page" %}{% block body %}
<p>{{ counted }}; {{ seconds }} s of runs; yade_mpm {{ version }}. Table:
{% for file in files %} <a href="{{ file }}">{{ file }}</a>{% endfor %}</p>
{% if findings %}<h2>Findings</h2>{% for text in findings %}<p>{{ text }}</p>{% endfor %}{% endif %}
<h2>Cases</h2><div class="wide"><table>
<tr><th>case</th><th>state</th>{% for head in heads %}<th>{{ head }}</th>{% endfor %}</tr>
{% for row in rows %}<tr class="{{ row.state }}"><td><a href="{{ row.link }}/">{{ loop.index }}</a></td>
<td class="t">{% if row.log %}<a href="{{ row.link }}/{{ row.log }}">{{ row.state }}</a>
{%- else %}{{ row.state }}{% endif %}</td>
{%- for cell in row.cells %}<td>{{ cell }}</td>{% endfor %}</tr>
{% endfor %}</table></div>
{% if failures %}<h2>Failures</h2>{% for what, log in failures %}
<details open><summary>{{ what }}</summary><pre>{{ log }}</pre></details>{% endfor %}{% endif %}
{% for name, picture in curves %}<h2>{{ name }}</h2>{{ picture | safe }}{% endfor %}
{% if effects %}<h2>Main effects</h2>
<p>Grey: cases; red: mean of the cases with that value, or near it in a sample.</p>
<div class="wide effects">{{ effects | safe }}</div>{% endif %}
{% if indices %}<h2>Sensitivity</h2>
<p>First-order Sobol indices, from the means of groups of cases: the share of a result's variance that a
parameter explains alone. What is missing to 1 is interaction, or scatter of a sample.</p>
<div class="wide"><table>
<tr><th>result</th>{% for head in varied %}<th>{{ head }}</th>{% endfor %}<th>sum</th></tr>
{% for result, cells in indices %}<tr><td class="t">{{ result }}</td>
{%- for cell in cells %}<td>{{ cell }}</td>{% endfor %}</tr>
{% endfor %}</table></div>{% endif %}
{% if maps %}<h2>Heat maps</h2><div class="cards">
{% for map in maps %}<figure>{{ map | safe }}</figure>{% endfor %}</div>{% endif %}
{% if cards %}<h2>Pictures</h2><div class="cards">{% for number, label, image in cards %}
<figure><a href="{{ image }}"><img loading="lazy" src="{{ image }}" alt="{{ label }}"></a>
<figcaption>{{ number }}: {{ label }}</figcaption></figure>{% endfor %}</div>{% endif %}
{% endblock %}"""


def writePage(file, template, **values):
    """Writes a page made of a template; values are text in it, whatever they hold."""
    jinja2 = needed("jinja2", "the report of a study")
    templates = jinja2.DictLoader({"page": PAGE, "own": template})
    text = jinja2.Environment(autoescape=True, loader=templates).get_template("own").render(values)
    with replacing(file) as part, open(part, "w") as opened:
        opened.write(text)


def write(study, frame):
    """Writes the report of a study whose table is given."""
    done = frame[frame["state"] == state.DONE]
    varied = [name for name in study.varied if name in frame.columns]
    found = _results(study, done)
    measured = study.show or _measured(done, found)
    names, counts = [*varied, *found, "seconds"], frame["state"].value_counts()
    with pictures.plainText():
        drawn = dict(
            curves=_curves(study, frame, varied),
            effects=_effects(study, done, varied, measured),
            maps=_maps(study, done, varied, measured),
        )
    writePage(
        os.path.join(study.out, "report.html"),
        STUDY,
        title=study.title,
        counted=f"{len(frame)} cases: " + ", ".join(f"{n} {how}" for how, n in counts.items()),
        seconds=f"{frame['seconds'].astype(float).sum():.0f}",
        version=identity.codeVersion(),
        files=[f for f in ("results.csv", "results.parquet") if os.path.exists(os.path.join(study.out, f))],
        findings=_findings(study),
        heads=[study.head(name) for name in names],
        rows=[_row(study, *case, names) for case in zip(study.folders, frame.to_dict("records"))],
        failures=_failures(study, frame),
        varied=[study.head(name) for name in varied],
        indices=_indices(done, varied, measured),
        cards=_cards(study),
        **drawn,
    )


def _results(study, done):
    """Names of the results to show: those asked for, or the first that differ between cases."""
    known = [n for n in done.columns if n not in collect.ABOUT and n not in study.argumentNames]
    if study.show:
        missing = [n for n in study.show if n not in known]
        if missing and len(done):
            raise ValueError(f"study: there is no result {missing[0]}; there are {', '.join(known)}")
        return [n for n in study.show if n in known]
    isNumber = [n for n in known if done[n].dtype.kind in "if" and n not in collect.COST]
    differ = [n for n in isNumber if done[n].nunique() > 1]
    return (differ or isNumber)[:RESULTS]


def _measured(done, found):
    """Results without counts, such as of particles, where there are others."""
    return [name for name in found if done[name].dtype.kind != "i"] or found


def _findings(study):
    file = os.path.join(study.out, FINDINGS)
    if not os.path.exists(file):
        return []
    with open(file, encoding="utf-8") as opened:
        return opened.read().strip().split("\n\n")


def _row(study, folder, row, names):
    hasLog = os.path.exists(os.path.join(folder, state.LOG))
    cells = [_shown(row[name]) for name in names]
    return dict(state=row["state"], link=_link(study, folder), log=state.LOG if hasLog else None, cells=cells)


def _shown(value):
    if value is None or isinstance(value, float) and np.isnan(value):
        return ""
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def _link(study, folder):
    return linkTo(os.path.relpath(folder, study.out).replace(os.sep, "/"))


def _failures(study, frame):
    return [
        (f"{row['state']}: {study.labels[folder]}: {row['message']}", state.endOfLog(folder))
        for folder, row in zip(study.folders, frame.to_dict("records"))
        if row["state"] in (state.FAILED, state.TIMED_OUT)
    ]


def _curves(study, frame, varied):
    named, rows = {}, {}
    for row, folder in enumerate(study.folders):
        if state.read(folder)["state"] == state.DONE:
            for file in sorted(glob(os.path.join(literal(folder), "curve_*.csv"))):
                name = os.path.basename(file)[len("curve_") : -len(".csv")]
                label = study.labels[folder]
                named.setdefault(name, {})[label] = _readCurve(file)
                rows.setdefault(name, {})[label] = row
    same = [name for name, own in named.items() if len(own) > 1 and _areSame(own.values())]
    for name in same if len(same) < len(named) else ():  # a curve that no parameter changes shows nothing
        del named[name]
    drawn = []
    for name, own in named.items():
        cases = list(rows[name].values())
        values = {study.head(p): list(frame[p].iloc[cases]) for p in varied[:COLOURED]}
        drawn.append((name, pictures.curves(own, values)))
    return drawn


def _areSame(curves):
    """Whether nobody can tell the curves of all cases apart in a picture."""
    (x, y), *others = (points.T for _, points in curves)
    rise = all((np.diff(at) >= 0).all() and len(at) for at, _ in ((x, y), *others))
    return rise and all((abs(np.interp(x, *other) - y) <= SEEN * np.ptp(y)).all() for other in others)


def _readCurve(file):
    with open(file, encoding="utf-8") as opened:
        names = opened.readline().strip().split(",")
    return names, np.loadtxt(file, delimiter=",", skiprows=1, ndmin=2)


def _effects(study, done, varied, found):
    if len(done) < 2 or not varied or not found:
        return ""
    whole = done.dropna(subset=found[:EFFECTS])  # cases that have all the results that are compared
    return pictures.effects(whole, {name: study.head(name) for name in varied}, found[:EFFECTS])


def _indices(done, varied, found):
    if len(done) < SAMPLE or not varied:
        return []
    rows = []
    for result in found:
        own = done.dropna(subset=[result])
        indices = [firstOrder(list(own[name]), own[result]) for name in varied]
        indices.append(None if None in indices else sum(indices))
        rows.append((result, ["" if s is None else f"{s:.2f}" for s in indices]))
    return rows


def _maps(study, done, varied, found):
    if len(done) < 4 or not found:
        return []
    own, heads = done.dropna(subset=found[:1]), {name: study.head(name) for name in varied}
    pairs = list(itertools.combinations(varied, 2))[:MAPS]
    return [pictures.heatMap(own, *pair, found[0], heads) for pair in pairs]


def _cards(study):
    cards = []
    for number, folder in enumerate(study.folders, 1):
        images = sorted(glob(os.path.join(literal(folder), "*.png")))
        if images and len(cards) < SHOWN:
            image = f"{_link(study, folder)}/{linkTo(os.path.basename(images[0]))}"
            cards.append((number, study.labels[folder], image))
    return cards
