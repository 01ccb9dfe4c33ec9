"""Before the first clock runs, where one does: with HANDLCP_HARD=1, or with -m bench."""

import pytest

import handlcp as hl


@pytest.fixture(autouse=True, scope="session")
def _compiled():
    """Kernels compile before the clock runs."""
    contacts = [hl.Contact((-0.01, 0, 0), (1, 0, 0)), hl.Contact((0.01, 0, 0), (-1, 0, 0))]
    for squeeze in (1e-3, 1e-6):
        grasp = hl.Grasp(contacts, (0, 0, -1, 0, 0, 0), flexibility=1e-4, preload=squeeze)
        grasp.replace(preload=1e-3, effects=[hl.TotalForceBound(50.0)]).solve(4)
        for faces in (4, "cone"):
            grasp.solve(faces, throw=False)
        hl.solve_lcp(grasp.problem(4), throw=False)
    hl.example_hand("two_finger").at([0.0] * 4).grasp(contacts).solve(throw=False)
    for solver in (hl.NSNGRK(), hl.NSNGRK(polish=False, stride=1), hl.Lemke(), hl.SemismoothNewton(), hl.Auto()):
        hl.solve_lcp(hl.LCP([[1, 3, 3], [-2, 0, -3], [-3, 1, -3]], [2, 2, -2]), solver, throw=False)
