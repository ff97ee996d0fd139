"""Adapters, one file or small folder per engine. They are discovered automatically, and each is
imported only when it is used.
"""
