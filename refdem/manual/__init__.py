"""The verification manual: for each case what is claimed, how it is proved and witnessed, which
checks apply; slips of the source.
"""
