# SPDX-License-Identifier: GPL-2.0-or-later
"""What attacks share: a process that takes the blows, and who tells which of them did harm.

Each case depends on its number and the seed alone, so `--only N` repeats one.
"""

import argparse
import collections
import contextlib
import json
import os
import re
import resource
import select
import signal
import subprocess
import sys
import tempfile
import time
import warnings

LONG = 10  # s of its processor time, after which a case is interrupted, which is no hang,
PATIENCE = 300  # s for one case, also on a machine that has little time for it,
START = 300  # and for a process to begin
MOST_MEMORY = 8 << 30  # bytes
LONGEST = 2000  # characters of an error
# Errors that users know, of their own making; others are from the inside.
KINDS = (ValueError, TypeError, KeyError, IndexError, AttributeError, RuntimeError, MemoryError, SystemExit)
KINDS += (NotImplementedError, ImportError, SyntaxError, argparse.ArgumentTypeError)
WORDS = "give given use set make choose move check take takes add lower enlarge report pause run mend got"
WORDS += " remove refine order count may lies need needs needed allowed must cannot not"
WORDS += " subtract let continue already only exists permission fill"
ADVICE = re.compile(
    rf"\b({WORDS.replace(' ', '|')}|there is no|has no|is no|no body has|did you mean|no such file)\b", re.I
)


def unclear(error, tokens):
    """Why an error says too little; empty: it does not."""
    kind = type(error)
    if not (kind in KINDS or isinstance(error, (OSError, TypeError, AttributeError))):
        return f"a {kind.__name__} is from the inside"
    text = str(error)
    if kind in (SystemExit, argparse.ArgumentTypeError):  # whose argument it is, argparse says
        return ""
    if isinstance(
        error, (TypeError, AttributeError)
    ):  # Python's own, of a wrong call or a value of another kind
        return "" if text else "no characters"
    if not text or len(text) > LONGEST:
        return f"{len(text)} characters"
    if not any(t.lower() in text.lower() for t in tokens):
        return "does not say who"
    if not ADVICE.search(text):
        return "does not say what is allowed"
    return ""


def answer(error, tokens):
    """What came of a case that ended with an error, and what it said."""
    why = unclear(error, tokens)
    return f"unclear: {why}" if why else "refused", f"{type(error).__name__}: {str(error)[:400]}"


def ofKinds(attack, kinds):
    """Function that prepares an attack (number, seed, kinds) for those whose name has an expression in it."""

    def prepared(match):
        chosen = [kind for kind in kinds if re.search(match, kind.__name__)]
        return lambda number, seed: attack(number, seed, chosen)

    return prepared


def worker(attack, first, last, seed):
    """Cases first ... last, a line of JSON each."""
    with open("/proc/self/statm") as file:  # a sanitizer has taken 20 TB of addresses already
        here = int(file.read().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (here + MOST_MEMORY, here + MOST_MEMORY))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    resource.setrlimit(resource.RLIMIT_FSIZE, (1 << 28, 1 << 28))
    say = os.fdopen(os.dup(1), "w")
    say.write("ready\n")
    for stream in (1, 2):
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream)
    signal.signal(signal.SIGPROF, signal.default_int_handler)  # as Ctrl-C
    for number in range(first, last):
        with contextlib.suppress(OSError):
            os.chdir(tempfile.gettempdir())
        with tempfile.TemporaryDirectory() as folder:
            os.chdir(folder)
            signal.setitimer(signal.ITIMER_PROF, LONG)
            try:
                result = attack(number, seed)
                signal.setitimer(signal.ITIMER_PROF, 0)  # inside: it may have rung at the end of attack()
            except KeyboardInterrupt:  # 10**9 steps, say, which somebody may want
                result = "?", "long", "it goes on until it is interrupted"
            signal.setitimer(signal.ITIMER_PROF, 0)
            os.chdir("/")
        say.write(json.dumps([number, *result], ensure_ascii=True) + "\n")
        say.flush()


