"""Analysis of gaits, gait files, and gaits on changed bodies."""

from gaitsim import gait as gait
from gaitsim.gait import (
    Footfalls as Footfalls,
    GaitAnalysis as GaitAnalysis,
    analyse_individual as analyse_individual,
)
from gaitsim.gait.changed import (
    can_be_damaged as can_be_damaged,
    damage_body as damage_body,
    has_rhythm_on_twin as has_rhythm_on_twin,
    has_twin as has_twin,
    play_on as play_on,
    play_on_twin as play_on_twin,
    put_in_world as put_in_world,
    rhythm_on_twin as rhythm_on_twin,
    twin_of as twin_of,
    with_body as with_body,
    with_changed_body as with_changed_body,
    with_damage as with_damage,
)
from gaitsim.gait.channels import (
    Columns as Columns,
    channels_of as channels_of,
    count_trials as count_trials,
    entries_of as entries_of,
    motion_columns as motion_columns,
    own_name as own_name,
    place_of as place_of,
    read_values as read_values,
)
from gaitsim.gait.feet import Floats as Floats, Stride as Stride, feet_of as feet_of
from gaitsim.gait.gait_files import (
    SUFFIXES as SUFFIXES,
    Gait as Gait,
    GaitFile as GaitFile,
    check_folder as check_folder,
    check_parent as check_parent,
    fit_to_body as fit_to_body,
    gait_of as gait_of,
    read_bounded as read_bounded,
    read_gait as read_gait,
    read_npz as read_npz,
    write_gait as write_gait,
)
from gaitsim.gait.repertoire import (
    RepertoireGait as RepertoireGait,
    gaits_of as gaits_of,
    patterns as patterns,
)
from gaitsim.gait.report import (
    commanded_frequency as commanded_frequency,
    frames_before_fall as frames_before_fall,
    vertical_loads as vertical_loads,
    weight_of as weight_of,
)
