

def test_the_motion_of_one_individual_computes_its_channels_when_they_are_read():
    calls = []

    def double():
        calls.append(1)
        return {"double": 2 * np.arange(3.0), "half": np.arange(3.0) / 2}

    motion = Motion(10.0, {"x": np.arange(3.0)}, {("double", "half"): double}, {2: "it fell"})
    one, last = motion.of(1), motion.of(2)
    assert not calls and [*one] == ["x", "double", "half"]
    assert one["x"].tolist() == [1] and one["half"].tolist() == [0.5] and not one.failures
    assert last["double"].tolist() == [4] and last.failures == {0: "it fell"} and len(calls) == 1
