"""The simulator behind a diagnosis: a case, run with other laws, effects and lattices than it was written with.

Also the way from a case and a folder of measurements to what the workflow needs (`setting_of`, `runner_of`).
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from etextile.app.identify import named_laws, weave_of
from etextile.diagnose.library import Candidate
from etextile.diagnose.measured import Measurements
from etextile.diagnose.observe import Record
from etextile.diagnose.parameters import FAMILIES, BaseParameters, combine
from etextile.diagnose.simulate import EffectSpec, Law, Request, Runner, run_model
from etextile.diagnose.workflow import Setting
from etextile.effects.registry import EFFECTS, effect_class
from etextile.errors import BadInput
from etextile.identify.result import identify_fabric
from loadcases.fabric import Fabric, Family, load_fabric
from loadcases.reader import dump_case
from loadcases.schema import Case


if TYPE_CHECKING:
    from etextile.mechanics.model import Model
    from etextile.types import Array

PACKAGES = ("lattice", "laws", "mechanics", "contact", "effects", "solve")
"""Parts of the package on which the result of a run depends."""
PARAMETERS = ("E", "H", "n")


@dataclass(frozen=True)
class CaseSimulator:
    """Runs requests on a case without wires: the coupons contained them, so the fabric laws carry their share."""

    case: Case
    fingerprint: str

    def __call__(self, request: Request) -> Record:
        """Return the record of one run; effects of the request act together with the case's own."""
        from etextile.effects.registry import apply_effects, build_effect
        from loadcases.build import build, settings

        case = _reduced(self.case, request)
        own = [build_effect(item.id, item.parameters) for item in self.case.effects]
        model = _with_laws(build(case).model, request.laws)
        return run_model(apply_effects(model, [*own, *map(_built, request.effects)]), settings(case))


def _built(item: EffectSpec):  # type: ignore[no-untyped-def]
    from etextile.effects.registry import build_effect

    return build_effect(item.id, {**dict(item.parameters), **({"file": item.file} if item.file else {})})


def _reduced(case: Case, request: Request) -> Case:
    """Return the case of a request without wires and effects."""
    motion = {"total": request.total, "steps": request.steps, "path": None}
    changes = {
        "wires": None,
        "fabric": case.fabric.model_copy(update={"coarsening": request.coarsening}),
        "motion": case.motion.model_copy(update=motion),
        "effects": (),
    }
    return case.model_copy(update=changes)


def _with_laws(model: Model, laws: tuple[Law, Law, Law]) -> Model:
    """Return the model with other numbers in the laws of warp, weft and diagonals."""
    block = model.truss_blocks[0]
    changed = tuple(
        replace(law, E=E, sigma_y0=sigma_y0, H=H, n=n)
        for law, (E, sigma_y0, H, n) in zip(block.laws, laws, strict=True)
    )
    other = replace(block, laws=changed)
    return replace(model, contributions=tuple(other if part is block else part for part in model.contributions))


def simulator_of(case: Case) -> CaseSimulator:
    """Return the simulator of a case; raises BadInput for a case that no punch test can be compared with."""
    if case.motion.target != "body":
        raise BadInput.of("a diagnosis compares punch tests, the case moves no body", key="motion.target")
    if case.fabric.warp_angle != 0.0:
        raise BadInput.of("a diagnosis needs the warp along x", key="fabric.warp_angle")
    return CaseSimulator(case, fingerprint(case))


def fingerprint(case: Case) -> str:
    """Return a hash of everything a run depends on beside its request: case, fabric geometry and the code."""
    request = Request(((0.0, 0.0, 0.0, 0.0),) * 3, (), 1.0, 1.0, 1)
    changes = {"title": "case", "description": "", "effects": case.effects, "scatter": type(case.scatter)()}
    bare = _reduced(case, request).model_copy(update=changes)
    fabric = load_fabric(case.fabric.set)
    parts = [dump_case(bare), repr((fabric.cell, fabric.thickness, fabric.truss_area)), _code()]
    for item in case.effects:
        if item.parameters.get("file"):
            parts.append(Path(str(item.parameters["file"])).read_text(encoding="utf-8"))
    return hashlib.sha256("\n".join(parts).encode()).hexdigest()


