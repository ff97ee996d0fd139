"""Kratos' analysis of a scene: its start as the scene has it, its states at the samples kept."""

import KratosMultiphysics as kratos  # noqa: N813
from KratosMultiphysics.DEMApplication.DEM_analysis_stage import DEMAnalysisStage


class Recorded(DEMAnalysisStage):
    """Bodies as the request has them.

    `rows` are those of the trajectory, with the attitudes of the start.
    """

    def __init__(self, settings, bodies, times, stride):
        kratos.ParallelUtilities.SetNumThreads(1)
        super().__init__(kratos.Model(), kratos.Parameters(settings))
        self.bodies = bodies
        self.times = times
        self.stride = stride
        self.steps = 0
        self.rows = []

    def Initialize(self):  # noqa: N802
        """Kratos reads no velocities from nodes that it has not made yet."""
        super().Initialize()
        for node, body in zip(self.spheres_model_part.Nodes, self.bodies, strict=True):
            node.SetSolutionStepValue(kratos.VELOCITY, body["velocity"])
            node.SetSolutionStepValue(kratos.ANGULAR_VELOCITY, body["omega"])
        self.keep()

    def FinalizeSolutionStep(self):  # noqa: N802
        """Counts the step, and keeps a row where it ends at a sample."""
        super().FinalizeSolutionStep()
        self.steps += 1
        if self.steps % self.stride == 0 and len(self.rows) < len(self.times) * len(self.bodies):
            self.keep()

    def keep(self):
        """Keeps the states at a sample."""
        t = self.times[self.steps // self.stride]
        for n, node in enumerate(self.spheres_model_part.Nodes):
            velocity, omega = (
                list(node.GetSolutionStepValue(name))
                for name in (kratos.VELOCITY, kratos.ANGULAR_VELOCITY)
            )
            self.rows.append(
                (t, n, (node.X, node.Y, node.Z), velocity, self.bodies[n]["attitude"], omega)
            )
