"""One figure a file: `fig_1_15.py` has figure 1.15 as the function `figure()`."""
