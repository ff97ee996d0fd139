"""The certified store: sets that are proved, and proved again."""
