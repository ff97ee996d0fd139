"""The nouns of refdem (docs: CONTRIBUTING.md), the store of runs and discovery by folder and entry
point.
"""
