"""The parts of plugins: contracts, options, errors, and the plugins of other packages.

Packages import this module, those beside it and `gaitsim.screen`, and nothing deeper. Its stub
lists the names, which are imported at first use.
"""

from gaitsim import registry as registry, toml as toml
from gaitsim.arguments import (
    ARGUMENTS as ARGUMENTS,
    as_overrides as as_overrides,
    check_workers as check_workers,
    warn as warn,
)
from gaitsim.choices import (
    DAMAGE_HELP as DAMAGE_HELP,
    Activation as Activation,
    ComparisonPlot as ComparisonPlot,
    GaitFormat as GaitFormat,
    OutputActivation as OutputActivation,
    PlotFormat as PlotFormat,
    TrainingPreset as TrainingPreset,
)
from gaitsim.contracts import (
    COMMAND as COMMAND,
    DIMENSIONS_HELP as DIMENSIONS_HELP,
    EVOLVE_HELP as EVOLVE_HELP,
    OBSERVATIONS as OBSERVATIONS,
    PRESENT as PRESENT,
    PRESENT_CHANNEL as PRESENT_CHANNEL,
    RANGES_HELP as RANGES_HELP,
    SAMPLES as SAMPLES,
    SEED as SEED,
    WORLD_HELP as WORLD_HELP,
    Array as Array,
    BitSpace as BitSpace,
    BodyFile as BodyFile,
    Channel as Channel,
    Command as Command,
    Condition as Condition,
    Context as Context,
    Controller as Controller,
    Crossover as Crossover,
    Dimension as Dimension,
    EvolvingChannels as EvolvingChannels,
    Exported as Exported,
    Exporter as Exporter,
    Facts as Facts,
    Fitness as Fitness,
    FittedGait as FittedGait,
    Genomes as Genomes,
    GenomeSpace as GenomeSpace,
    Inputs as Inputs,
    Legs as Legs,
    Link as Link,
    Measure as Measure,
    Members as Members,
    Motion as Motion,
    Mutation as Mutation,
    Names as Names,
    Observation as Observation,
    Operators as Operators,
    Organism as Organism,
    Pair as Pair,
    Parents as Parents,
    Plot as Plot,
    Plugin as Plugin,
    Product as Product,
    Question as Question,
    RealSpace as RealSpace,
    Reflex as Reflex,
    Results as Results,
    Rhythm as Rhythm,
    Rig as Rig,
    Search as Search,
    Selection as Selection,
    Skeleton as Skeleton,
    Solid as Solid,
    State as State,
    Steered as Steered,
    Subject as Subject,
    Terrain as Terrain,
    Window as Window,
    check_dimensions as check_dimensions,
    check_world as check_world,
    dimension_measures as dimension_measures,
    factor_bounds as factor_bounds,
    folder_of as folder_of,
    option as option,
    parents_of_children as parents_of_children,
    roots_of as roots_of,
)
from gaitsim.contracts.product import Input as Input
from gaitsim.contracts.quaternions import (
    conjugate as conjugate,
    product as product,
    rotated as rotated,
    turn_about as turn_about,
    turn_about_axis as turn_about_axis,
)
from gaitsim.contracts.reflex import Floats as Floats
from gaitsim.contracts.rig import Shape as Shape
from gaitsim.contracts.search import STATE_DTYPES as STATE_DTYPES
from gaitsim.errors import (
    ContractError as ContractError,
    ExperimentError as ExperimentError,
    GaitsimError as GaitsimError,
    NothingToPlotError as NothingToPlotError,
    PluginError as PluginError,
    RunError as RunError,
    nearest as nearest,
    not_installed as not_installed,
    unknown as unknown,
)
from gaitsim.opening import (
    is_folder as is_folder,
    open_regular as open_regular,
    read_regular as read_regular,
)
from gaitsim.registry import (
    COMMANDS as COMMANDS,
    EXPERIMENTS as EXPERIMENTS,
    FILES as FILES,
    KINDS as KINDS,
    PLUGINS as PLUGINS,
    PRODUCTS as PRODUCTS,
    REFLEX as REFLEX,
    STUDIES as STUDIES,
    Entry as Entry,
    call_reflex as call_reflex,
    contract_error as contract_error,
    entries as entries,
    find as find,
    load_class as load_class,
    load_engine as load_engine,
    load_entry as load_entry,
    load_reflexes as load_reflexes,
    options as options,
    plugin_errors as plugin_errors,
)
from gaitsim.registry.entry_points import normalized as normalized
from gaitsim.registry.loading import read_preset as read_preset
from gaitsim.registry.options import OPERATORS as OPERATORS, PLUGIN as PLUGIN
from gaitsim.repr_mixin import ReprField as ReprField, ReprMixin as ReprMixin
from gaitsim.toml import (
    brief as brief,
    checksum as checksum,
    literal as literal,
    shortened as shortened,
)
