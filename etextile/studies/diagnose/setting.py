"""What a diagnosis starts from: case and measurements, checked against each other and put together."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from etextile import foreign_code
from etextile.diagnose.data.measured import Measurements
from etextile.diagnose.predict.parameters import PRIOR_E, BaseParameters, combine, reference_strain
from etextile.diagnose.predict.run_tables import Candidate, Laws
from etextile.diagnose.predict.simulate import TABLE, VERDICT, Law
from etextile.diagnose.setting import Setting
from etextile.errors import BadInput, Problem, nearest
from etextile.identify.result import FAMILY_OF, IdentifiedFamily
from etextile.kept import code_digest
from etextile.studies.diagnose.channels import of_channels
from etextile.studies.diagnose.restrictions import restrictions, unused_tests
from etextile.studies.diagnose.simulator import CaseSimulator
from etextile.types import Array
from loadcases.build_bent import bent_piece
from loadcases.conflicts_worn import EFFECTS as ON_WORN
from loadcases.fabric import Fabric, Family, load_fabric
from loadcases.reader import LoadedCase, case_sha256
from loadcases.schema import Case


SOLVER = (
    *(f"etextile/{name}" for name in ("lattice", "laws", "mechanics", "motion", "contact", "effects", "solve")),
    "etextile/diagnose/predict",
    *(
        f"loadcases/{name}.py"
        for name in ("build", "build_bent", "build_body", "build_worn", "fabric", "compression", "arcs")
    ),
)
"""Parts of the package that the result of a simulator run depends on."""
POSITIONS = (
    "punch_force",
    "clamp_force",
    "pressure_height",
    "free_edge",
    "strain_field",
    "clamp_line",
    "displacement_field",
    "moment_curvature",
    "joint_moment",
    "mark_slip",
)
"""Channels that a simulation predicts over the load of its case."""


@dataclass(frozen=True)
class DiagnosisTask:
    """A case with its measurements, ready to be compared or diagnosed.

    `fabric`: identified from the tensile channel, None when the case's own is used. `restrictions`: what was kept out
    of the choice of effects and channels, one sentence each.
    """

    loaded: LoadedCase
    measured: Measurements
    setting: Setting
    simulator: CaseSimulator
    fabric: Fabric | None
    restrictions: tuple[str, ...]


def assemble(
    loaded: LoadedCase, measured: Measurements, *, effects: Sequence[Path] = (), among: Sequence[str] = (),
    name_effects: bool = True, own_fabric: bool = False, seed: int = 0,
) -> DiagnosisTask:  # fmt: skip
    """Return the task; raises BadInput for a case or a folder that cannot be diagnosed.

    `effects`: Python files with effects of the user's own; `among`: names to choose from, all when empty;
    `name_effects` False: no candidates (compare); `own_fabric`: keep the case's fabric in spite of a tensile channel.
    """
    for file in effects:
        foreign_code.allow_file(file)
    check(loaded.case, measured, (*POSITIONS, *(() if name_effects else ("wires",))))
    case = loaded.case
    named = load_fabric(case.fabric.set)
    fabric, families = (None, {}) if own_fabric or not measured.tensile else _identified(case, measured)
    files = (*effects, *_files_of(case))
    every = [searched_in(case, item) for item in _candidates(files)] if name_effects else []
    bent = bool(measured.moment_curvature)
    candidates, unusable = _usable(case, _chosen(every, among) if name_effects else [], bent=bent)
    limits = restrictions(every, among, unusable, own_fabric=own_fabric, tensile=bool(measured.tensile))
    limits += () if name_effects else unused_tests(measured)
    setting = Setting(
        measured, _base(named, families), _laws(named), float(case.fabric.coarsening), tuple(candidates), seed
    )
    return DiagnosisTask(loaded, measured, setting, simulator_of(case, candidates), fabric, limits)


def simulator_of(case: Case, candidates: Sequence[Candidate]) -> CaseSimulator:
    """Return the simulator of a case, with the fingerprint that its runs with these effects are kept under."""
    files = [Path(item.file) for item in candidates if item.file]
    return CaseSimulator(case, _fingerprint(case, (*files, *_files_of(case))))


def check(case: Case, measured: Measurements, channels: Sequence[str]) -> None:
    """Raise BadInput with all that keeps case and measurements apart; one of the channels has to be there."""
    problems = [*_of_case(case, measured), *of_channels(case, measured)]
    if not any(getattr(measured, name) for name in channels):
        message = f"no channel of the test to go by, give one of {', '.join(channels)}"
        problems.append(Problem(message, file=measured.folder))
    if problems:
        raise BadInput(problems)


def _of_case(case: Case, measured: Measurements) -> Iterator[Problem]:
    if case.motion.target == "weight" and not measured.moment_curvature:
        message = "a piece that hangs by its weight cannot be diagnosed; calibrate and compare take it"
        yield Problem(message, key="motion.target")
    elif measured.punch_force and case.body is None:
        message = "the force of a punch needs a body, that of a pulled clamp is clamp_force"
        yield Problem(message, key="motion.target")


def _identified(case: Case, measured: Measurements) -> tuple[Fabric, dict[str, IdentifiedFamily]]:
    """Return the fabric identified from the tensile channel; the weave is that of the case's fabric."""
    from etextile.studies.identify.identify import identify_curves

    found = identify_curves(measured.tensile, title=measured.title, fabric=case.fabric.set)
    return found.fabric, dict(found.identified.families)


