"""Drake's simulator does not always take a step where its user advances by a step.

A discrete plant steps at whole multiples of its period, and the simulator compares times: a target
that a sum of steps has rounded down lies before the step that was meant, which is left for the
next. The documentation of `AdvanceTo` says that updates at the very end are left for the next call;
the last step is always one of these. The driver asks the plant itself for each step.
"""

from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.analysis import Simulator

COUNT = 1000  # steps that are asked for

for step in (2.0**-7, 0.01, 0.001, 1 / 30, 0.7):
    plant = MultibodyPlant(time_step=step)
    plant.Finalize()
    simulator = Simulator(plant)
    simulator.Initialize()
    context = simulator.get_context()
    taken = []
    before = 0
    for _ in range(COUNT):
        simulator.AdvanceTo(context.get_time() + step)
        updates = simulator.get_num_discrete_updates() + simulator.get_num_unrestricted_updates()
        taken.append(updates - before)
        before = updates
    counts = {number: taken.count(number) for number in sorted(set(taken))}
    print(f"step {step:.6f} s: {sum(taken)} steps in {COUNT} calls; calls by their steps: {counts}")
