"""What a log says: reading it, the paper's metrics, figures, a summary, tables for others.

from tendond.offline.logs import load
run = load("run.mcap")
run["measured"], run.units["measured"]
"""

from tendond.offline.logs.arrays import Arrays, load

__all__ = ["Arrays", "load"]