def _base(named: Fabric, families: Mapping[str, IdentifiedFamily]) -> BaseParameters:
    names = tuple(FAMILY_OF.values())
    members: dict[str, Family] = {name: getattr(named, name) for name in names}
    return combine(
        {name: _law(member) for name, member in members.items()},
        {name: log_covariance(member) for name, member in members.items()},
        {name: member.strain_range for name, member in members.items()},
        families,
    )


def _laws(fabric: Fabric) -> Laws:
    return _law(fabric.warp), _law(fabric.weft), _law(fabric.diagonal)


def _law(family: Family) -> Law:
    return (family.E.value, family.sigma_y0.value, family.H.value, family.n.value)


def log_covariance(family: Family) -> Array | None:
    """Return the covariance (3, 3) of (ln E, ln s, n) that a fabric file states, None without one.

    s = H p^n is the stress at the reference strain p; a modulus that was not identified gets the prior's deviation.
    """
    if family.covariance is None:
        return None
    stated = np.asarray(family.covariance.matrix, dtype=float)
    scale = {"E": 1.0 / family.E.value, "H": 1.0 / family.H.value}
    rows = {"E": 0, "H": 1, "n": 2}
    jacobian = np.zeros((3, len(stated)))
    for column, name in enumerate(family.covariance.parameters):
        if name in rows:
            jacobian[rows[name], column] = scale.get(name, 1.0)
        if name == "n":
            jacobian[1, column] = np.log(reference_strain(family.strain_range[1]))
    found = jacobian @ stated @ jacobian.T
    if "E" not in family.covariance.parameters:
        found[0, 0] += PRIOR_E**2
    return np.asarray(found)


def _files_of(case: Case) -> tuple[Path, ...]:
    """Return the files of effects of the user's own that the case names."""
    return tuple(Path(item.parameters["file"]) for item in case.effects if "file" in item.parameters)


def _candidates(files: Sequence[Path]) -> list[Candidate]:
    """Return the library, effects of installed packages and those of the files; a file's effect replaces a namesake."""
    from etextile.effects.registry import EFFECTS
    from etextile.effects.user import all_from_file, from_entry_points

    found = {name: Candidate(kind.card) for name, kind in {**from_entry_points(), **EFFECTS}.items()}
    for file in files:
        found |= {name: Candidate(kind.card, str(file)) for name, kind in all_from_file(file).items()}
    return list(found.values())


