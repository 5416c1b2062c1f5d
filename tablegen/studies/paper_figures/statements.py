"""Statements of the paper's text that can be checked, with what our model and a table say."""

from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from typing import Any

from tablegen.config import Config, load_config
from tablegen.studies.paper_figures import statement_checks as checks
from tablegen.studies.paper_figures.sample_statistics import DIRECT, TABLE, FigureStatistics
from tablegen.studies.paper_figures.statement_checks import Verdict


@dataclass(frozen=True)
class Statement:
    """A statement, how it was checked, and what came out.

    Attributes
    ----------
    place : str
        Where in the paper.
    text : str
        In our words.
    criterion : str
        What was asked for it to hold.
    direct, table : Verdict or None
        None where the source cannot tell.
    """

    place: str
    text: str
    criterion: str
    direct: Verdict | None
    table: Verdict | None

    def to_dict(self) -> dict[str, Any]:
        """Plain values, for JSON."""
        return asdict(self)


#: A check of laws of one source; None where the source cannot tell.
_Check = Callable[[FigureStatistics, str], Verdict | None]

#: Place, text, criterion, check.
_CHECKS: tuple[tuple[str, str, str, _Check], ...] = (
    (
        "Section 2, Figures 3 and 4",
        "The mean and the most probable value of u⁺ and of v⁺ differ much at all impact angles.",
        "the two differ by more than 0.01 V and by 5 standard errors, every shape and angle",
        checks.means_differ_from_modes,
    ),
    (
        "Section 2, Figure 3",
        "At normal impact the most probable u⁺ is zero for every shape but the prism.",
        "the peak of the density of |u⁺| is at zero",
        checks.tangential_mode_is_zero,
    ),
    (
        "Section 2, Figure 5",
        "For prisms at normal impact the density of u⁺ has two equal maxima on both sides of a "
        "minimum at zero.",
        "the density at zero is below 97 % of the maximum, and u⁺ is symmetric",
        checks.prisms_have_two_maxima,
    ),
    (
        "Section 2, table",
        "At normal impact fewer than half of the particles of any shape collide only once.",
        "share of single collisions below 50 %",
        checks.singles_below_half,
    ),
    (
        "Section 2, table",
        "At normal impact the particles of all shapes but ellipsoids mostly collide twice or more "
        "often.",
        "share of repeated collisions above that of single ones, ellipsoids left out",
        checks.repeated_prevail,
    ),
    (
        "Section 2",
        "With falling impact angle the share of single collisions changes, for every shape, not "
        "monotonically.",
        "the share both rises and falls, by 4 standard errors",
        checks.singles_not_monotonic,
    ),
    (
        "Section 2",
        "At every angle and for every shape 25 to 70 % of the particles collide twice or more "
        "often.",
        "smallest and largest share within 25 to 70 %",
        checks.repeated_within_range,
    ),
    (
        "Section 2, Figure 7",
        "The mean and the most probable Ωz are not positive, for every shape and angle.",
        "at most 5 standard errors (mean) and 0.02 V/a (most probable) above zero",
        checks.spin_not_positive,
    ),
    (
        "Section 2",
        "The share of particles with Ωz > 0 grows with the impact angle.",
        "no step down by more than 4 standard errors",
        checks.positive_spin_grows,
    ),
    (
        "Section 2, Figure 8",
        "At normal impact the density of Ωz is symmetric about zero.",
        "asymmetry at most 5 (chance: 1 in 900,000)",
        checks.normal_spin_is_symmetric,
    ),
    (
        "Section 2",
        "The densities of Ωx and Ωy are symmetric about zero at every angle.",
        "asymmetry at most 5 (chance: 1 in 900,000 each), every shape and angle",
        checks.transverse_spin_is_symmetric,
    ),
    (
        "Section 2, Figure 9",
        "Particles lose much kinetic energy in the rebound.",
        "mean loss of kinetic energy, translational and rotational, above 5 % at every angle",
        checks.energy_is_lost,
    ),
    (
        "Section 2, Figure 9",
        "The mean translational energy falls monotonically with rising impact angle.",
        "falls at every step of 5°",
        checks.translational_falls,
    ),
    (
        "Section 2, Figure 9",
        "The mean rotational energy has its maximum at 15 to 20°, for every shape and the mixture.",
        "maximum of a parabola through the highest point and its neighbours within 15 to 20°",
        checks.rotational_peak,
    ),
    (
        "Section 2, Figure 9",
        "Ellipsoids and truncated prisms have the greatest rotational energy.",
        "their maxima are above those of prisms and tetrahedra",
        checks.greatest_rotational,
    ),
    (
        "Section 2, Figure 10",
        "The most probable energies differ much from the mean ones.",
        "translational and rotational differ by more than 0.01 of the energy before, every shape "
        "and angle",
        checks.energies_differ,
    ),
    (
        "Section 3, Figure 13",
        "Reflected particles are scattered considerably at every impact angle.",
        "standard deviation of α₂ of the mixture above 5°",
        checks.scattered_everywhere,
    ),
    (
        "Section 3, Figure 13",
        "The scattering is strongest at normal impact.",
        "standard deviation of α₂ of the mixture is largest at 90°",
        checks.scattering_strongest_at_normal,
    ),
    (
        "Section 3, Figure 13",
        "Below 70° the indicatrix of the mixture has one maximum.",
        "one maximum that stands out by a twentieth of the highest, 5° to 65°",
        checks.one_maximum_below_70,
    ),
    (
        "Section 3, Figure 13",
        "From 70° on the indicatrix of the mixture has two maxima.",
        "two maxima that stand out by a twentieth of the highest, 70° to 90°",
        checks.two_maxima_from_70,
    ),
    (
        "Section 3, Figure 13",
        "Spheres rebound regularly, all at one angle α₂.",
        "range of α₂ over 100 spheres below 10⁻⁹ degrees, every angle",
        checks.spheres_are_regular,
    ),
)

#: What the text says and cannot be checked here, with the reason.
NOT_CHECKED = (
    "A mixture agrees better with the measured velocities than one shape does, and the agreement "
    "is good (Figures 3 and 4): the measured values are in the figures only, not in the text.",
    "No rebound depends on the size of the particle: it holds by construction here, velocities "
    "being in V and angular velocities in V/a.",
)


def is_of_the_paper(config: Config) -> bool:
    """Whether laws and particles are those of the paper, whatever they are called."""

    def matter(of: Config) -> tuple[object, ...]:
        pair = of.pair
        restitution = pair.restitution.model_dump(exclude={"source", "valid_speed"})
        resistance = pair.resistance.model_dump(exclude={"source"})
        return restitution, resistance, of.population.model_dump()

    return matter(config) == matter(load_config("corundum-steel"))


def check_statements(laws: FigureStatistics) -> list[Statement]:
    """Check every statement against direct simulation and the table.

    Parameters
    ----------
    laws : FigureStatistics
        Of another pair or other particles than the paper's, statements are measured but not judged.

    Returns
    -------
    list of Statement
    """
    judged = is_of_the_paper(laws.config)

    def verdict(check: _Check, source: str) -> Verdict | None:
        found = check(laws, source)
        return found if found is None or judged else replace(found, holds=None)

    return [
        Statement(place, text, criterion, verdict(check, DIRECT), verdict(check, TABLE))
        for place, text, criterion, check in _CHECKS
    ]
