"""Work of ``tablegen simulate``."""

import json
import math
from pathlib import Path

import click
import numpy as np

from sampler.errors import InputError
from sampler.files.atomic import atomic_output, write_text
from sampler.files.locate import find_file
from tablegen.accuracy.streaming_statistics import simulate_statistics, statistics_of
from tablegen.accuracy.verdict import DONE
from tablegen.config import load_config
from tablegen.particles.mesh import read_mesh
from tablegen.particles.population import Population
from tablegen.simulate import Simulation, make_condition, simulate_condition


def run(
    pair: str,
    shape: str | None,
    particle: Path | None,
    alpha: float,
    speed: float,
    count: int,
    seed: int,
    output: Path | None,
    statistics_file: Path | None,
    aspect: tuple[float, float] | None,
    spin: tuple[float, float, float],
    threads: int | None,
    progress: bool,
) -> int:
    """Run ``tablegen simulate``; parameters are the options of `tablegen.commands.simulate`."""
    if output is None and statistics_file is None:
        raise InputError("Missing option '--output' or '--statistics', allowed: one or both")
    if output == statistics_file:
        raise InputError(f"--statistics: got {output}, allowed: another file than --output")
    config = load_config(find_file("--pair", pair, ".toml"))
    population = _chosen_particles(config.population, shape, particle, aspect)
    condition = make_condition(
        math.radians(alpha), speed, spin, config.model.contact_resolution, config.model.tolerance
    )
    if note := config.pair.extrapolation(speed):
        click.echo(f"tablegen: note: {note}", err=True)
    task = config.pair, population, condition, count
    if output is None:
        statistics = simulate_statistics(*task, seed=seed, threads=threads, progress=progress)
    else:
        result = simulate_condition(*task, seed=seed, threads=threads, progress=progress)
        statistics = statistics_of(result)
        _write_rebounds(output, result)
    if statistics_file is not None:
        about = {
            "pair": config.pair_name,
            "shape": shape,
            "aspect": aspect,
            "alpha_deg": alpha,
            "speed": speed,
            "spin": spin,
            "seed": seed,
        }
        write_text(statistics_file, json.dumps(about | statistics.to_dict(), indent=1) + "\n")
    return DONE


def _write_rebounds(path: Path, result: Simulation) -> None:
    with atomic_output(path) as temporary, open(temporary, "wb") as file:
        np.savez(
            file,
            state=result.state,
            collisions=result.collisions,
            shape=result.shape,
            aspect=result.aspect,
            energy=result.energy,
        )


def _chosen_particles(
    population: Population,
    shape: str | None,
    particle: Path | None,
    aspect: tuple[float, float] | None,
) -> Population:
    """Part of a population, or the particle of a mesh, that the flags of `simulate` ask for."""
    if (shape is None) == (particle is None):
        given = "missing" if shape is None else "got both"
        raise InputError(f"'--shape' or '--particle': {given}, allowed: one of them")
    if shape is not None:
        population = population.restricted_to(shape)
        return population if aspect is None else population.with_aspect(*aspect)
    assert particle is not None
    if aspect is not None:
        raise InputError(
            f"aspect: got [{aspect[0]:g}, {aspect[1]:g}] with --particle, "
            "allowed with --shape only: a mesh has its own"
        )
    mesh = read_mesh(particle)
    if not mesh.is_convex:
        click.echo(
            f"tablegen: note: {mesh.name} is not convex; its convex hull, which has "
            f"{1.0 / mesh.solidity:.4g} times its volume, takes its place",
            err=True,
        )
    return population.of_mesh(mesh)