def _code() -> str:
    """Return a hash of the source files behind a run."""
    root = Path(__file__).parents[1]
    files = sorted(path for name in PACKAGES for path in (root / name).glob("*.py"))
    return hashlib.sha256(b"".join(path.read_bytes() for path in files)).hexdigest()


def setting_of(
    case: Case, measured: Measurements, *, effects: Sequence[str] = (), files: Sequence[str] = (), seed: int = 0
) -> Setting:
    """Return what a diagnosis starts from.

    `effects`: names to choose from the library (all when empty); `files`: Python files of a user's own effects, as
    'file' or 'file:name'. Raises BadInput when coupons cannot be identified.
    """
    fabric = load_fabric(case.fabric.set)
    laws = {name: _law_of(getattr(fabric, name)) for name in FAMILIES}
    identified = {}
    if measured.tensile:
        named = named_laws(fabric, Path(case.fabric.set).stem)
        identified = identify_fabric(measured.tensile, weave_of(fabric), named=named).families
    base = combine(
        laws, {name: _covariance(getattr(fabric, name)) for name in FAMILIES},
        {name: tuple(getattr(fabric, name).strain_range) for name in FAMILIES}, identified,
    )  # fmt: skip
    own = {item.id for item in case.effects}
    candidates = [Candidate(EFFECTS[name].card) for name in (effects or EFFECTS) if name not in own]
    for text in files:
        path, _, name = text.partition(":")
        candidates.append(Candidate(effect_class(name or Path(path).stem, path).card, path))
    case_laws = (laws["warp"], laws["weft"], laws["diagonal"])
    return Setting(measured, base, case_laws, case.fabric.coarsening, tuple(candidates), seed)


def _law_of(family: Family) -> Law:
    return (family.E.value, family.sigma_y0.value, family.H.value, family.n.value)


def _covariance(family: Family) -> Array | None:
    """Return the covariance (3, 3) of (ln E, ln s, n) that a fabric file states, None when it states none."""
    from etextile.diagnose.parameters import PRIOR_E, reference_strain

    if family.covariance is None:
        return None
    stated = np.array(family.covariance.matrix, dtype=float)
    full = np.zeros((3, 3))
    full[0, 0] = (PRIOR_E * family.E.value) ** 2
    rows = [PARAMETERS.index(name) for name in family.covariance.parameters if name in PARAMETERS]
    kept = [i for i, name in enumerate(family.covariance.parameters) if name in PARAMETERS]
    full[np.ix_(rows, rows)] = stated[np.ix_(kept, kept)]
    scale = np.array([1.0 / family.E.value, 1.0 / family.H.value, 1.0])
    turn = np.eye(3)
    turn[1, 2] = np.log(reference_strain(family.strain_range[1]))
    return np.asarray(turn @ (scale[:, None] * full * scale[None, :]) @ turn.T)


def runner_of(
    simulator: CaseSimulator, *, cache: Path | None, workers: int = 1, watch: Callable[[int, int], None] | None = None
) -> Runner:
    """Return the runner of a case's simulator; `cache`: folder that keeps the runs."""
    return Runner(simulator, cache, workers, watch)


def stated_fabric(fabric: Fabric, base: BaseParameters) -> Fabric:
    """Return the fabric with the laws of the base parameters, for the ordinary run that proves a patch."""
    changes = {}
    for name, (E, sigma_y0, H, n) in zip(FAMILIES, base.laws, strict=True):
        family: Family = getattr(fabric, name)
        numbers = {"E": E, "sigma_y0": sigma_y0, "H": H, "n": n}
        updates = {key: getattr(family, key).model_copy(update={"value": value}) for key, value in numbers.items()}
        changes[name] = family.model_copy(update=updates)
    return fabric.model_copy(update=changes)
