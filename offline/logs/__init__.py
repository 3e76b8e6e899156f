"""Reading logs: arrays, events, the paper's metrics, a summary, tables for other programs.

from tendond.offline.logs import load
run = load("run.mcap")
run["measured"], run.units["measured"]
"""

from tendond.offline.logs.arrays import Arrays, load

__all__ = ["Arrays", "load"]
