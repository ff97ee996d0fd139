"""Known faults, and the transparent engine that carries them: what shows that the checks see."""
