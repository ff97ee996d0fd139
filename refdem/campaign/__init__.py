"""Running everything: plan, worker processes, judging, records."""
