"""An effect that a scene does without costs nothing: no unknown, no bit, no difference to one at its neutral value."""

import numpy as np
import pytest

import handlcp as hl
from handlcp.studies.effect_catalogue import entries
from tests.grasp.effect_rows import FACES, ROWS, hands, planar, rings
from tests.support.grasp import arrays
from tests.support.lcp import eliminated

NAMES = [row.name for row in ROWS]
ALWAYS = ("object balance", "unilateral contact")  # the first rows


# ---------------------------------------------------------------- the problem as the model writes it
def by_hand(g, faces):
    """(M, q, how many are complementary) of a grasp of points without any effect asked for, block by block: order r_N,
    λ, u, r_T. All that is taken from the package is the size of a newton and a metre.
    """
    p, frames, w = np.array([c.position for c in g.contacts]), g.frames, arrays(g)
    mu, flat, unit = np.array([c.mu for c in g.contacts]), w.plane is not None, w.units
    n, c = len(p), unit.centre
    rough = np.flatnonzero(mu > 0)
    kept = [0] if flat else [0, 1]
    N = np.array([3 * i + 2 for i in range(n)])
    T = np.array([3 * i + k for i in rough for k in kept], dtype=int)
    columns = frames.transpose(0, 2, 1).reshape(-1, 3)
    arms = np.repeat(p - c, 3, axis=0)
    G = np.vstack([columns.T, np.cross(arms, columns).T * (1.0 / unit.length_unit)])
    f, about = w.force, w.moment
    moment = [about[0] - c[1] * f[2] + c[2] * f[1], about[1] - c[2] * f[0] + c[0] * f[2],
              about[2] - c[0] * f[1] + c[1] * f[0]]  # fmt: skip
    load = np.append(f, np.array(moment) * (1.0 / unit.length_unit)) / unit.force_unit
    if flat:
        G, load = G[[0, 1, 5]], load[[0, 1, 5]]
    E, d = g.flexibility * (unit.force_unit / unit.motion_unit), g.offset.ravel() / unit.motion_unit
    m = 2 if flat else 0 if faces == "cone" else faces
    a = 2 * np.pi * np.arange(m) / max(m, 1)
    facets = np.array([[1.0, -1.0]]) if flat else np.vstack([np.cos(a), np.sin(a)])
    facets[abs(facets) < 1e-15] = 0.0
    limit = mu if flat or not m else mu * np.cos(np.pi / m)
    rN, rl = np.arange(n), n + np.arange(m * len(rough))
    u = n + len(rl) + np.arange(len(load))
    rT = u[-1] + 1 + np.arange(len(T))
    size = n + len(rl) + len(load) + len(T)
    M, q = np.zeros((size, size)), np.zeros(size)
    for rows, one in ((rN, N), (rT, T)):
        for cols, other in ((rN, N), (rT, T)):
            M[np.ix_(rows, cols)] = E[np.ix_(one, other)]
        M[np.ix_(rows, u)], M[np.ix_(u, rows)] = G[:, one].T, G[:, one]
        q[rows] = d[one]
    q[u] = load
    for k, i in enumerate(rough):
        mine, tangents = rl[m * k : m * k + m], rT[len(kept) * k : len(kept) * (k + 1)]
        M[mine, i] = limit[i]
        M[np.ix_(mine, tangents)], M[np.ix_(tangents, mine)] = -facets.T, facets
    return M, q, n + len(rl)


PLAIN = {
    "planar, frictionless": lambda: planar(hl.Frictionless()),
    "planar": lambda: planar(hl.Coulomb(0.4)),
    "frictionless": lambda: rings(hl.Frictionless()),
    "hard fingers": rings,
    "hard fingers, one of them smooth": lambda: rings([hl.Coulomb(0.6), hl.Frictionless(), *[hl.Coulomb(0.4)] * 2]),
    "rigid": lambda: rings(flexibility=0.0),
    "a hand": hands,
}


@pytest.mark.parametrize("faces", [FACES, "cone"])
@pytest.mark.parametrize("name", PLAIN)
def test_a_scene_that_names_no_effect_is_the_model_block_by_block(name, faces):
    """M and q bit by bit, before and after elimination: no effect that is absent has left a trace."""
    g = PLAIN[name]()
    p = g.problem(faces)
    M, q, c = by_hand(g, faces)
    if isinstance(p, hl.GraspProblem):
        M, q = eliminated(M, q, c) if p.eliminated else (M, q)
        p = p.scaled
    np.testing.assert_array_equal(p.M, M)
    np.testing.assert_array_equal(p.q, q)


# ---------------------------------------------------------------- every effect
@pytest.mark.parametrize("row", ROWS, ids=NAMES)
def test_an_effect_brings_the_unknowns_that_its_law_has_and_no_others(row):
    with_it, without = ({u.name: u.count for u in g().problem(row.faces).groups} for g in (row.on, row.absent))
    for name in with_it | without | row.added:
        assert with_it.get(name, 0) - without.get(name, 0) == row.added.get(name, 0), name


@pytest.mark.parametrize("row", ROWS, ids=NAMES)
def test_an_effect_at_its_neutral_value_is_none(row):
    """The very same problem where the design says so; else the same forces, motions and states."""
    neutral, absent = row.neutral(), row.absent()
    if row.exact:
        a, b = neutral.problem(row.faces), absent.problem(row.faces)
        np.testing.assert_array_equal(a.M, b.M)
        np.testing.assert_array_equal(a.q, b.q)
        assert a.labels == b.labels
        return
    a, b = neutral.solve(row.faces), absent.solve(row.faces)
    n = len(b.forces)
    for there, here in ((a.forces[:n], b.forces), (a.object_displacement, b.object_displacement)):
        np.testing.assert_allclose(there, here, atol=1e-9 * abs(here).max())
    assert not a.forces[n:].any()
    assert a.contact_state[1:n] == b.contact_state[1:n]  # a prescribed one is not asked for its state


@pytest.mark.parametrize("row", [row for row in ROWS if row.kind], ids=[row.name for row in ROWS if row.kind])
def test_explain_says_on_where_it_is_on_and_off_where_it_is_not(row):
    title = row.name
    lines = {line.title: line for line in row.on().explain(row.faces).effects}
    assert lines[title].on
    if title not in ALWAYS:
        off = {line.title: line for line in row.absent().explain(row.faces).effects}[title]
        assert not off.on
        assert off.cost == 0
        assert off.why


@pytest.mark.parametrize("row", ROWS[len(ALWAYS) :], ids=NAMES[len(ALWAYS) :])
def test_an_effect_does_something_where_it_is_on(row):
    """Otherwise the comparisons above compare nothing."""
    on, absent = row.on().problem(row.faces), row.absent().problem(row.faces)
    same = on.M.shape == absent.M.shape and (on.M == absent.M).all() and (on.q == absent.q).all()
    if row.name == "geometric stiffness":  # it acts between solves
        g = row.on()
        same = np.array_equal(g.solve(row.faces).forces, hands().solve(row.faces).forces)
    assert not same


def test_every_entry_of_the_catalogue_has_a_row():
    assert set(NAMES) == {entry.title for entry in entries()}
