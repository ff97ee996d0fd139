"""What a campaign runs, and how the results are judged."""
