"""A build with MCAP: a bag of ROS 2 as a log. Run by `cargo xtask ray`, from the project's root."""

import pytest

import courier


def test_a_bag_is_read_as_a_log():
    few = "stretches of .* wanted 4 or more: a longer motion"
    # The file has a handful of samples, in which noise cannot be told from motion either.
    with pytest.warns(courier.RecordingWarning, match="may be motion"):
        with pytest.raises(courier.InputError, match=few):
            courier.encoder("bag/tests/files/rosbags.mcap", columns={"p1_m": "position[elbow]:rad"})
