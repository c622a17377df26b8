# SPDX-License-Identifier: GPL-2.0-or-later
"""report.html of a study: one file without scripts, servers or links to elsewhere; rewritten as cases end."""

import itertools
import os
from glob import escape as literal
from glob import glob

import numpy as np

from ..base.html import linkTo, paragraph, textOf
from ..io.files import replacing
from . import collect, identity, pictures, state
from .sensitivity import firstOrder

RESULTS, EFFECTS, MAPS, SHOWN = 8, 4, 3, 60  # columns, rows of effects, heat maps, cases with a picture
SAMPLE = 8  # cases at least for indices
COLOURED = 4  # parameters at most by which curves are coloured
SEEN = 2e-3  # of the height of a picture: half a line
FINDINGS = "findings.txt"  # beside the report: paragraphs that it begins with
STYLE = """
body{font:16px/1.45 system-ui,sans-serif;margin:0 auto;max-width:70rem;padding:1rem;color:#222}
h1{font-size:1.5rem;margin:.2em 0}h2{font-size:1.15rem;margin:1.6em 0 .4em}
.wide{overflow-x:auto}table{border-collapse:collapse;font-size:.85rem;white-space:nowrap}
th,td{padding:.25rem .6rem;border-bottom:1px solid #ddd;text-align:right}th{background:#f4f4f4}
td.t{text-align:left}tr.failed td,tr.timed td{background:#fde4e1}tr.running td{background:#e8f1fd}
tr.interrupted td,tr.waiting td{color:#777}svg,img{max-width:100%;height:auto}
.effects svg{min-width:32rem}
.cards{display:grid;grid-template-columns:repeat(auto-fill,minmax(16rem,1fr));gap:1rem}
figure{margin:0}figcaption{font-size:.85rem}pre{overflow-x:auto;background:#f4f4f4;padding:.6rem;font-size:.8rem}
"""


def write(study, frame):
    """Writes the report of a study whose table is given."""
    done = frame[frame["state"] == state.DONE]
    varied = [name for name in study.varied if name in frame.columns]
    found = _results(study, done)
    measured = study.show or _measured(done, found)
    with pictures.plainText():
        parts = [_head(study, frame), _findings(study), _table(study, frame, varied, found)]
        parts += [
            _failures(study, frame),
            _curves(study, frame, varied),
            _effects(study, done, varied, measured),
        ]
        parts += [
            _indices(study, done, varied, measured),
            _maps(study, done, varied, measured),
            _cards(study),
        ]
    text = page(study.title, "".join(p for p in parts if p))
    with replacing(os.path.join(study.out, "report.html")) as part, open(part, "w") as opened:
        opened.write(text)


def page(title, body):
    """A page that stands alone."""
    return f"""<!DOCTYPE html><html lang="en"><head><meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1"><title>{textOf(title)}</title>
<style>{STYLE}</style></head><body>{body}</body></html>
"""


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


def _head(study, frame):
    counts = frame["state"].value_counts()
    words = ", ".join(f"{n} {how}" for how, n in counts.items())
    files = "".join(
        f' <a href="{name}">{name}</a>'
        for name in ("results.csv", "results.parquet")
        if os.path.exists(os.path.join(study.out, name))
    )
    seconds = frame["seconds"].astype(float).sum()
    return (
        f"<h1>{textOf(study.title)}</h1><p>{len(frame)} cases: {textOf(words)}; {seconds:.0f} s "
        f"of runs; yade_mpm {textOf(identity.codeVersion())}. Table:{files}</p>"
    )


def _findings(study):
    file = os.path.join(study.out, FINDINGS)
    if not os.path.exists(file):
        return ""
    with open(file, encoding="utf-8") as opened:
        paragraphs = opened.read().strip().split("\n\n")
    return "<h2>Findings</h2>" + "".join(map(paragraph, paragraphs))


def _table(study, frame, varied, found):
    names = [*varied, *found, "seconds"]
    rows = [
        "<tr><th>case</th><th>state</th>"
        + "".join(f"<th>{textOf(study.head(n))}</th>" for n in names)
        + "</tr>"
    ]
    for number, (folder, row) in enumerate(zip(study.folders, frame.to_dict("records")), 1):
        link = f'<a href="{_link(study, folder)}/">{number}</a>'
        log = textOf(row["state"])
        if os.path.exists(os.path.join(folder, state.LOG)):
            log = f'<a href="{_link(study, folder)}/{state.LOG}">{log}</a>'
        cells = "".join(f"<td>{_shown(row[n])}</td>" for n in names)
        rows.append(f'<tr class="{textOf(row["state"])}"><td>{link}</td><td class="t">{log}</td>{cells}</tr>')
    return f'<h2>Cases</h2><div class="wide"><table>{"".join(rows)}</table></div>'


