"""Adapters: one file or small folder an engine, found by itself; none is imported unless asked
for.
"""
