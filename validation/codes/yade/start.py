"""Starts YADE with driver.py, whose answers go to the standard output of this program.

YADE greets on standard output before it runs a script. Here that becomes standard error, and the
driver finds the number of the standard output in the environment.
"""

import os
import sys
from pathlib import Path

answers = os.dup(1)
os.set_inheritable(answers, True)
os.dup2(2, 1)
os.environ["ANSWERS"] = str(answers)
driver = Path(__file__).with_name("driver.py")
os.execvp("yade", ["yade", "-x", "-n", str(driver), *sys.argv[1:]])
