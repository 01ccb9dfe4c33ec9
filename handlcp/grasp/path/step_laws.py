"""The laws that all steps of a grasp share, as compiled code reads them, and what its effects add to a step."""

from __future__ import annotations

import numpy as np

from handlcp.check import Array
from handlcp.errors import Unsupported
from handlcp.grasp.assembly.build import build
from handlcp.grasp.assembly.contact_form import design, outward, stamped
from handlcp.grasp.effects.torque_saturation import TorqueSaturation
from handlcp.grasp.friction import Section
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.path.geometry import Look
from handlcp.grasp.path.look.linear_solve import Giving
from handlcp.grasp.path.look.numbers import Laws, Loads
from handlcp.grasp.path.look.one_look import Answer
from handlcp.grasp.path.step_grasp import StepGrasp
from handlcp.grasp.solve.compiled_solve import ScenePattern


class StepLaws:
    """Of one grasp and section. laws, limits (n,) of friction, pattern : as `one_look` reads them. given : how many
    limits give way. yields (nv, given) : how far they drive joints back [rad/m], at the first look. answer : the layout
    of an answer's row.
    """

    def __init__(self, grasp: StepGrasp, section: Section) -> None:
        self.grasp, spec = grasp, grasp.spec
        scene = build(spec)
        asked = stamped(spec.effects)
        if foreign := [e for e in asked if not e.only_limits]:
            names = ", ".join(type(e).__name__ for e in foreign)
            raise Unsupported(f"a path knows no unknowns but forces and limits that give way ({names})")
        soft, contacts, kind = scene.soft, spec.contacts, scene.kind
        scale = np.ones(scene.components) if scene.scale is None else scene.scale.copy()
        self.laws = Laws(
            np.array(soft, dtype=np.int64), scale,
            np.array([contacts[i].friction.pad_torsion for i in soft], dtype=float), scene.freedom.copy(),
            spec.mechanism is not None and bool(spec.flexibility.any()), 1.0 if grasp.sags else 0.0,
        )  # fmt: skip
        self.limits = scene.limits(section).copy()
        known = design(scene, section, asked)
        where, roles = known.layout, known.pattern
        self._extra = where.extra
        self.given = sum([g.count for g in where.extra])
        self._at = where.at[where.extra[0].name].start if where.extra else 0
        self.pattern = ScenePattern(
            kind.contact_components.copy(), kind.index.copy(), roles.role.copy(), roles.order.copy(),
            roles.blocks.copy(), section.faces, np.array(outward(scene, section)), True, kind.dof,
            (*where.forces, where.at["u"].start, where.size), len(soft),
        )  # fmt: skip
        self._none = Giving(np.zeros((0, scene.components)), np.zeros(0), 0, np.zeros(0))
        self._no_extra = np.zeros((0, 0))
        nv = 0 if spec.mechanism is None else len(spec.mechanism.names)
        self.yields = np.zeros((nv, 0))
        self.answer = Answer(spec.n, nv, scene.components, self.given, kind.dof)

    def added(self, look: Look, loads: Loads, gives: Array) -> tuple[Array, Giving, Loads]:
        """What effects add to a look: flexibility (c, c) in contact axes, empty for none; limits that give way; loads
        with their offsets. gives (given,) : from where those begin.
        """
        grasp = self.grasp
        if not grasp.general:
            return self._no_extra, self._none, loads
        scene = build(grasp.made(look, loads))
        scale = self.laws.scale
        E = scene.flexibility / np.outer(scale, scale)
        plain = build(grasp.plain(look, loads))
        extra = E - plain.flexibility / np.outer(scale, scale)
        moved = (scene.offset - plain.offset) / scale
        n = len(look.positions)
        base, spin = loads.base + moved[: 3 * n].reshape(n, 3), loads.spin.copy()
        spin[self.laws.soft] += moved[3 * n :]
        return extra, self._giving(scene, gives), loads._replace(base=base, spin=spin)

    def _giving(self, scene: Scene, gives: Array) -> Giving:
        rows, room, yields = list[Array](), list[Array](), list[Array]()
        for e in stamped(self.grasp.effects):
            for limit in e.present(scene):
                rows.append(limit.natural_rows)
                room.append(limit.room if limit.levers is None else limit.room / limit.levers)
                back = np.zeros((self.yields.shape[0], len(limit.room)))
                if isinstance(e, TorqueSaturation) and limit.levers is not None:
                    sign = 1.0 if limit.name == "s⁺" else -1.0
                    for c, j in enumerate(e.limited(scene)[2]):
                        back[j, c] = sign / limit.levers[c]
                yields.append(back)
        if not rows:
            return self._none
        self.yields = np.ascontiguousarray(np.hstack(yields))
        return Giving(np.ascontiguousarray(np.concatenate(rows)), np.concatenate(room), self._at, gives.copy())
