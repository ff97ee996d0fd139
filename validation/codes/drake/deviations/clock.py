"""Drake's simulator does not always take a step where its user advances by a step.

A discrete plant steps at whole multiples of its period, and the simulator compares times: a target
that a sum of steps has rounded down lies before the step that was meant, which is left for the
next. Here the targets are varied: sums of steps, and whole multiples, of which each is one
step. The driver asks the plant itself for each step.
"""

from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.analysis import Simulator

COUNT = 1000  # steps that are asked for


def taken(step, is_summed):
    """The steps of the plant in each of COUNT calls."""
    plant = MultibodyPlant(time_step=step)
    plant.Finalize()
    simulator = Simulator(plant)
    simulator.Initialize()
    context = simulator.get_context()
    found = []
    before = 0
    for number in range(1, COUNT + 1):
        target = number * step
        if is_summed:
            target = context.get_time() + step
        simulator.AdvanceTo(target)
        updates = simulator.get_num_discrete_updates() + simulator.get_num_unrestricted_updates()
        found.append(updates - before)
        before = updates
    return found


for step in (2.0**-7, 0.01, 0.001, 1 / 30, 0.7):
    for is_summed, name in ((True, "sums of steps"), (False, "whole multiples")):
        found = taken(step, is_summed)
        calls = {number: found.count(number) for number in sorted(set(found))}
        print(f"{step:.6f} s, {name}: {sum(found)} steps in {COUNT} calls; calls by steps: {calls}")