def _shown(value):
    if value is None or isinstance(value, float) and np.isnan(value):
        return ""
    return f"{value:.4g}" if isinstance(value, float) else textOf(str(value))


def _link(study, folder):
    return linkTo(os.path.relpath(folder, study.out).replace(os.sep, "/"))


def _failures(study, frame):
    parts = []
    for folder, row in zip(study.folders, frame.to_dict("records")):
        if row["state"] in (state.FAILED, state.TIMED_OUT):
            what = f"{row['state']}: {study.labels[folder]}: {row['message']}"
            log = textOf(state.endOfLog(folder))
            parts.append(f"<details open><summary>{textOf(what)}</summary><pre>{log}</pre></details>")
    return "<h2>Failures</h2>" + "".join(parts) if parts else ""


def _curves(study, frame, varied):
    named, rows = {}, {}
    for row, folder in enumerate(study.folders):
        if state.read(folder)["state"] == state.DONE:
            for file in sorted(glob(os.path.join(literal(folder), "curve_*.csv"))):
                name = os.path.basename(file)[len("curve_") : -len(".csv")]
                label = study.labels[folder]
                named.setdefault(name, {})[label] = _readCurve(file)
                rows.setdefault(name, {})[label] = row
    parts = []
    same = [name for name, own in named.items() if len(own) > 1 and _areSame(own.values())]
    for name in same if len(same) < len(named) else ():  # a curve that no parameter changes shows nothing
        del named[name]
    for name, own in named.items():
        cases = list(rows[name].values())
        values = {study.head(p): list(frame[p].iloc[cases]) for p in varied[:COLOURED]}
        parts.append(f"<h2>{textOf(name)}</h2>{pictures.curves(own, values)}")
    return "".join(parts)


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
    text = "Grey: cases; red: mean of the cases with that value, or near it in a sample."
    head = f"<h2>Main effects</h2><p>{text}</p>"
    heads = {name: study.head(name) for name in varied}
    picture = pictures.effects(_whole(done, found), heads, found[:EFFECTS])
    return f'{head}<div class="wide effects">{picture}</div>'


def _whole(done, found):
    """Cases that have all the results that are compared."""
    return done.dropna(subset=found[:EFFECTS])


def _indices(study, done, varied, found):
    if len(done) < SAMPLE or not varied or not found:
        return ""
    heads = "".join(f"<th>{textOf(study.head(n))}</th>" for n in varied)
    rows = [f"<tr><th>result</th>{heads}<th>sum</th></tr>"]
    for result in found:
        own = done.dropna(subset=[result])
        indices = [firstOrder(list(own[name]), own[result]) for name in varied]
        cells = "".join(f"<td>{'' if s is None else f'{s:.2f}'}</td>" for s in [*indices, _sum(indices)])
        rows.append(f'<tr><td class="t">{textOf(result)}</td>{cells}</tr>')
    text = (
        "First-order Sobol indices, from the means of groups of cases: the share of a result's variance that "
        "a parameter explains alone. What is missing to 1 is interaction, or scatter of a sample."
    )
    return f'<h2>Sensitivity</h2><p>{text}</p><div class="wide"><table>{"".join(rows)}</table></div>'


def _sum(indices):
    return None if None in indices else sum(indices)


def _maps(study, done, varied, found):
    if len(done) < 4 or not found:
        return ""
    pairs = list(itertools.combinations(varied, 2))[:MAPS]
    own = done.dropna(subset=found[:1])
    heads = {name: study.head(name) for name in varied}
    maps = [f"<figure>{pictures.heatMap(own, *pair, found[0], heads)}</figure>" for pair in pairs]
    return f'<h2>Heat maps</h2><div class="cards">{"".join(maps)}</div>' if maps else ""


def _cards(study):
    cards = []
    for number, folder in enumerate(study.folders, 1):
        images = sorted(glob(os.path.join(literal(folder), "*.png")))
        if images and len(cards) < SHOWN:
            image = f"{_link(study, folder)}/{linkTo(os.path.basename(images[0]))}"
            label = textOf(study.labels[folder])
            cards.append(
                f'<figure><a href="{image}"><img loading="lazy" src="{image}" alt="{label}"></a>'
                f"<figcaption>{number}: {label}</figcaption></figure>"
            )
    return f'<h2>Pictures</h2><div class="cards">{"".join(cards)}</div>' if cards else ""
