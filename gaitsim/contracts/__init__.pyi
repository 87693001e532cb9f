"""The contracts of plugins: the base classes that plugins extend, and the types that they use."""

from gaitsim.contracts.conditions import (
    SEED as SEED,
    WORLD_HELP as WORLD_HELP,
    Condition as Condition,
    Terrain as Terrain,
    check_world as check_world,
)
from gaitsim.contracts.dimensions import (
    DIMENSIONS_HELP as DIMENSIONS_HELP,
    EVOLVE_HELP as EVOLVE_HELP,
    RANGES_HELP as RANGES_HELP,
    Dimension as Dimension,
    EvolvingChannels as EvolvingChannels,
    check_dimensions as check_dimensions,
    dimension_measures as dimension_measures,
    factor_bounds as factor_bounds,
)
from gaitsim.contracts.motion import (
    PRESENT as PRESENT,
    PRESENT_CHANNEL as PRESENT_CHANNEL,
    Array as Array,
    Channel as Channel,
    Measure as Measure,
    Motion as Motion,
    Skeleton as Skeleton,
)
from gaitsim.contracts.organism import (
    BodyFile as BodyFile,
    Facts as Facts,
    FittedGait as FittedGait,
    Organism as Organism,
    Question as Question,
)
from gaitsim.contracts.plugin import (
    Plugin as Plugin,
    folder_of as folder_of,
    option as option,
    roots_of as roots_of,
)
from gaitsim.contracts.product import (
    Exported as Exported,
    Exporter as Exporter,
    Names as Names,
    Pair as Pair,
    Plot as Plot,
    Product as Product,
    Subject as Subject,
    Window as Window,
)
from gaitsim.contracts.reflex import (
    COMMAND as COMMAND,
    OBSERVATIONS as OBSERVATIONS,
    SAMPLES as SAMPLES,
    Controller as Controller,
    Inputs as Inputs,
    Legs as Legs,
    Observation as Observation,
    Reflex as Reflex,
    Rhythm as Rhythm,
)
from gaitsim.contracts.rig import Link as Link, Rig as Rig, Solid as Solid
from gaitsim.contracts.search import (
    Context as Context,
    Crossover as Crossover,
    Fitness as Fitness,
    Members as Members,
    Mutation as Mutation,
    Operators as Operators,
    Parents as Parents,
    Results as Results,
    Search as Search,
    Selection as Selection,
    State as State,
    parents_of_children as parents_of_children,
)
from gaitsim.contracts.space import (
    BitSpace as BitSpace,
    Genomes as Genomes,
    GenomeSpace as GenomeSpace,
    RealSpace as RealSpace,
)
from gaitsim.contracts.steering import (
    Command as Command,
    Steered as Steered,
)