def survey(script, count, seed=1, start=0, seconds=float("inf"), match="", program=(sys.executable,)):
    """Runs cases of an attack; returns a list of (number, label, outcome, text), with "crash" and "hang" as
    outcomes.

    seconds : s of wall time after which no more cases begin. match : expression that says what to attack,
    default all. program : that runs the script.
    """
    results, first, end = [], start, time.monotonic() + seconds
    while first < start + count and time.monotonic() < end:
        words = [*program, script, "--worker", str(first), str(start + count), "--seed", str(seed)]
        told, ending = _blows([*words, "--match", match], end)
        results += told
        first += len(told)
        if first < start + count and ending:
            results.append((first, "?", ending, ""))
            first += 1
    return results


def _blows(words, end):
    """Results up to the end of the process, and how it ended; empty: because time was over."""
    path = os.pathsep.join([os.path.dirname(__file__), os.environ.get("PYTHONPATH", "")])  # also of YADE
    environment = dict(os.environ, MPLBACKEND="Agg", OMP_NUM_THREADS="1", PYTHONPATH=path)
    child = subprocess.Popen(words, stdout=subprocess.PIPE, env=environment)
    told, ending = b"", ""
    while True:
        if not select.select([child.stdout], [], [], PATIENCE if b"ready\n" in told else START)[0]:
            ending = "hang"
            break
        read = os.read(child.stdout.fileno(), 1 << 16)
        if not read:
            ending = f"crash ({child.wait()})"
            break
        told += read
        if time.monotonic() > end:
            break
    child.kill()
    child.wait()
    child.stdout.close()
    greeting, ready, lines = told.decode().partition("ready\n")
    assert ready, f"the process that takes the blows did not start: {greeting}"
    return [tuple(json.loads(line)) for line in lines.split("\n")[:-1]], ending


def summary(results):
    """Dict outcome -> number, all ways of being unclear as one."""
    return collections.Counter(re.sub(r"[:(].*", "", outcome).strip() for _, _, outcome, _ in results)


def harmful(results):
    """Results that are neither accepted nor refused in words, and go on for ever whatever comes."""
    return [r for r in results if r[2] not in ("accepted", "refused", "long")]


def main(script, doc, prepared, program=(sys.executable,)):
    """Command line of an attack. prepared(match) makes the function (number, seed) -> (label, outcome, text);
    match is an expression that says what to attack. program : that runs the script."""
    parser = argparse.ArgumentParser(description=doc.splitlines()[0])
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--seed", type=int, help="default 1; with --seconds another one each day")
    parser.add_argument("--start", type=int, default=0)
    parser.add_argument("--seconds", type=float, help="take as many cases as there is time for")
    parser.add_argument("--show", type=int, default=20, help="cases to show that are not as they should be")
    parser.add_argument("--only", type=int, help="repeat one case here")
    parser.add_argument("--match", default="", help="expression: attack only what has it in its label")
    parser.add_argument("--all", metavar="FILE", help="write all cases to it, a line of JSON each")
    parser.add_argument("--worker", type=int, nargs=2, help=argparse.SUPPRESS)
    a = parser.parse_args()
    if a.seed is None:
        a.seed = 1 if a.seconds is None else int(time.strftime("%y%m%d"))
    if a.worker:
        warnings.simplefilter("ignore")
        worker(prepared(a.match), *a.worker, a.seed)
        return
    if a.only is not None:
        print(prepared(a.match)(a.only, a.seed))
        return
    count, seconds = (a.count, float("inf")) if a.seconds is None else (10**9, a.seconds)
    results = survey(script, count, a.seed, a.start, seconds, a.match, program)
    if a.all:
        with open(a.all, "w") as file:
            file.writelines(json.dumps(result) + "\n" for result in results)
    found = summary(results)
    print(f"{os.path.basename(script)}, seed {a.seed}, {len(results)} cases:", dict(found))
    for number, label, outcome, text in harmful(results)[: a.show]:
        print(number, label, "|", outcome, "|", text[:300])
    sys.exit(1 if found["crash"] + found["hang"] + found["silent"] else 0)
