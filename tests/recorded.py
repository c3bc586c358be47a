"""Arrays written as a CSV file and read back as a recording."""

import numpy as np

import stickslip as ss


def recording(tmp_path, rig, t, x1, y1, belt_speed, name, noise):
    columns = [t, x1] if y1 is None else [t, x1, y1]
    names = ("t", "x1", "y1")[: len(columns)]
    path = tmp_path / f"{name}.csv"
    np.savetxt(
        path, np.column_stack(columns), delimiter=",", header=",".join(names), comments="", fmt="%.12g"
    )
    channels = {n: ss.Channel(n) for n in names}
    stds = dict.fromkeys(names[1:], noise)
    return ss.load_recording(path, rig, channels=channels, belt_speed=belt_speed, noise=stds, name=name)
