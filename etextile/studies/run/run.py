"""From a case to a verdict per wire: simulate, judge, report, draw. Everything the run verb and the Python API do."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np

from etextile import foreign_code
from etextile.files import named, owned, write_whole
from etextile.lattice.weave import DIAGONAL, WARP, WEFT
from etextile.results.reader import Results
from etextile.studies.cases import AnyCase, loaded_case
from etextile.studies.run.coupon import coupon_block, is_coupon
from etextile.studies.run.drawing import draw_maps, live_scenes
from etextile.studies.run.extrapolation import add_extrapolation
from etextile.studies.run.lattice_error import LatticeError, estimate
from etextile.studies.run.lattice_limit import Level, extrapolate_case, limit_block
from etextile.studies.run.limits import energy_error, limits_of, little_work
from etextile.studies.run.load import deflection, is_load, load_block, load_note
from etextile.studies.run.outcome import Run
from etextile.studies.run.pressing import add_contact
from etextile.studies.run.rupture import rupture_block, rupture_note
from etextile.studies.run.settling import Settling, cycles_block, settling_of, work_lost
from etextile.studies.run.simulate import PACKAGES, Simulation, Watcher, simulate
from etextile.studies.run.worn import bend_note, worn_curves, worn_facts, worn_notes
from etextile.types import Array
from loadcases.build import Built
from loadcases.build_paths import drawn_wires
from loadcases.build_wires import constructions_of, portion_of
from loadcases.judging import judge_for, life_spec, make_notes, marked_strain
from loadcases.lattice_error import known_error
from loadcases.nets import circuits_of, numbered_nets, ohm_per_mm
from loadcases.patch import Patch, Strains, beyond, misfit, read_patch
from loadcases.reader import LoadedCase, as_loaded
from loadcases.schema import Case
from wires.damage import FailureResult
from wires.electrical import electrical_report
from wires.facts import CaseFacts, RunCurves, SolverFacts, WireFacts
from wires.judge import Judge
from wires.life import Life, life_of
from wires.part_rows import part_rows
from wires.report import build_report
from wires.report_files import plain, write_force_displacement_csv, write_report_json, write_wires_csv
from wires.trust import TrustCheck


def run(
    case: AnyCase,
    folder: str | Path,
    *,
    resume: bool = False,
    force: bool = False,
    patch: str | Path | None = None,
    estimate_error: bool = False,
    extrapolate: bool = False,
    allow_code: bool = False,
    seed: int = 0,
    watch: Watcher | None = None,
    tell: Callable[[str], None] | None = None,
    judged: Callable[[Run], None] | None = None,
) -> Run:
    """Simulate a case, judge its wires, and write result file, report, tables, page and maps into `folder`.

    `resume`: go on from the last converged increment there; `force`: overwrite another case's results; `patch`: file
    with further effects; `estimate_error`: repeat on two other lattices; `extrapolate`: on two finer
    ones, and report the limit; `allow_code`: run the Python files that case and patch name. `watch` hears of every
    increment, `tell` of what is to be known before the first one, `judged` of the run with its tables, before maps and
    page are drawn.
    Raises BadInput before anything is computed or written.
    """
    named(folder)
    with foreign_code.trusting(allow_code):
        loaded = loaded_case(case)
    with foreign_code.trusting(allow_code), owned(Path(folder)), loaded.locating():
        return _run(
            loaded, Path(folder), resume=resume, force=force, patch=None if patch is None else Path(patch),
            estimate_error=estimate_error, extrapolate=extrapolate, seed=seed, watch=watch, tell=tell, judged=judged,
        )  # fmt: skip


def _run(
    loaded: LoadedCase, folder: Path, *, resume: bool, force: bool, patch: Path | None, estimate_error: bool,
    extrapolate: bool, seed: int, watch: Watcher | None, tell: Callable[[str], None] | None,
    judged: Callable[[Run], None] | None,
) -> Run:  # fmt: skip
    """Do what `run` says."""
    remarks: tuple[str, ...] = ()
    added = None if patch is None else read_patch(patch)
    if patch is not None and added is not None:
        loaded, remarks = _patched(loaded, added, patch, tell)
    judge = judge_for(loaded.case)
    done = simulate(loaded, folder, resume=resume, force=force, seed=seed, watch=watch)
    damage = judge.verdict(done.results.wires)
    lattice = _lattice_error(done, loaded.case) if estimate_error and not done.trouble else None
    report = made_report(loaded, done, judge, damage=damage, lattice=lattice, remarks=remarks)
    if added is not None:
        report["notes"] += _stretched(added, report)
    if extrapolate and not done.trouble:
        report["limit"] = plain(_limit(done, loaded.case, judge, watch))
    write_tables(report, folder)
    found = Run(3 if done.trouble else 0 if report["trust"]["ok"] else 4, folder, report, done.results)
    if judged is not None:
        judged(found)
    maps, missing = draw_maps(
        done.results,
        folder / "maps",
        loaded.case.outputs.maps,
        damage=damage,
        onset=marked_strain(loaded.case, judge),
        title=loaded.case.title,
        provisional=report["verdict"]["withheld"],
    )
    live = live_scenes(
        done.results, report, damage=damage, onset=marked_strain(loaded.case, judge), title=loaded.case.title
    )
    write_page(report, folder, maps, live=live)
    return replace(found, remarks=(f"maps left out: {missing}",)) if missing else found


def made_report(
    loaded: LoadedCase, done: Simulation, judge: Judge, *, damage: FailureResult | None,
    lattice: LatticeError | None = None, remarks: tuple[str, ...] = (),
) -> dict[str, Any]:  # fmt: skip
    """Return the report of a simulation as JSON types: what became of the wires, and how far that can be trusted."""
    laws, checks = limits_of(done, loaded.case, judge, damage=damage, lattice=lattice)
    report = _report(loaded, done, damage, checks, remarks)
    report["results_sha256"] = done.results.fingerprint
    add_extrapolation(report, laws)
    add_contact(report, done.results, done.built)
    known = known_error(loaded.case, loaded.path)
    if known is not None:
        report["lattice_estimate"] = plain(known.as_dict())
        report["notes"].append(known.sentence)
    if lattice is not None:
        report["lattice_error"] = plain(lattice.as_dict())
    report |= plain(load_block(done.results, done.built))
    report["notes"] += [note for note in [load_note(report)] if note is not None]
    rupture = rupture_block(report, done.built)
    if rupture is not None:
        report["rupture"] = plain(rupture)
        report["notes"] += [note for note in [rupture_note(rupture)] if note is not None]
    if is_coupon(loaded.case):
        report["coupon"] = plain(coupon_block(done.results, done.built))
    return report


def _lattice_error(done: Simulation, case: Case) -> LatticeError:
    """Repeat the run on two other lattices and compare end force and wire strains."""
    history, greatest = done.results.wires, np.zeros(0)
    if history is not None:
        greatest = np.zeros(history.layout.n_wires)
        np.maximum.at(greatest, history.layout.loop_wire, history.max_span_strain)
    return estimate(case, force=float(done.results.curves.punch_force_N[-1]), wires=greatest)


def _limit(done: Simulation, case: Case, judge: Judge, watch: Watcher | None) -> dict[str, Any]:
    """Return the block `limit` of the report: where the run goes on ever finer lattices."""
    history, lattice, force = done.results.wires, done.built.model.lattice, done.results.curves.punch_force_N
    nothing = np.zeros((len(force), 0))
    size = math.sqrt(lattice.coarsening[0] * lattice.coarsening[1])
    span, wire = (nothing, nothing) if history is None else (history.span_strain[1:], history.wire_strain[1:])
    own = Level(lattice.cells, size, np.asarray(force), span, wire)
    found = extrapolate_case(case, own, None if history is None else judge, watch=watch or (lambda _: None))
    return limit_block(found, done.results.displacement_mm, None if history is None else history.layout)


def curves_of(results: Results, built: Built) -> RunCurves:
    """Return the curves of the report over the output steps."""
    if built.worn is not None:
        return worn_curves(results, built)
    peaks = {family: np.zeros(results.steps) for family in (WARP, WEFT, DIAGONAL)}
    draw_in = np.zeros(results.steps)
    for step in range(results.steps):
        strain = results.array("strain", step)
        for family, peak in peaks.items():
            peak[step] = float(strain[results.family == family].max(initial=0.0))
        draw_in[step] = _draw_in(results.points(step), built)
    return RunCurves(
        displacement_mm=deflection(results, built) if is_load(built) else results.displacement_mm,
        force_N=results.curves.punch_force_N,
        warp_max=peaks[WARP],
        weft_max=peaks[WEFT],
        diagonal_max=peaks[DIAGONAL],
        draw_in_mm=draw_in,
    )


def _draw_in(points: Array, built: Built) -> float:
    """Return the largest inward motion of a free edge, mm."""
    lattice = built.model.lattice
    moved = points[: len(lattice.points)] - lattice.points
    inward = {"x_min": (0, 1.0), "x_max": (0, -1.0), "y_min": (1, 1.0), "y_max": (1, -1.0)}
    free = [name for name in inward if name not in built.case.supports.clamped]
    motions = [inward[name][1] * moved[lattice.edges[name], inward[name][0]] for name in free]
    return max((float(motion.max(initial=0.0)) for motion in motions), default=0.0)


def _report(
    loaded: LoadedCase,
    done: Simulation,
    damage: FailureResult | None,
    checks: tuple[TrustCheck, ...],
    remarks: tuple[str, ...],
) -> dict[str, Any]:
    case, built = loaded.case, done.built
    notes = [*remarks, *built.notes]
    if done.trouble:
        notes.append(done.trouble)
    if built.share is not None:
        notes.append(
            f"wires carry {100 * built.share.largest:.1f} % of the coupon's warp stress at most, "
            f"{100 * built.share.at_end:.1f} % at the end of the identified range; the warp law is lowered by that "
            f"(the coupon's curve is met within {100 * built.share.misfit:.1f} % of its peak and, from 1 % strain on, "
            f"within {100 * built.share.relative_misfit:.1f} % of its stress)"
        )
    notes += [note for note in [little_work(done)] if note]
    notes += make_notes(case)
    if damage is not None and not damage.layout.symmetric:
        notes.append("the symmetry planes mirror wires or loops that the whole specimen does not have there")
    settling = settling_of(done.results, built.model.travel, case.motion.settled)
    cycles = cycles_block(settling, done.results.steps)
    if cycles is not None:
        cycles |= work_lost(done.results, settling, built.model.force_factor)
        notes.append(cycles["sentence"])
    if case.motion.path_from is not None:
        notes.append(f"motion: {case.motion.path_from}")
    worn = None if built.worn is None else worn_facts(done.results, built)
    if worn is not None:
        notes += [*worn_notes(worn).values(), *filter(None, [bend_note(done.results, built)])]
    electrical = _electrical(done.results, case, damage)
    report = build_report(
        case=_case_facts(loaded),
        curves=curves_of(done.results, built),
        solver=_solver_facts(done),
        checks=checks,
        damage=damage,
        wires=_wire_facts(case, built),
        versions={name: metadata.version(name) for name in PACKAGES},
        notes=notes,
        electrical=electrical,
        parts=_part_rows(done.results, case, electrical),
        worn=worn,
        life=_life(done.results, case, built, damage, settling),
    )
    return report if cycles is None else {**report, "cycles": plain(cycles)}


def _life(results: Results, case: Case, built: Built, damage: FailureResult | None, settling: Settling) -> Life | None:
    """Return the lives of the loops over the whole path, also where it ended because all had settled; None without."""
    if damage is None or results.wires is None:
        return None
    left = built.model.travel[results.steps :] if settling.over else np.zeros(0)
    return life_of(results.wires, damage, life_spec(case), left=left)


def _part_rows(results: Results, case: Case, electrical: dict[str, Any] | None) -> list[dict[str, Any]]:
    """Return the parts of drawn wires for the report."""
    if case.wires is None or not case.wires.drawn or results.wires is None:
        return []
    drawn = drawn_wires(case)
    return part_rows(
        drawn.parts,
        drawn.terminals,
        results.wires,
        (electrical or {}).get("nets", []),
        images=drawn.images,
        portion=portion_of(case),
    )


def _electrical(results: Results, case: Case, damage: FailureResult | None) -> dict[str, Any] | None:
    """Return resistance and nets for the report, None without wires."""
    if damage is None or results.wires is None or case.wires is None:
        return None
    layout = results.wires.layout
    return electrical_report(
        results.wires,
        damage,
        crimp=np.array([made.crimp for made in constructions_of(case, layout)]),
        nets=numbered_nets(case),
        circuits=circuits_of(case),
        ohm_per_mm=ohm_per_mm(case, layout),
    )


def _case_facts(loaded: LoadedCase) -> CaseFacts:
    case = loaded.case
    return CaseFacts(
        title=case.title,
        sha256=loaded.sha256,
        name=loaded.path.stem if loaded.path else "",
        description=case.description,
        fabric=case.fabric.set,
        coarsening=case.fabric.coarsening,
        size_mm=case.pattern,
        portion=case.fabric.portion,
        body="" if case.body is None else case.body.type,
        friction=case.contact.friction,
        effects=tuple(effect.id for effect in case.effects),
    )


def _solver_facts(done: Simulation) -> SolverFacts:
    rows, model = done.results.increments, done.built.model
    return SolverFacts(
        nodes=len(model.lattice.points),
        trusses=len(model.lattice.trusses),
        steps=done.results.steps,
        linear_solves=int(rows.linear_solves.sum()),
        cut_backs=int(rows.cut_backs.sum()),
        all_converged=bool(rows.converged.all()) and not done.trouble,
        wall_s=done.wall_s,
        solve_s=float(rows.wall_s.sum()),
        max_penetration_mm=float(rows.max_penetration_mm.max(initial=0.0)),
        energy_error=energy_error(done),
        linear=done.linear,
    )


def _wire_facts(case: Case, built: Built) -> WireFacts | None:
    if case.wires is None:
        return None
    bond = case.wires.bond if isinstance(case.wires.bond, str) else "slipping"
    return WireFacts(
        material=case.wires.material,
        filaments=case.wires.filaments,
        filament_diameter_mm=case.wires.filament_diameter,
        stiffness_share=0.0 if built.share is None else built.share.largest,
        bond=bond,
        crimp=case.wires.crimp,
    )


def write_tables(report: dict[str, Any], folder: Path) -> None:
    """Write report.json and the tables; the folder's owner was checked before."""
    write_report_json(report, folder / "report.json", overwrite=True)
    curves = "moment_angle.csv" if "joint" in report else "force_displacement.csv"
    write_force_displacement_csv(report, folder / curves, overwrite=True)
    write_wires_csv(report, folder / "wires.csv", overwrite=True)


