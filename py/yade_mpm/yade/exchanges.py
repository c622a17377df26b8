# SPDX-License-Identifier: GPL-2.0-or-later
"""What stands in the exchanges of a coupling: checked at the beginning of every run."""

from ..engine.rigidContact import RigidContact
from .bodies import Bodies, hosted


def checkExchanges(coupling):
    """At the beginning of a run. RuntimeError for `Bodies` of a contact that the scene does not have, and for
    a contact with bodies of YADE that nobody exchanges with."""
    coupling.exchanges[:] = _once(coupling)
    contacts = _contacts(coupling)
    for bodies in (e for e in coupling.exchanges if isinstance(e, Bodies)):
        if not any(bodies.contact is c for c in contacts):
            raise RuntimeError(
                f"yade.Bodies: the RigidContact of bodies {bodies.ids} is not among the engines of the scene "
                f"'{coupling.label}'; put it behind ParticleToGrid, and attach the scene again"
            )
        bodies.pairUp(coupling.scene)
        bodies.warnOfDensities(coupling.scene)
    if all(isinstance(e, Bodies) for e in coupling.exchanges):
        _refuseUnfelt(coupling, lambda bodies: any(bodies is e for e in coupling.exchanges))


def checkRead(coupling):
    """After the first exchange of a run: the same RuntimeError where other objects stand in exchanges, which
    may have Bodies of their own."""
    _refuseUnfelt(coupling, lambda bodies: bodies.wasRead(coupling))


def _refuseUnfelt(coupling, isFelt):
    for contact in _contacts(coupling):
        if contact in hosted and not contact.dead and not any(isFelt(b) for b in hosted[contact]):
            raise RuntimeError(
                f"yade: nobody exchanges with the RigidContact of '{coupling.label}': its bodies would "
                "stand still in the soil, and those of YADE fall through it; call mpm.inYade(scene, "
                "bodies=[...]) with the mpm.yade.Bodies of this contact"
            )


def _contacts(coupling):
    return [e for e in coupling.scene.engines if isinstance(e, RigidContact)]


def _once(coupling):
    """The exchanges, each once; those kept from the last `attach` yield to new Bodies."""
    exchanges = []
    for exchange in coupling.exchanges:
        if not any(exchange is e for e in exchanges):
            exchanges.append(exchange)
    again = [e.contact for e in exchanges if isinstance(e, Bodies) and e not in coupling.kept]
    return [
        e
        for e in exchanges
        if not (isinstance(e, Bodies) and e in coupling.kept and any(e.contact is c for c in again))
    ]
