"""What a campaign runs, and how what comes back is judged."""
