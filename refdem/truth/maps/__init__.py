"""Iterates of maps, proved: logistic map and equation, billiards by unfolding and by proven
itineraries, Feigenbaum's numbers.
"""