def write_page(report: dict[str, Any], folder: Path, maps: tuple[Path, ...], *, live: str | None = None) -> None:
    """Write the self-contained page."""
    from viz.html import render_report_html

    write_whole(folder / "report.html", render_report_html(report, maps=maps, live=live))


def _patched(
    loaded: LoadedCase, patch: Patch, path: Path, tell: Callable[[str], None] | None
) -> tuple[LoadedCase, tuple[str, ...]]:
    """Return the case with the effects of a patch file behind its own, and remarks for the report.

    That a patch was made for another case is told at once, before anything is computed.
    """
    case = loaded.case.model_copy(update={"effects": (*loaded.case.effects, *patch.effects)})
    patched = replace(as_loaded(case), source_text=loaded.source_text, path=loaded.path, overrides=loaded.overrides)
    notes = [f"effects of {path.name} added: {', '.join(effect.id for effect in patch.effects) or 'none'}"]
    other = misfit(patch, loaded, path)
    if other is not None:
        if tell is not None:
            tell(f"{path}: {other.message}")
        notes.append(other.message)
    if patch.base is None:
        notes.append("the patch does not say which case it was made for")
    if patch.valid is not None and loaded.case.motion.reach > patch.valid.displacement[1]:
        notes.append(f"the patch was found up to {patch.valid.displacement[1]:g} mm; beyond that it extrapolates")
    return patched, tuple(notes)


def _stretched(patch: Patch, report: dict[str, Any]) -> list[str]:
    """Return a remark when a run goes beyond the strains that its patch was fitted to."""
    reached = {name: max(report["strain"][f"{name}_max"], default=0.0) for name in Strains.model_fields}
    note = beyond(patch, reached)
    return [] if note is None else [note]
