"""The computed figures of the chapter, each from the project's own runs: one figure a file in
figures/.
"""