def searched_in(case: Case, candidate: Candidate) -> Candidate:
    """Return a candidate with the parameters in front that are searched in a case.

    Where yarns run at an angle to the piece both families end at free edges, so some mechanisms show in another number
    and form there; elsewhere a choice keeps its default.
    """
    card = candidate.card
    known = {item.name: item for item in card.parameters}
    if case.fabric.warp_angle % 90.0:
        order = (*card.off_axis, *(name for name in known if name not in card.off_axis))
        parameters = tuple(known[name] for name in order)
    else:
        parameters = tuple(
            replace(item, choice=False, neutral=item.default) if item.choice else item for item in card.parameters
        )
    return replace(candidate, card=replace(card, parameters=parameters))


def _chosen(candidates: list[Candidate], among: Sequence[str]) -> list[Candidate]:
    """Return the candidates of these names; raises BadInput for a name that none has."""
    known = {item.card.id: item for item in candidates}
    problems = [
        Problem(f"unknown effect (got {name!r}), known are {', '.join(known)}{nearest(name, known)}", key="--among")
        for name in among
        if name not in known
    ]
    if problems:
        raise BadInput(problems)
    return [known[name] for name in dict.fromkeys(among)] or candidates


def _usable(case: Case, candidates: Sequence[Candidate], *, bent: bool) -> tuple[list[Candidate], tuple[str, ...]]:
    """Return the candidates that make sense in the case (`bent`: in pure bending), and why the others do not.

    Effects of the case itself that play no part in bending are told too.
    """
    fabric = case.fabric
    cut = fabric.outline is not None or fabric.warp_angle != 0.0
    coarse = fabric if cut else fabric.model_copy(update={"coarsening": 4.0 * fabric.coarsening})
    small = case.model_copy(update={"wires": None, "fabric": coarse})
    refusal = _refusal_in(small.model_copy(update={"effects": ()}), bent=bent)
    kept, left_out = [], []
    for item in candidates:
        flat_only = case.worn and not item.file and item.card.id not in ON_WORN
        why = "it is written for a flat piece" if flat_only else refusal(item)
        if why:
            left_out.append(f"{item.card.id} is left out{' of a bending test' if bent else ''}: {why}")
        else:
            kept.append(item)
    own = bent_piece(small).told(item.id for item in case.effects) if bent else ()
    return kept, (*left_out, *own)


def _refusal_in(case: Case, *, bent: bool) -> Callable[[Candidate], str]:
    """Return what says why an effect of its card's size cannot act in a case without effects, '' when it can."""
    from etextile.effects.registry import apply_effects, build_effect
    from loadcases.build import build

    model = build(case).model

    def why(item: Candidate) -> str:
        given = {**item.card.example.parameters, **({"file": item.file} if item.file else {})}
        try:
            effect = build_effect(item.card.id, given)
            if bent:
                return bent_piece(case, [effect]).left_out.get(item.card.id, "")
            apply_effects(model, [effect])
        except BadInput as error:
            return error.problems[0].message
        return ""

    return why


def _fingerprint(case: Case, files: Sequence[Path]) -> str:
    """Return what tells the simulator runs of one case from those of another: wires, laws and travel do not matter."""
    bare = case.model_copy(
        update={
            "title": "-",
            "description": "",
            "wires": None,
            "motion": case.motion.model_copy(update=case.motion.straight(1.0, 1)),
            "failure": type(case.failure)(),
            "outputs": type(case.outputs)(),
        }
    )
    parts = [_code(), str((TABLE, VERDICT)), case_sha256(bare)]
    parts += [hashlib.sha256(Path(file).read_bytes()).hexdigest() for file in files]
    return hashlib.sha256(" ".join(parts).encode()).hexdigest()


def _code() -> str:
    """Return a hash of the source files behind a run, so that no run of another version is taken for one of this."""
    return code_digest(Path(__file__).parents[3], SOLVER)
