import doctest
import math

import numpy as np
import pytest

import gaitsim.encoding
from gaitsim.encoding import GeneGroup, genome_space, split_genomes

GROUPS = (
    GeneGroup("amplitude", ("hip", "knee"), 0.0, [0.5, 0.25]),
    GeneGroup("phase", ("left", "right"), -math.pi, math.pi, periodic=True).halved(math.pi),
    GeneGroup("frequency", ("",), 0.5, 2.0),
)


def test_a_genome_space_has_a_labelled_gene_for_each_part_of_each_group():
    space = genome_space(GROUPS)
    assert space.labels == ("hip amplitude", "knee amplitude", "left phase", "frequency")
    assert space.lower.tolist() == [0, 0, -math.pi, 0.5]
    assert space.upper.tolist() == [0.5, 0.25, math.pi, 2]
    assert space.periodic.tolist() == [False, False, True, False]


def test_values_are_split_by_group_and_mirrored():
    genomes = np.array([[0.1, 0.2, 1.0, 1.5], [0.3, 0.4, -1.0, 0.7]])
    amplitude, phase, frequency = split_genomes(genomes, GROUPS)
    np.testing.assert_array_equal(amplitude, genomes[:, :2])
    np.testing.assert_array_equal(phase, [[1, 1 + math.pi], [-1, -1 + math.pi]])
    np.testing.assert_array_equal(frequency, genomes[:, 3:])


@pytest.mark.parametrize("shape", [(4,), (2, 5)])
def test_genomes_of_another_length_are_refused(shape):
    with pytest.raises(ValueError, match=r"\(population, 4\)"):
        split_genomes(np.zeros(shape), GROUPS)


def test_bounds_must_match_the_parts():
    with pytest.raises(ValueError, match="broadcast"):
        genome_space([GeneGroup("amplitude", ("hip", "knee"), 0.0, [1.0, 1.0, 1.0])])


def test_the_example_of_the_documentation_works() -> None:
    assert doctest.testmod(gaitsim.encoding) == doctest.TestResults(failed=0, attempted=9)
